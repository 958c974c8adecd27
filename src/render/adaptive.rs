//! Adaptive sampling: passes over the whole picture until a target error or a time limit is reached.
//!
//! The samples of a pixel are two independent halves, from which its error is estimated (see
//! [`error_estimate`](super::error_estimate)). With a target error, pilot samples decide how many samples each pixel
//! gets (see [`allocation`](super::allocation)); they are not part of the picture. Only the error of the whole
//! picture decides when to stop. So no pixel is biased by its own samples, but for its small share in the error of
//! the whole.

use super::allocation::{Allocation, PILOT_SAMPLES};
use super::error_estimate::ErrorSums;
use super::frame::{Frame, SampleCounts};
use super::pixel::{Pixel, store};
use super::preview::Preview;
use super::rays::{RayMaker, SetSizes};
use super::samples::SamplePattern;
use super::tile_samples::TileSamples;
use super::tiles::{Progress, Tile, decode_faces_ahead};
use super::tracer::{Tracer, tracer};
use super::uniform::RAYS_AT_ONCE;
use crate::camera::Place;
use crate::film::{Film, Planes};
use crate::options::{Options, SamplerKind};
use crate::plan::Plan;
use crate::ray_counts::RayCounts;
use crate::scene::Scene;
use crate::timing::Deadline;
use crate::trace::Seen;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Number of the pilot's sample set. The sets of the picture's halves begin at 0 and never get this far.
const PILOT_SET: u32 = 1 << 30;
/// Number of the preview's sample set.
const PREVIEW_SET: u32 = PILOT_SET + 1;

/// Renders until the target error or `deadline` is reached. The picture is complete in any case.
pub fn render(
    scene: &Scene,
    plan: &Plan,
    options: &Options,
    deadline: Deadline,
    progress: &dyn Progress,
) -> Frame {
    decode_faces_ahead(scene, plan, options);
    let tiles = Tile::all(options.width, options.height).into_iter();
    let maker = RayMaker::new(options, &SetSizes::One(1));
    let mut picture = Picture {
        scene,
        plan,
        options,
        maker: &maker,
        deadline,
        tiles: tiles.map(|tile| Mutex::new(TileSamples::new(tile, plan))).collect(),
        progress,
        passes: 0,
    };
    let render_preview = || Preview::render(scene, plan, options, &maker, PREVIEW_SET);
    let preview = deadline.is_set().then(render_preview);
    match options.measure.target_error {
        Some(levels) => picture.sample_to_error(levels),
        None => picture.sample_evenly(),
    }
    // Without a time limit it is only needed after an interrupt.
    let preview = preview.or_else(|| deadline.is_over().then(render_preview));
    picture.finish(preview)
}

/// A picture that is being rendered.
struct Picture<'a> {
    scene: &'a Scene,
    plan: &'a Plan,
    options: &'a Options,
    maker: &'a RayMaker,
    /// No work is begun after this time, and what is under way is thrown away.
    deadline: Deadline,
    tiles: Vec<Mutex<TileSamples>>,
    progress: &'a dyn Progress,
    passes: u32,
}

