//! All pixels of a picture, tile by tile, over all threads, with the same number of samples in each.

use super::error_estimate::ErrorSums;
use super::pixel::{Pixel, average, filtered, store};
use super::rays::{RayMaker, SetSizes};
use super::trace::{RUNS_AT_ONCE, Seen, Tracer};
use crate::camera::{PixelGrid, Places};
use crate::film::{Film, Planes};
use crate::objects::run::{RUN, Rays};
use crate::options::Options;
use crate::plan::Plan;
use crate::ray_counts::RayCounts;
use crate::scene::Scene;
use rayon::prelude::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Side of a tile in pixels: small enough to share out evenly, large enough for rays to resemble their neighbours.
const TILE: u32 = 16;

/// Told about every finished tile, from any thread.
pub trait Progress: Sync {
    /// `done` of `total` tiles are finished.
    fn advance(&self, done: usize, total: usize);
}

/// The pixels of a picture, and what they cost.
#[derive(Debug)]
pub struct Frame {
    pub film: Film,
    pub counts: RayCounts,
    /// Of the colours, where the samples tell it.
    pub errors: ErrorSums,
    /// Time that all threads together spent turning samples into pixels, if it was measured.
    pub filter: Option<Duration>,
}

/// Renders what `plan` asks for. Every pixel is a function of its place alone, so that threads change nothing.
pub fn render(scene: &Scene, plan: &Plan, args: &Options, progress: &dyn Progress) -> Frame {
    let tiles = Tile::all(args.width, args.height);
    decode_faces_ahead(scene, plan, args);
    let planes = Planes::wanted_by(args);
    let shared = Mutex::new((Film::new(args.width, args.height, planes), RayCounts::default(), 0));
    let filter_nanoseconds = AtomicU64::new(0);
    let errors: Vec<ErrorSums> = tiles
        .par_iter()
        .map_init(
            || Sampler::new(scene, plan, args),
            |sampler, tile| {
                let mut tile_film = Film::new(tile.width, tile.height, planes);
                store(&sampler.tile(tile), &mut tile_film);
                tile_film.set_errors(sampler.pixel_errors.drain(..));
                // A poisoned lock means that another thread has panicked, and that panic is on its way up.
                let Ok(mut guard) = shared.lock() else { return ErrorSums::default() };
                let (film, counts, done) = &mut *guard;
                film.place(tile.x, tile.row, &tile_film);
                *counts += std::mem::take(&mut sampler.tracer.counts);
                *done += 1;
                progress.advance(*done, tiles.len());
                let filter = std::mem::take(&mut sampler.filter);
                filter_nanoseconds.fetch_add(filter.as_nanos() as u64, Ordering::Relaxed);
                std::mem::take(&mut sampler.errors)
            },
        )
        .collect();
    let (film, counts, _) = shared.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    let filter = args.measure.wants_times().then(|| Duration::from_nanos(filter_nanoseconds.into_inner()));
    Frame { film, counts, errors: ErrorSums::total(&errors), filter }
}

/// Decodes the cube map faces that a few rays reach, before threads wait for one another at the first ray to reach each.
pub fn decode_faces_ahead(scene: &Scene, plan: &Plan, args: &Options) {
    /// Pixels along each side that are tried, and the least picture that is worth it.
    const TRIED: u32 = 32;
    let (true, Some(cube_map)) = (plan.color, &scene.background.cube_map) else { return };
    if args.width < 2 * TRIED || args.height < 2 * TRIED {
        return;
    }
    let grid = PixelGrid { width: args.width, height: args.height };
    let pixel = |i: u32, count: u32| (u64::from(i) * u64::from(count - 1) / u64::from(TRIED - 1)) as u32;
    let rays = (0..TRIED * TRIED).map(|i| {
        let pixel = (pixel(i % TRIED, args.width), pixel(i / TRIED, args.height));
        scene.camera.ray(grid.ndc(grid.place(pixel, (0.0, 0.0))))
    });
    cube_map.decode(&Tracer::new(scene, plan).escaping(rays.collect()));
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug)]
pub struct Tile {
    pub x: u32,
    pub row: u32,
    pub width: u32,
    pub height: u32,
}

impl Tile {
    /// The tiles of a picture, row by row.
    pub fn all(width: u32, height: u32) -> Vec<Self> {
        let rows = (0..height).step_by(TILE as usize);
        rows.flat_map(|row| (0..width).step_by(TILE as usize).map(move |x| (x, row)))
            .map(|(x, row)| Self { x, row, width: TILE.min(width - x), height: TILE.min(height - row) })
            .collect()
    }

    /// Columns and rows of its pixels, row by row.
    pub fn places(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let columns = self.x..self.x + self.width;
        (self.row..self.row + self.height).flat_map(move |row| columns.clone().map(move |x| (x, row)))
    }
}

