//! All pixels of a picture with as many samples as an error or a time asks for, in waves over the whole picture.
//!
//! Each pixel has two halves that are sampled independently of each other; they tell its error (see
//! [`error_estimate`](super::error_estimate)). With a target error, pilot samples that are then thrown away decide how the samples
//! are shared out (see [`allocation`](super::allocation)), and only the error of the whole picture decides when to stop:
//! so every pixel is right in the mean but for its own weight in the whole, which is one of all pixels.

use super::allocation::{Allocation, PILOT_SAMPLES};
use super::error_estimate::ErrorSums;
use super::pixel::{Pixel, store};
use super::rays::{RayMaker, SetSizes};
use super::samples::SamplePattern;
use super::tiles::{Frame, Progress, RAYS_AT_ONCE, Tile, decode_faces_ahead};
use super::trace::{Seen, Tracer};
use crate::camera::Places;
use crate::film::{Film, Planes};
use crate::measure::Sampling;
use crate::objects::run::Rays;
use crate::options::{Options, SamplerKind};
use crate::plan::Plan;
use crate::ray_counts::RayCounts;
use crate::scene::Scene;
use rayon::prelude::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;
use vecmath::{Real, Vector3};

/// The pixels of a tile so far.
struct TileState {
    tile: Tile,
    /// Samples in each half, a pixel.
    samples: Vec<u32>,
    /// Sums of colours in each half, a pixel.
    colors: Vec<[Vector3; 2]>,
    /// Sums of the rest over both halves, a pixel; empty unless depths or normals are asked for.
    others: Vec<Pixel>,
    counts: RayCounts,
}

/// A picture in the making.
struct Progressive<'a> {
    scene: &'a Scene,
    plan: &'a Plan,
    args: &'a Options,
    maker: RayMaker<'a>,
    /// Nothing is begun after this.
    deadline: Option<Instant>,
    tiles: Vec<Mutex<TileState>>,
    progress: &'a dyn Progress,
    waves: u32,
}

/// The numbers of sample sets: those of the picture's halves begin at 0, so the pilot's lies far away.
const PILOT_SET: u32 = 1 << 30;

/// Renders until `args.measure` is content or `deadline` has come; a whole picture comes out in any case.
pub fn render(
    scene: &Scene,
    plan: &Plan,
    args: &Options,
    deadline: Option<Instant>,
    progress: &dyn Progress,
) -> (Frame, Sampling) {
    decode_faces_ahead(scene, plan, args);
    let with_others = plan.depth || plan.normals;
    let tiles = Tile::all(args.width, args.height).into_iter().map(|tile| {
        let pixels = (tile.width * tile.height) as usize;
        Mutex::new(TileState {
            tile,
            samples: vec![0; pixels],
            colors: vec![[Vector3::ZERO; 2]; if plan.color { pixels } else { 0 }],
            others: vec![Pixel::default(); if with_others { pixels } else { 0 }],
            counts: RayCounts::default(),
        })
    });
    let mut picture = Progressive {
        scene,
        plan,
        args,
        maker: RayMaker::new(scene, args, &SetSizes::One(1)),
        deadline,
        tiles: tiles.collect(),
        progress,
        waves: 0,
    };
    let preview = deadline.map(|_| picture.preview());
    match args.measure.target_error {
        Some(levels) => picture.sample_to_error(levels),
        None => picture.sample_evenly(),
    }
    picture.finished(preview)
}