impl Picture<'_> {
    /// Takes as many samples in every pixel as without a time limit, or as many as there is time for.
    fn sample_evenly(&mut self) {
        let goal = (self.options.samples() * self.options.grid_pixels()).div_ceil(2);
        let mut samples = 1;
        while self.pass(|_| samples.min(goal)) && samples < goal {
            samples *= 2;
        }
    }

    /// Takes samples where they are needed until the estimated error is at most `levels`.
    fn sample_to_error(&mut self, levels: f64) {
        let aim = levels * levels;
        if !self.pass(|_| 1) {
            return;
        }
        let Some(variances) = self.pilot() else { return };
        let order = self.options.measure.sampler.convergence_order();
        let mut allocation = Allocation::new(&variances, self.options.width as usize, order);
        // The first pass shows how good the model is, so it must not take too many samples.
        let mut margin = 1.5;
        while self.mean_square_error() > aim {
            if !allocation.raise(margin * aim) || !self.pass(|pixel| allocation.goal(pixel)) {
                return;
            }
            allocation.calibrate(self.mean_square_error());
            margin = 0.95;
        }
    }

    /// Returns the estimated mean squared error in squared levels.
    fn mean_square_error(&self) -> f64 {
        self.errors().estimate().map_or(0.0, |estimate| estimate.levels.rmse.powi(2))
    }

    fn is_late(&self) -> bool {
        self.deadline.is_over()
    }

    /// Takes samples until every pixel has `goal` of them in each half. Returns false if there was no time for all.
    fn pass(&mut self, goal: impl Fn(usize) -> u32 + Sync) -> bool {
        let done = AtomicUsize::new(0);
        let pass = self.passes;
        self.passes += 1;
        let tracer = || tracer(self.scene, self.plan, self.deadline);
        self.tiles.par_iter().for_each_init(tracer, |tracer, tile| {
            // A poisoned lock means that another thread has panicked; that panic will be reported.
            if let (false, Ok(mut tile)) = (self.is_late(), tile.lock()) {
                self.advance_tile(&mut **tracer, &mut tile, pass, &goal);
                self.progress.advance(done.fetch_add(1, Ordering::Relaxed) + 1, self.tiles.len());
            }
        });
        !self.is_late()
    }

    fn advance_tile(
        &self,
        tracer: &mut dyn Tracer,
        tile: &mut TileSamples,
        pass: u32,
        goal: &(impl Fn(usize) -> u32 + Sync),
    ) {
        let width = self.options.width as usize;
        let wanted = tile.pixels_below(|(x, row)| goal(row as usize * width + x as usize));
        let (mut places, mut seen) = (Vec::new(), Vec::new());
        let mut waiting = wanted.as_slice();
        while !waiting.is_empty() && !self.is_late() {
            places.clear();
            let mut taken = 0;
            while taken < waiting.len() && places.len() < RAYS_AT_ONCE {
                let wanted = &waiting[taken];
                self.add_places(wanted.pixel, pass, wanted.samples.clone(), &mut places);
                taken += 1;
            }
            // Paths that were cut short have lost light.
            if !tracer.trace(self.maker.grid, &places, &mut seen) {
                break;
            }
            let mut rest = seen.as_slice();
            for wanted in &waiting[..taken] {
                let added = wanted.samples.len();
                let (first, second) = (&rest[..added], &rest[added..2 * added]);
                tile.add(wanted.index, [first, second], |seen| self.maker.displayed(seen).sanitized());
                rest = &rest[2 * added..];
            }
            waiting = &waiting[taken..];
        }
        tile.counts += tracer.take_counts();
    }

    /// Adds the places of samples of both halves of a pixel.
    fn add_places(&self, pixel: (u32, u32), pass: u32, samples: Range<u32>, places: &mut Vec<Place>) {
        let sampler = self.options.measure.sampler;
        // A stratified set cannot be extended, so every pass begins new sets.
        let is_stratified = sampler == SamplerKind::Stratified;
        let (first_set, samples) = if is_stratified { (2 * pass, 0..samples.len() as u32) } else { (0, samples) };
        let pattern = SamplePattern::new(sampler, samples.len().max(1) as u32);
        for half in 0..2 {
            let set = pattern.set(pixel, first_set + half, self.options.seed);
            samples.clone().for_each(|sample| places.push(self.maker.place_of_sample(pixel, &set, sample)));
        }
    }

    /// Takes a few samples of every pixel, to find out where more are needed. Returns for each pixel the variance of
    /// a sample in squared levels, or `None` if there was no time.
    fn pilot(&mut self) -> Option<Vec<f32>> {
        let width = self.options.width as usize;
        let variances = Mutex::new(vec![0.0; width * self.options.height as usize]);
        let tracer = || tracer(self.scene, self.plan, self.deadline);
        self.tiles.par_iter().for_each_init(tracer, |tracer, tile| {
            let Ok(mut tile) = tile.lock() else { return };
            let pixels: Vec<_> = tile.tile.pixels().collect();
            let (mut places, mut seen) = (Vec::new(), Vec::new());
            for pixels in pixels.chunks(RAYS_AT_ONCE / PILOT_SAMPLES as usize) {
                self.set_pilot_places(pixels, &mut places);
                if self.is_late() || !tracer.trace(self.maker.grid, &places, &mut seen) {
                    return;
                }
                let Ok(mut variances) = variances.lock() else { return };
                for (&(x, row), seen) in pixels.iter().zip(seen.chunks(PILOT_SAMPLES as usize)) {
                    variances[row as usize * width + x as usize] = displayed_variance(seen);
                }
            }
            tile.counts += tracer.take_counts();
        });
        let variances = variances.into_inner().unwrap_or_else(PoisonError::into_inner);
        (!self.is_late()).then_some(variances)
    }

    fn set_pilot_places(&self, pixels: &[(u32, u32)], places: &mut Vec<Place>) {
        let pattern = SamplePattern::new(SamplerKind::Sobol, PILOT_SAMPLES);
        places.clear();
        for &pixel in pixels {
            let set = pattern.set(pixel, PILOT_SET, self.options.seed);
            (0..PILOT_SAMPLES).for_each(|sample| places.push(self.maker.place_of_sample(pixel, &set, sample)));
        }
    }

    fn errors(&self) -> ErrorSums {
        let parts = self.tiles.par_iter().map(|tile| match tile.lock() {
            Ok(tile) => tile.errors(),
            Err(_) => ErrorSums::default(),
        });
        ErrorSums::total(&parts.collect::<Vec<_>>())
    }

    /// Turns samples into pixels. Pixels without samples show the preview.
    fn finish(self, preview: Option<Preview>) -> Frame {
        let estimate = self.errors().estimate();
        let planes = Planes::wanted_by(self.options);
        let mut film = Film::new(self.options.width, self.options.height, planes);
        let mut counts = preview.as_ref().map_or(RayCounts::default(), |preview| preview.counts);
        let mut samples = SampleCounts { passes: self.passes, ..SampleCounts::default() };
        for tile in self.tiles {
            let tile = tile.into_inner().unwrap_or_else(PoisonError::into_inner);
            let place = tile.tile;
            let pixel = |(index, pixel)| match &preview {
                Some(preview) if tile.samples[index] == 0 => preview.pixel(pixel),
                _ => tile.mean(index),
            };
            let pixels: Vec<Pixel> = place.pixels().enumerate().map(pixel).collect();
            let mut tile_film = Film::new(place.width, place.height, planes);
            store(&pixels, &mut tile_film);
            if planes.error_map {
                tile_film.set_errors(tile.pixel_errors());
            }
            film.place(place.x, place.row, &tile_film);
            tile.samples.iter().for_each(|half| samples.add_pixel(2 * half));
            counts += tile.counts;
        }
        Frame { film, counts, samples, estimate, filter: Duration::ZERO }
    }
}

/// Returns the variance of the displayed colours of a few samples, in squared levels, averaged over the channels.
fn displayed_variance(seen: &[Seen]) -> f32 {
    let shown = |c: usize| seen.iter().map(move |seen| 255.0 * (seen.color[c] as f64).clamp(0.0, 1.0));
    let variance = |c: usize| {
        let mean = shown(c).sum::<f64>() / seen.len() as f64;
        shown(c).map(|level| (level - mean).powi(2)).sum::<f64>() / (seen.len() - 1) as f64
    };
    let variance = (variance(0) + variance(1) + variance(2)) / 3.0;
    if variance.is_finite() { variance as f32 } else { 0.0 }
}
