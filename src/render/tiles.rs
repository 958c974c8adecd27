//! All pixels of a picture, tile by tile, over all threads.

use super::sampling::{JITTER_SAMPLES, jitter_offset};
use super::trace::Tracer;
use crate::args::RenderArgs;
use crate::camera::PixelGrid;
use crate::film::{Film, Pixel, average, tent_average};
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
    let shared = Mutex::new((film, RayCounts::default(), 0));
    (0..tiles).into_par_iter().for_each(|index| {
        let (column, row) = (index as u32 % columns, index as u32 / columns);
        let tile = Tile {
            x: column * TILE,
            row: row * TILE,
            width: TILE.min(args.width - column * TILE),
            height: TILE.min(args.height - row * TILE),
        };
        let mut sampler = Sampler::new(scene, plan, args);
        let pixels = sampler.tile(&tile);
        // A poisoned lock means that another thread has panicked, and that panic is on its way up.
        let Ok(mut guard) = shared.lock() else { return };
        let (film, counts, done) = &mut *guard;
        film.set_tile(tile.x, tile.row, tile.width, &pixels);
        *counts += sampler.tracer.counts;
        *done += 1;
        progress.advance(*done, tiles);
    });
    let (film, counts, _) = shared.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    (film, counts)
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
}

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
        }
    }

    fn tile(&mut self, tile: &Tile) -> Vec<Pixel> {
        let rows = tile.row..tile.row + tile.height;
        let columns = || tile.x..tile.x + tile.width;
        let places = rows.flat_map(|row| columns().map(move |x| (x, row)));
        places.map(|(x, row)| self.pixel(x, row)).collect()
    }

    /// A pixel of the picture: with `-filter`, nine pixels of the finer grid.
    fn pixel(&mut self, x: u32, row: u32) -> Pixel {
        if !self.args.filter {
            return self.grid_pixel(x, row);
        }
        let mut block = [Pixel::default(); 9];
        for (place, pixel) in (0..).zip(&mut block) {
            *pixel = self.grid_pixel(3 * x + place % 3, 3 * row + place / 3);
        }
        tent_average(&block)
    }

    /// A pixel of the traced grid: with `-jitter`, the mean of its samples.
    fn grid_pixel(&mut self, x: u32, row: u32) -> Pixel {
        if !self.args.jitter {
            let pixel = self.sample(x, row, 0.0, 0.0);
            return if self.args.filter { pixel.sanitized() } else { pixel };
        }
        let mut samples = [Pixel::default(); JITTER_SAMPLES as usize];
        for (number, sample) in (0..).zip(&mut samples) {
            let (offset_x, offset_y) = jitter_offset(x, row, number, self.args.seed);
            *sample = self.sample(x, row, offset_x, offset_y).sanitized();
        }
        average(&samples)
    }

    fn sample(&mut self, x: u32, row: u32, offset_x: Real, offset_y: Real) -> Pixel {
        let (ndc_x, ndc_y) = self.grid.ndc(x, row, offset_x, offset_y);
        let seen = self.tracer.see(&self.scene.camera.ray(ndc_x, ndc_y));
        Pixel::of(&seen, self.depth_range)
    }
}