impl Progressive<'_> {
    /// As many samples in every pixel as without a time limit.
    fn sample_evenly(&mut self) {
        let goal = (self.args.samples() * self.args.grid_pixels()).div_ceil(2);
        let mut samples = 1;
        while self.wave(|_| samples.min(goal)) && samples < goal {
            samples *= 2;
        }
    }

    fn sample_to_error(&mut self, levels: f64) {
        let aim = levels * levels;
        if !self.wave(|_| 1) {
            return;
        }
        let Some(variances) = self.pilot() else { return };
        let order = self.args.measure.sampler.convergence_order();
        let mut allocation = Allocation::new(&variances, self.args.width as usize, order);
        // The first wave shows how good the model is; it should not overshoot.
        let mut margin = 1.5;
        while self.mean_square_error() > aim {
            if !allocation.raise(margin * aim) || !self.wave(|pixel| allocation.goal(pixel)) {
                return;
            }
            allocation.calibrate(self.mean_square_error());
            margin = 0.95;
        }
    }

    /// In squared levels.
    fn mean_square_error(&self) -> f64 {
        self.errors().estimate().map_or(0.0, |estimate| estimate.levels.rmse.powi(2))
    }

    fn is_late(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Brings every pixel to `goal` samples in each half; false if there was no time for all of them.
    fn wave(&mut self, goal: impl Fn(usize) -> u32 + Sync) -> bool {
        let done = AtomicUsize::new(0);
        let wave = self.waves;
        self.waves += 1;
        self.tiles.par_iter().for_each(|state| {
            // A poisoned lock means that another thread has panicked, and that panic is on its way up.
            if let (false, Ok(mut state)) = (self.is_late(), state.lock()) {
                self.advance_tile(&mut state, wave, &goal);
                self.progress.advance(done.fetch_add(1, Ordering::Relaxed) + 1, self.tiles.len());
            }
        });
        !self.is_late()
    }

    fn advance_tile(&self, state: &mut TileState, wave: u32, goal: &(impl Fn(usize) -> u32 + Sync)) {
        let width = self.args.width as usize;
        let wanted: Vec<(usize, (u32, u32), u32)> = state
            .tile
            .places()
            .enumerate()
            .map(|(index, place)| (index, place, goal(place.1 as usize * width + place.0 as usize)))
            .filter(|&(index, _, goal)| goal > state.samples[index])
            .collect();
        let mut tracer = Tracer::new(self.scene, self.plan);
        let (mut places, mut rays, mut seen) = (Places::default(), Rays::default(), Vec::new());
        let mut waiting = wanted.as_slice();
        while !waiting.is_empty() && !self.is_late() {
            places.clear();
            let mut taken = 0;
            while taken < waiting.len() && places.len() < RAYS_AT_ONCE {
                let (index, pixel, goal) = waiting[taken];
                self.add_places(pixel, wave, state.samples[index]..goal, &mut places);
                taken += 1;
            }
            self.maker.make_rays(&places, &mut rays);
            tracer.see(&rays, &mut seen);
            let mut rest = seen.as_slice();
            for &(index, _, goal) in &waiting[..taken] {
                let added = (goal - state.samples[index]) as usize;
                let (first, second) = (&rest[..added], &rest[added..2 * added]);
                state.add(index, [first, second], |seen| self.maker.displayed(seen).sanitized());
                rest = &rest[2 * added..];
            }
            waiting = &waiting[taken..];
        }
        state.counts += tracer.counts;
    }

    /// The places of samples of both halves.
    fn add_places(&self, pixel: (u32, u32), wave: u32, samples: std::ops::Range<u32>, places: &mut Places) {
        // A stratified set is whole or worthless, so every wave begins another one.
        let is_stratified = self.args.measure.sampler == SamplerKind::Stratified;
        let (first_set, samples) = if is_stratified { (2 * wave, 0..samples.len() as u32) } else { (0, samples) };
        let pattern = SamplePattern::new(self.args.measure.sampler, samples.len().max(1) as u32);
        for half in 0..2 {
            let set = pattern.set(pixel, first_set + half, self.args.seed);
            samples.clone().for_each(|sample| places.push(self.maker.place_of_sample(pixel, &set, sample)));
        }
    }

    /// Looks at every pixel to see where samples are needed: the variance of single samples in squared levels, or
    /// nothing if there was no time.
    fn pilot(&mut self) -> Option<Vec<f32>> {
        let width = self.args.width as usize;
        let pattern = SamplePattern::new(SamplerKind::Sobol, PILOT_SAMPLES);
        let variances = Mutex::new(vec![0.0; width * self.args.height as usize]);
        self.tiles.par_iter().for_each(|state| {
            let Ok(mut state) = state.lock() else { return };
            let mut tracer = Tracer::new(self.scene, self.plan);
            let pixels: Vec<_> = state.tile.places().collect();
            let (mut places, mut rays, mut seen) = (Places::default(), Rays::default(), Vec::new());
            for pixels in pixels.chunks(RAYS_AT_ONCE / PILOT_SAMPLES as usize) {
                if self.is_late() {
                    return;
                }
                places.clear();
                for &pixel in pixels {
                    let set = pattern.set(pixel, PILOT_SET, self.args.seed);
                    (0..PILOT_SAMPLES)
                        .for_each(|sample| places.push(self.maker.place_of_sample(pixel, &set, sample)));
                }
                self.maker.make_rays(&places, &mut rays);
                tracer.see(&rays, &mut seen);
                let Ok(mut variances) = variances.lock() else { return };
                for (&(x, row), seen) in pixels.iter().zip(seen.chunks(PILOT_SAMPLES as usize)) {
                    variances[row as usize * width + x as usize] = shown_variance(seen);
                }
            }
            state.counts += tracer.counts;
        });
        let variances = variances.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        (!self.is_late()).then_some(variances)
    }

    /// A few pixels, evenly spread, so that there is a whole picture whenever the time is over.
    fn preview(&mut self) -> Preview {
        let step = preview_step(self.args.width, self.args.height);
        let columns = self.args.width.div_ceil(step);
        let rows: Vec<u32> = (0..self.args.height).step_by(step as usize).collect();
        let pattern = SamplePattern::new(SamplerKind::Independent, 1);
        let seen = rows.par_iter().map(|&row| {
            let (mut places, mut rays) = (Places::default(), Rays::default());
            for column in 0..columns {
                let x = (column * step + step / 2).min(self.args.width - 1);
                let row = (row + step / 2).min(self.args.height - 1);
                let set = pattern.set((x, row), PILOT_SET + 1, self.args.seed);
                places.push(self.maker.place_of_sample((x, row), &set, 0));
            }
            self.maker.make_rays(&places, &mut rays);
            let (mut tracer, mut seen) = (Tracer::new(self.scene, self.plan), Vec::new());
            tracer.see(&rays, &mut seen);
            let pixels: Vec<Pixel> = seen.iter().map(|seen| self.maker.displayed(seen).sanitized()).collect();
            (pixels, tracer.counts)
        });
        let seen: Vec<_> = seen.collect();
        let mut counts = RayCounts::default();
        seen.iter().for_each(|row| counts += row.1);
        Preview { step, pixels: seen.into_iter().map(|row| row.0).collect(), counts }
    }

    fn errors(&self) -> ErrorSums {
        let parts = self.tiles.par_iter().map(|state| {
            let mut sums = ErrorSums::default();
            if let Ok(state) = state.lock() {
                for index in (0..state.colors.len()).filter(|&index| state.samples[index] > 0) {
                    sums.add_halves(state.halves(index));
                }
            }
            sums
        });
        ErrorSums::total(&parts.collect::<Vec<_>>())
    }

    fn finished(self, preview: Option<Preview>) -> (Frame, Sampling) {
        let errors = self.errors();
        let args = self.args;
        let planes = Planes::wanted_by(args);
        let mut film = Film::new(args.width, args.height, planes);
        let mut counts = preview.as_ref().map_or(RayCounts::default(), |preview| preview.counts);
        let mut sampling = Sampling { waves: self.waves, ..Sampling::default() };
        for state in self.tiles {
            let state = state.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
            let tile = state.tile;
            let pixels: Vec<Pixel> = tile
                .places()
                .enumerate()
                .map(|(index, place)| {
                    sampling.add_pixel(2 * state.samples[index]);
                    match &preview {
                        Some(preview) if state.samples[index] == 0 => preview.pixel(place),
                        _ => state.mean(index),
                    }
                })
                .collect();
            let mut tile_film = Film::new(tile.width, tile.height, planes);
            store(&pixels, &mut tile_film);
            if planes.error_map {
                let mut sums = ErrorSums::default();
                let levels =
                    |index| if state.samples[index] > 0 { sums.add_halves(state.halves(index)) } else { 255.0 };
                tile_film.set_errors((0..pixels.len()).map(levels));
            }
            film.place(tile.x, tile.row, &tile_film);
            counts += state.counts;
        }
        (Frame { film, counts, errors, filter: None }, sampling)
    }
}

