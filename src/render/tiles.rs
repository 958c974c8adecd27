//! [`Tile`]s: the pieces of a picture that threads render.

use crate::camera::PixelGrid;
use crate::options::{Options, Region};
use crate::plan::Plan;
use crate::scene::Scene;
use crate::trace::escape_direction;
use std::ops::Range;

/// Side of a tile in pixels: so small that all threads get the same work, so large that many neighbouring rays go
/// together.
const TILE: u32 = 16;

/// Where there are so many tiles, they are rendered one by one; of more, several at once.
const TILES_TO_SHARE: usize = 4096;
/// Largest number of tiles that one thread renders at once.
const LONGEST_RUN: usize = 8;

/// Called for every finished tile, from any thread.
pub trait Progress: Sync {
    /// `done` of `total` tiles are finished.
    fn advance(&self, done: usize, total: usize);

    /// As many more rays were traced.
    fn add_rays(&self, _count: u64) {}
}

/// Tells nobody.
pub struct Silent;

impl Progress for Silent {
    fn advance(&self, _done: usize, _total: usize) {}
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug)]
pub struct Tile {
    pub x: u32,
    pub row: u32,
    pub width: u32,
    pub height: u32,
}

/// The tiles of a part of a picture, row by row. A row of tiles is a *band*.
#[derive(Clone, Copy, Debug)]
pub struct Tiles {
    pub region: Region,
}

impl Tiles {
    /// Returns the number of all tiles.
    pub fn count(&self) -> usize {
        self.columns() * self.region.height.div_ceil(TILE) as usize
    }

    /// Returns the number of tiles in a band.
    pub fn columns(&self) -> usize {
        self.region.width.div_ceil(TILE) as usize
    }

    /// Returns the number of runs of a band: of neighbouring tiles that one thread renders at once. In a large picture they
    /// are longer, so that threads meet less often; in a small one each tile is a run, so that all end at the same time.
    pub fn runs(&self) -> usize {
        self.columns().div_ceil(self.run())
    }

    /// Returns the numbers of the tiles of a run of a band.
    pub fn of_run(&self, band: usize, run: usize) -> Range<usize> {
        let (first, end) = (run * self.run(), self.columns().min((run + 1) * self.run()));
        band * self.columns() + first..band * self.columns() + end
    }

    /// Returns the number of tiles of a run.
    fn run(&self) -> usize {
        (self.count() / TILES_TO_SHARE).clamp(1, LONGEST_RUN)
    }

    /// Returns a tile by its number, at its place in the picture.
    pub fn tile(&self, number: usize) -> Tile {
        let (x, row) = ((number % self.columns()) as u32 * TILE, (number / self.columns()) as u32 * TILE);
        let Region { width, height, .. } = self.region;
        let (width, height) = (TILE.min(width - x), TILE.min(height - row));
        Tile { x: self.region.x + x, row: self.region.row + row, width, height }
    }

    /// Returns the number of a tile.
    pub fn number_of(&self, tile: &Tile) -> usize {
        let (column, row) = ((tile.x - self.region.x) / TILE, (tile.row - self.region.row) / TILE);
        row as usize * self.columns() + column as usize
    }

    /// Returns the pixels of a whole band.
    pub fn band_pixels(&self) -> u64 {
        u64::from(self.region.width) * u64::from(TILE)
    }
}

impl Tile {
    /// Returns the tiles of a picture, row by row.
    pub fn all(width: u32, height: u32) -> Vec<Self> {
        let tiles = Tiles { region: Region::whole(width, height) };
        (0..tiles.count()).map(|number| tiles.tile(number)).collect()
    }

    /// Returns the smallest rectangle that contains both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        let (x, row) = (self.x.min(other.x), self.row.min(other.row));
        let right = (self.x + self.width).max(other.x + other.width);
        let bottom = (self.row + self.height).max(other.row + other.height);
        Self { x, row, width: right - x, height: bottom - row }
    }

    /// Returns the number of a pixel of the rectangle, row by row.
    pub fn index_of(&self, (x, row): (u32, u32)) -> usize {
        (row - self.row) as usize * self.width as usize + (x - self.x) as usize
    }

    /// Replaces `pixels` by columns and rows of the tile's pixels, row by row.
    pub fn list_pixels(&self, pixels: &mut Vec<(u32, u32)>) {
        pixels.clear();
        // An inner loop without branches takes a tenth of the instructions that one iterator over all takes.
        for row in self.row..self.row + self.height {
            pixels.extend((self.x..self.x + self.width).map(|x| (x, row)));
        }
    }

    /// Iterates over columns and rows of the tile's pixels, row by row.
    pub fn pixels(&self) -> Pixels {
        Pixels {
            left: self.x,
            right: self.x + self.width,
            bottom: self.row + self.height,
            next: (self.x, self.row),
        }
    }
}

/// The pixels of a tile: three times as fast as iterators in one another.
pub struct Pixels {
    left: u32,
    right: u32,
    bottom: u32,
    next: (u32, u32),
}

impl Iterator for Pixels {
    type Item = (u32, u32);

    #[inline]
    fn next(&mut self) -> Option<(u32, u32)> {
        let pixel @ (x, row) = self.next;
        if row == self.bottom {
            return None;
        }
        self.next = if x + 1 == self.right { (self.left, row + 1) } else { (x + 1, row) };
        Some(pixel)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let (x, row) = self.next;
        let rest = (self.bottom - row) * (self.right - self.left) - (x - self.left);
        (rest as usize, Some(rest as usize))
    }
}

/// Decodes in parallel the cube map faces that a few rays reach. Otherwise all threads would wait for one thread that
/// decodes the first face.
pub fn decode_faces_ahead(scene: &Scene, plan: &Plan, options: &Options) {
    /// Number of pixels along each side that are traced.
    const TRIED: u32 = 16;
    /// Number of mirrors that are followed.
    const MIRRORS: u32 = 4;
    let (true, Some(cube_map)) = (plan.color, &scene.background.cube_map) else { return };
    let shown = options.shown();
    // For few pixels this takes longer than it saves.
    if options.pixel_count() < u64::from(4 * TRIED).pow(2) {
        return;
    }
    let grid = PixelGrid { width: options.width, height: options.height };
    let pixel = |i: u32, count: u32| (u64::from(i) * u64::from(count - 1) / u64::from(TRIED - 1)) as u32;
    let rays = (0..TRIED * TRIED).map(|i| {
        let pixel = (shown.x + pixel(i % TRIED, shown.width), shown.row + pixel(i / TRIED, shown.height));
        scene.camera.ray(grid.ndc(grid.place(pixel, (0.0, 0.0))))
    });
    let directions: Vec<_> = rays.filter_map(|ray| escape_direction(scene, plan, ray, MIRRORS)).collect();
    cube_map.decode(&directions);
}