/// Turns pixels into rays and what they see into pixels.
struct Sampler<'a> {
    tracer: Tracer<'a>,
    maker: RayMaker<'a>,
    args: &'a Options,
    sizes: SetSizes,
    errors: ErrorSums,
    /// Empty unless there is to be a picture of them.
    pixel_errors: Vec<f64>,
    filter: Duration,
    /// Rays on their way and what they saw, kept to spare allocations.
    places: Places,
    rays: Rays,
    seen: Vec<Seen>,
}

/// Rays that are made together: few enough for the processor's nearest caches, many enough to share work.
pub const RAYS_AT_ONCE: usize = RUNS_AT_ONCE * RUN;

impl<'a> Sampler<'a> {
    fn new(scene: &'a Scene, plan: &'a Plan, args: &'a Options) -> Self {
        let sizes = SetSizes::new(args);
        Self {
            tracer: Tracer::new(scene, plan),
            maker: RayMaker::new(scene, args, &sizes),
            args,
            sizes,
            errors: ErrorSums::default(),
            pixel_errors: Vec::new(),
            filter: Duration::ZERO,
            places: Places::default(),
            rays: Rays::default(),
            seen: Vec::new(),
        }
    }

    fn tile(&mut self, tile: &Tile) -> Vec<Pixel> {
        let places: Vec<_> = tile.places().collect();
        let rays_a_pixel = (self.args.grid_pixels() * self.args.samples()) as usize;
        let pixels_at_once = (RAYS_AT_ONCE / rays_a_pixel).max(1);
        let mut pixels = Vec::with_capacity(places.len());
        places.chunks(pixels_at_once).for_each(|places| self.resolve(places, &mut pixels));
        pixels
    }

    /// Adds some pixels of the picture to `resolved`.
    fn resolve(&mut self, pixels: &[(u32, u32)], resolved: &mut Vec<Pixel>) {
        self.places.clear();
        for &(x, row) in pixels {
            if self.args.filter {
                (0..9).for_each(|part| {
                    self.maker.add_places((3 * x + part % 3, 3 * row + part / 3), &mut self.places);
                });
            } else {
                self.maker.add_places((x, row), &mut self.places);
            }
        }
        self.maker.make_rays(&self.places, &mut self.rays);
        self.tracer.see(&self.rays, &mut self.seen);
        let start = self.args.measure.wants_times().then(Instant::now);
        let rays_a_pixel = self.seen.len() / pixels.len();
        let seen = std::mem::take(&mut self.seen);
        if rays_a_pixel == 1 && !self.args.jitter {
            let first = resolved.len();
            resolved.resize(first + seen.len(), Pixel::default());
            // In place: a pixel is large, and copied more slowly than it is made.
            resolved[first..].iter_mut().zip(&seen).for_each(|(pixel, seen)| self.maker.display(seen, pixel));
        } else {
            resolved.extend(seen.chunks(rays_a_pixel).map(|seen| self.resolved(seen)));
        }
        self.seen = seen;
        self.filter += start.map_or(Duration::ZERO, |start| start.elapsed());
    }

    /// What all rays of a pixel of the picture saw, as one pixel: with `-jitter` the mean of the samples of each pixel
    /// of the traced grid, with `-filter` the filtered block of those.
    fn resolved(&mut self, seen: &[Seen]) -> Pixel {
        match self.sizes {
            SetSizes::One(samples) => self.mean_of(seen, 0..samples as usize),
            SetSizes::Halves(first, second) => {
                let (first, second) = (first as usize, second as usize);
                let halves = [self.mean_of(seen, 0..first), self.mean_of(seen, first..first + second)];
                let levels = self.errors.add_halves(halves.map(|half| half.color));
                self.note_error(levels);
                average(halves.into_iter(), 2)
            }
            SetSizes::Singles(samples) => {
                let mean = self.mean_of(seen, 0..samples as usize);
                let mut deviations = [0.0; 3];
                for sample in 0..samples as usize {
                    let difference = self.mean_of(seen, sample..sample + 1).color - mean.color;
                    for (sum, difference) in deviations.iter_mut().zip(difference.to_array()) {
                        *sum += (difference as f64).powi(2);
                    }
                }
                let levels = self.errors.add(mean.color, deviations, samples);
                self.note_error(levels);
                mean
            }
        }
    }

    fn note_error(&mut self, levels: f64) {
        if self.args.measure.error_map.is_some() {
            self.pixel_errors.push(levels);
        }
    }

    /// The mean of some of the samples of each pixel of the traced grid, filtered.
    fn mean_of(&self, seen: &[Seen], samples: std::ops::Range<usize>) -> Pixel {
        let count = samples.len() as u32;
        let mut grid_pixels = seen.chunks(self.args.samples() as usize).map(|all| {
            let samples = all[samples.clone()].iter().map(|seen| self.maker.displayed(seen).sanitized());
            average(samples, count)
        });
        if self.args.filter { filtered(grid_pixels) } else { grid_pixels.next().unwrap_or_default() }
    }
}