impl TileState {
    /// Adds samples to both halves of a pixel.
    fn add(&mut self, index: usize, halves: [&[Seen]; 2], displayed: impl Fn(&Seen) -> Pixel) {
        self.samples[index] += halves[0].len() as u32;
        for (half, seen) in halves.into_iter().enumerate() {
            for pixel in seen.iter().map(&displayed) {
                if let Some(colors) = self.colors.get_mut(index) {
                    colors[half] += pixel.color;
                }
                if let Some(others) = self.others.get_mut(index) {
                    others.depth += pixel.depth;
                    others.normal += pixel.normal;
                }
            }
        }
    }

    /// The mean colours of both halves.
    fn halves(&self, index: usize) -> [Vector3; 2] {
        self.colors[index].map(|sum| sum / self.samples[index] as Real)
    }

    fn mean(&self, index: usize) -> Pixel {
        let mut mean = Pixel::default();
        let samples = 2.0 * self.samples[index] as Real;
        if let Some(others) = self.others.get(index) {
            mean = Pixel { depth: others.depth / samples, normal: others.normal / samples, ..mean };
        }
        if !self.colors.is_empty() {
            let [first, second] = self.halves(index);
            mean.color = (first + second) * 0.5;
        }
        mean
    }
}

/// A coarse picture.
struct Preview {
    /// Pixels between its pixels.
    step: u32,
    pixels: Vec<Vec<Pixel>>,
    counts: RayCounts,
}

impl Preview {
    fn pixel(&self, (x, row): (u32, u32)) -> Pixel {
        self.pixels[(row / self.step) as usize][(x / self.step) as usize]
    }
}

/// Few enough pixels to be traced in no time, whatever the size of the picture.
fn preview_step(width: u32, height: u32) -> u32 {
    const MOST_PIXELS: u64 = 4096;
    let pixels = u64::from(width) * u64::from(height);
    (pixels.div_ceil(MOST_PIXELS).isqrt() as u32 + 1).max(4)
}

/// The variance of what a few samples show, in squared levels, as the mean over the channels.
fn shown_variance(seen: &[Seen]) -> f32 {
    let shown = |c: usize| seen.iter().map(move |seen| 255.0 * (seen.color[c] as f64).clamp(0.0, 1.0));
    let variance = |c: usize| {
        let mean = shown(c).sum::<f64>() / seen.len() as f64;
        shown(c).map(|level| (level - mean).powi(2)).sum::<f64>() / (seen.len() - 1) as f64
    };
    let variance = (variance(0) + variance(1) + variance(2)) / 3.0;
    if variance.is_finite() { variance as f32 } else { 0.0 }
}
