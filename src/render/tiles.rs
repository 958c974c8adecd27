//! All pixels of a picture, tile by tile, over all threads.

use super::sampling::{JITTER_SAMPLES, jitter_offset};
use super::trace::{Seen, Tracer};
use crate::args::RenderArgs;
use crate::camera::PixelGrid;
use crate::film::{Film, Pixel, average, filtered};
use crate::objects::Ray;
use crate::plan::Plan;
use crate::report::RayCounts;
use crate::scene::Scene;
use rayon::prelude::*;
use std::sync::Mutex;
use vecmath::Real;

/// Side of a tile in pixels: small enough to share out evenly, large enough for rays to resemble their neighbours.
const TILE: u32 = 16;

/// Told about every finished tile, from any thread.
pub trait Progress: Sync {
    /// `done` of `total` tiles are finished.
    fn advance(&self, done: usize, total: usize);
}

/// Renders what `plan` asks for. Every pixel is a function of its place alone, so that threads change nothing.
pub fn render(scene: &Scene, plan: &Plan, args: &RenderArgs, progress: &dyn Progress) -> (Film, RayCounts) {
    let film = Film::new(args.width, args.height, plan);
    let columns = args.width.div_ceil(TILE);
    let tiles = columns as usize * args.height.div_ceil(TILE) as usize;
    decode_faces_ahead(scene, plan, args);
    let shared = Mutex::new((film, RayCounts::default(), 0));
    (0..tiles).into_par_iter().for_each_init(
        || Sampler::new(scene, plan, args),
        |sampler, index| {
            let (column, row) = (index as u32 % columns, index as u32 / columns);
            let tile = Tile {
                x: column * TILE,
                row: row * TILE,
                width: TILE.min(args.width - column * TILE),
                height: TILE.min(args.height - row * TILE),
            };
            let pixels = sampler.tile(&tile);
            // A poisoned lock means that another thread has panicked, and that panic is on its way up.
            let Ok(mut guard) = shared.lock() else { return };
            let (film, counts, done) = &mut *guard;
            film.set_tile(tile.x, tile.row, tile.width, &pixels);
            *counts += std::mem::take(&mut sampler.tracer.counts);
            *done += 1;
            progress.advance(*done, tiles);
        },
    );
    let (film, counts, _) = shared.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    (film, counts)
}

/// Decodes the cube map faces that a few rays reach, before threads wait for one another at the first ray to reach each.
fn decode_faces_ahead(scene: &Scene, plan: &Plan, args: &RenderArgs) {
    /// Pixels along each side that are tried, and the least picture that is worth it.
    const TRIED: u32 = 32;
    let (true, Some(cube_map)) = (plan.color, &scene.background.cube_map) else { return };
    if args.width < 2 * TRIED || args.height < 2 * TRIED {
        return;
    }
    let grid = PixelGrid { width: args.width, height: args.height };
    let pixel = |i: u32, count: u32| (u64::from(i) * u64::from(count - 1) / u64::from(TRIED - 1)) as u32;
    let rays = (0..TRIED * TRIED).map(|i| {
        let (x, row) = (pixel(i % TRIED, args.width), pixel(i / TRIED, args.height));
        let (ndc_x, ndc_y) = grid.ndc(x, row, 0.0, 0.0);
        scene.camera.ray(ndc_x, ndc_y)
    });
    let rays: Vec<Ray> = rays.collect();
    cube_map.decode(&Tracer::new(scene, plan).escaping(&rays));
}

/// A rectangle of pixels.
struct Tile {
    x: u32,
    row: u32,
    width: u32,
    height: u32,
}

/// Turns pixels into rays and what they see into pixels.
struct Sampler<'a> {
    tracer: Tracer<'a>,
    scene: &'a Scene,
    args: &'a RenderArgs,
    /// The grid that is traced: three times as fine with `-filter`.
    grid: PixelGrid,
    depth_range: (Real, Real),
    /// Rays on their way and what they saw, kept to spare allocations.
    rays: Vec<Ray>,
    seen: Vec<Seen>,
}

/// Rays that are traced together: few enough for the processor's nearest cache, many enough to share work.
const RAYS_AT_ONCE: usize = 256;

impl<'a> Sampler<'a> {
    fn new(scene: &'a Scene, plan: &'a Plan, args: &'a RenderArgs) -> Self {
        let finer = if args.filter { 3 } else { 1 };
        let depth = args.depth.as_ref();
        Self {
            tracer: Tracer::new(scene, plan),
            scene,
            args,
            grid: PixelGrid { width: finer * args.width, height: finer * args.height },
            depth_range: depth.map_or((0.0, 1.0), |depth| (depth.min as Real, depth.max as Real)),
            rays: Vec::new(),
            seen: Vec::new(),
        }
    }

    fn tile(&mut self, tile: &Tile) -> Vec<Pixel> {
        let columns = tile.x..tile.x + tile.width;
        let rows = tile.row..tile.row + tile.height;
        let places: Vec<_> = rows.flat_map(|row| columns.clone().map(move |x| (x, row))).collect();
        let rays_a_pixel = self.grid_pixels_a_pixel() * self.samples_a_grid_pixel() as usize;
        let pixels_at_once = (RAYS_AT_ONCE / rays_a_pixel).max(1);
        places.chunks(pixels_at_once).flat_map(|places| self.pixels(places)).collect()
    }

    fn grid_pixels_a_pixel(&self) -> usize {
        if self.args.filter { 9 } else { 1 }
    }

    fn samples_a_grid_pixel(&self) -> u32 {
        if self.args.jitter { JITTER_SAMPLES } else { 1 }
    }

    /// Some pixels of the picture.
    fn pixels(&mut self, places: &[(u32, u32)]) -> Vec<Pixel> {
        self.rays.clear();
        for &(x, row) in places {
            if self.args.filter {
                (0..9).for_each(|place| self.add_rays(3 * x + place % 3, 3 * row + place / 3));
            } else {
                self.add_rays(x, row);
            }
        }
        self.tracer.see(&self.rays, &mut self.seen);
        let rays_a_pixel = self.seen.len() / places.len();
        self.seen.chunks(rays_a_pixel).map(|seen| self.resolved(seen)).collect()
    }

    /// Adds the rays of a pixel of the traced grid.
    fn add_rays(&mut self, x: u32, row: u32) {
        for sample in 0..self.samples_a_grid_pixel() {
            let (offset_x, offset_y) =
                if self.args.jitter { jitter_offset(x, row, sample, self.args.seed) } else { (0.0, 0.0) };
            let (ndc_x, ndc_y) = self.grid.ndc(x, row, offset_x, offset_y);
            self.rays.push(self.scene.camera.ray(ndc_x, ndc_y));
        }
    }

    /// What all rays of a pixel of the picture saw, as one pixel: with `-jitter` the mean of the samples of each pixel
    /// of the traced grid, with `-filter` the filtered block of those.
    fn resolved(&self, seen: &[Seen]) -> Pixel {
        let displayed = |seen: &Seen| Pixel::of(seen, self.depth_range);
        if let ([seen], false) = (seen, self.args.jitter) {
            return displayed(seen);
        }
        let mut grid_pixels = seen.chunks(self.samples_a_grid_pixel() as usize).map(|samples| {
            let samples = samples.iter().map(|seen| displayed(seen).sanitized());
            average(samples, self.samples_a_grid_pixel())
        });
        if self.args.filter { filtered(grid_pixels) } else { grid_pixels.next().unwrap_or_default() }
    }
}
