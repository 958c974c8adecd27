//! Adaptive sampling: passes over the whole picture until a target error or a time limit is reached.
//!
//! The samples of a pixel are two halves, from which its error is estimated (see [`spread`](super::spread)): of one Sobol
//! sequence, or two sets of another sampler. With a target error, two samples a pixel are taken first. If that is not
//! enough, the [`pilot`] and the samples of its neighbours decide how many more each pixel gets (see
//! [`allocation`](super::allocation)); the pilot's rays are not part of the picture. Only the error of the whole
//! picture decides when to stop: what the samples say, what the pilot says, and what no ray can have met. So no pixel
//! is biased by its own samples, but for its small share in the error of the whole.

use super::allocation::Allocation;
use super::empty_tiles::EmptyTiles;
use super::error_estimate::{ErrorEstimate, ErrorSums};
use super::error_map;
use super::finishing::{Finishing, tried};
use super::frame::{Frame, SampleCounts};
use super::pilot;
use super::preview::Preview;
use super::rays::{RayMaker, SetPart};
use super::samples::SamplePattern;
use super::spread::SetKind;
use super::tile_samples::{Halves, TileSamples, Wanted};
use super::tiles::{Progress, Tile, decode_faces_ahead};
use super::tracer::{Tracer, tracer};
use super::uniform::RAYS_AT_ONCE;
use super::unseen::Unseen;
use crate::camera::Place;
use crate::film::{Film, Planes};
use crate::options::{Options, SamplerKind};
use crate::plan::Plan;
use crate::ray_counts::RayCounts;
use crate::scene::Scene;
use crate::timing::{Deadline, Stopwatch};
use crate::trace::Seen;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Number of the preview's sample set. The sets of the picture's halves begin at 0 and never get this far.
const PREVIEW_SET: u32 = 1 << 30;

/// Renders until the target error is reached, or until there is just enough time left before `limit` to write the
/// picture. The picture is complete in any case.
pub fn render(scene: &Scene, plan: &Plan, options: &Options, limit: Deadline, progress: &dyn Progress) -> Frame {
    decode_faces_ahead(scene, plan, options);
    let tiles = Tile::all(options.width, options.height).into_par_iter();
    let maker = RayMaker::new(options);
    let empty = EmptyTiles::new(scene, plan, options, &maker);
    let (kind, halves) = match options.measure.sampler {
        SamplerKind::Sobol => (SetKind::Sequences, Halves::OfSequence),
        SamplerKind::Independent | SamplerKind::Stratified => (SetKind::Independent, Halves::Independent),
    };
    let mut picture = Picture {
        scene,
        plan,
        options,
        maker: &maker,
        empty: &empty,
        kind,
        limit,
        deadline: limit,
        tiles: tiles.map(|tile| Mutex::new(TileSamples::new(tile, plan, halves, empty.contain(&tile)))).collect(),
        progress,
        passes: 0,
        pilot: None,
        finishing: Finishing::new(limit.is_set()),
    };
    let render_preview = || Preview::render(scene, plan, options, &maker, PREVIEW_SET);
    let preview = limit.is_set().then(render_preview);
    match options.measure.target_error {
        Some(levels) => picture.sample_to_error(levels),
        None => picture.sample_evenly(),
    }
    // Without a time limit it is only needed after an interrupt.
    let preview = preview.or_else(|| limit.is_over().then(render_preview));
    picture.finish(preview)
}

/// With two samples a pixel, a squared error of more than so many times the target's is far from it: then the pilot's
/// ray a pixel saves more than it costs. Else the samples of a pixel's neighbours say where more are needed.
const FAR: f64 = 8.0;

/// Pictures of fewer pixels get a pilot in any case: it costs little there, and a pixel's samples have a large share in the
/// error of the whole, by which neighbours alone would bias the picture.
const SMALL: u64 = 1 << 14;

/// The share of the target's squared error that is aimed at by the later passes, which know more.
const LATER_MARGIN: f64 = 0.9;

/// Vectors that each thread keeps: pixels that need samples, their sets, where these lie, and what is seen there.
#[derive(Default)]
struct Scratch {
    wanted: Vec<Wanted>,
    parts: Vec<SetPart>,
    places: Vec<Place>,
    seen: Vec<Seen>,
}

/// A picture that is being rendered.
struct Picture<'a> {
    scene: &'a Scene,
    plan: &'a Plan,
    options: &'a Options,
    maker: &'a RayMaker,
    empty: &'a EmptyTiles<'a>,
    kind: SetKind,
    /// When the picture must be written.
    limit: Deadline,
    /// No work is begun after this time, and what is under way is thrown away.
    deadline: Deadline,
    tiles: Vec<Mutex<TileSamples>>,
    progress: &'a dyn Progress,
    passes: u32,
    /// Rays of the pilot, once it is done.
    pilot: Option<RayCounts>,
    finishing: Finishing,
}

impl Picture<'_> {
    /// Takes as many samples in every pixel as without a time limit, or as many as there is time for.
    fn sample_evenly(&mut self) {
        let goal = (self.options.samples() * self.options.grid_pixels()).next_power_of_two().max(2);
        let mut samples = 2;
        while self.pass(|_| samples.min(goal)) && samples < goal {
            samples *= 2;
        }
    }

    /// Takes samples where they are needed until the estimated error is at most `levels`, with what no sample has met.
    fn sample_to_error(&mut self, levels: f64) {
        let aim = levels * levels;
        if !self.pass(|_| 2) {
            return;
        }
        let first = self.estimate();
        if first.is_none_or(|estimate| estimate.with_unseen() <= levels) {
            return;
        }
        let Some(part) = self.part_with_objects() else { return };
        let (width, order) = (part.width as usize, self.options.measure.sampler.convergence_order());
        let pixels = u64::from(self.options.width) * u64::from(self.options.height);
        let mut allocation = Allocation::new(pixels, order);
        let is_far = first.is_some_and(|estimate| estimate.seen.powi(2) > FAR * aim) || pixels < SMALL;
        if is_far {
            let tracer = || tracer(self.scene, self.plan, self.deadline);
            let Some((variances, counts)) = pilot::variances(part, self.maker, self.empty, tracer) else { return };
            self.pilot = Some(counts);
            allocation.set_pilot(&variances, width);
        }
        // What the first samples say of the model is rough. If it asks for many more, that may be too many.
        let mut margin = if is_far { 1.5 } else { 0.8 };
        loop {
            let Some(estimate) = self.estimate() else { return };
            let measured = estimate.seen.powi(2);
            allocation.calibrate(measured);
            if self.passes > 1 && allocation.expected() + estimate.expected_unseen() <= aim {
                return;
            }
            if self.passes > 1 || !is_far {
                allocation.refine(&self.sample_variances(part, order), width);
                allocation.calibrate(measured);
            }
            let unseen = |floor: u32| Unseen { samples: floor + u32::from(is_far), pixels };
            let is_more = allocation.raise(aim, margin, unseen) || allocation.raise(aim, LATER_MARGIN, unseen);
            if !is_more || !self.pass(|pixel| allocation.goal(part.index_of(pixel))) {
                return;
            }
            margin = LATER_MARGIN;
        }
    }

    /// Returns the smallest rectangle with all tiles that are not empty; `None` if all are.
    fn part_with_objects(&self) -> Option<Tile> {
        let tiles = self.tiles.iter().filter_map(|tile| tile.lock().ok().filter(|tile| !tile.is_empty));
        tiles.map(|tile| tile.tile).reduce(|a, b| a.union(&b))
    }

    /// Returns the variance of a sample of each pixel of a part of the picture in squared levels, by its own samples.
    fn sample_variances(&self, part: Tile, order: f64) -> Vec<f32> {
        let mut variances = vec![0.0; (part.width * part.height) as usize];
        let powers: Vec<f32> = (0..32).map(|power| (order * f64::from(power)).exp2() as f32).collect();
        for tile in self.tiles.iter().filter_map(|tile| tile.lock().ok()).filter(|tile| !tile.is_empty) {
            for (index, pixel) in tile.tile.pixels().enumerate() {
                let power = tile.samples(index).checked_ilog2().unwrap_or(0) as usize;
                variances[part.index_of(pixel)] = tile.variance(index) * powers[power];
            }
        }
        variances
    }

    /// Returns the estimated error of the pixels that have samples; `None` if there are none.
    fn estimate(&self) -> Option<ErrorEstimate> {
        let least = |tile: &Mutex<TileSamples>| tile.lock().ok()?.fewest();
        let least = self.tiles.par_iter().filter_map(least).min().unwrap_or(2);
        self.errors().estimate(self.kind, least + u32::from(self.pilot.is_some()))
    }

    fn is_late(&self) -> bool {
        self.deadline.is_over()
    }

    /// Takes samples until every pixel has `goal` of them. Returns false if there was no time for all, or is none for
    /// more.
    fn pass(&mut self, goal: impl Fn((u32, u32)) -> u32 + Sync) -> bool {
        let tried = tried(self.tiles.len());
        if self.passes == 0 && self.limit.is_set() && !self.is_late() {
            // What a few tiles with samples say is true of all.
            self.advance_tiles(tried.clone(), &goal);
            self.leave_time_to_finish(tried.clone());
        }
        self.advance_tiles(0..self.tiles.len(), &goal);
        self.passes += 1;
        self.leave_time_to_finish(tried);
        !self.is_late()
    }

    /// Takes samples in some tiles.
    fn advance_tiles(&mut self, tiles: Range<usize>, goal: &(impl Fn((u32, u32)) -> u32 + Sync)) {
        let (done, watch) = (AtomicUsize::new(0), Stopwatch::start());
        let tracer = || (tracer(self.scene, self.plan, self.deadline), Scratch::default());
        self.tiles[tiles].par_iter().for_each_init(tracer, |(tracer, scratch), tile| {
            // A poisoned lock means that another thread has panicked; that panic will be reported.
            if let (false, Ok(mut tile)) = (self.is_late(), tile.lock()) {
                let before = tile.counts.total();
                self.advance_tile(&mut **tracer, scratch, &mut tile, goal);
                self.progress.add_rays(tile.counts.total() - before);
                self.progress.advance(done.fetch_add(1, Ordering::Relaxed) + 1, self.tiles.len());
            }
        });
        self.finishing.all_threads_worked(watch.times());
    }

    /// Moves the deadline so far before the limit as it will take to finish and to write the picture, if all its tiles
    /// are like some of them.
    fn leave_time_to_finish(&mut self, some: Range<usize>) {
        if self.limit.is_set() {
            let planes = Planes::wanted_by(self.options);
            let finished = |tile: &Mutex<TileSamples>| Some(tile.lock().ok()?.film(None, planes));
            let share = some.len() as f64 / self.tiles.len() as f64;
            let time = self.finishing.time(self.options, &self.tiles[some], share, finished);
            self.deadline = self.limit.earlier(time);
        }
    }

    fn advance_tile(
        &self,
        tracer: &mut dyn Tracer,
        Scratch { wanted, parts, places, seen }: &mut Scratch,
        tile: &mut TileSamples,
        goal: &(impl Fn((u32, u32)) -> u32 + Sync),
    ) {
        if tile.is_empty {
            return self.fill_tile(tracer, tile);
        }
        tile.pixels_below(goal, wanted);
        if wanted.is_empty() {
            return;
        }
        tile.make_room();
        let mut waiting = wanted.as_slice();
        while !waiting.is_empty() && !self.is_late() {
            parts.clear();
            let (mut taken, mut rays) = (0, 0);
            while taken < waiting.len() && rays < RAYS_AT_ONCE {
                self.add_parts(&waiting[taken], parts);
                rays += waiting[taken].samples.len();
                taken += 1;
            }
            self.maker.set_places_of(parts, places);
            // Paths that were cut short have lost light.
            if !tracer.trace(self.maker.grid, places, seen) {
                break;
            }
            let mut rest = seen.as_slice();
            for wanted in &waiting[..taken] {
                let (own, others) = rest.split_at(wanted.samples.len());
                tile.add(wanted, own, |seen| self.maker.displayed(seen));
                rest = others;
            }
            waiting = &waiting[taken..];
        }
        tile.counts += tracer.take_counts();
        tile.update_errors();
    }

    /// Fills a tile through which nothing but a background of one colour is seen: one ray shows it.
    fn fill_tile(&self, tracer: &mut dyn Tracer, tile: &mut TileSamples) {
        if tile.samples(0) == 0 {
            let seen = self.empty.seen_through(&tile.tile, tracer);
            tile.fill(self.maker.displayed(&seen).sanitized());
            tile.counts += tracer.take_counts();
        }
    }

    /// Adds the parts of sets of a pixel's wanted samples: of independent halves first that of the first one.
    fn add_parts(&self, wanted: &Wanted, parts: &mut Vec<SetPart>) {
        let (sampler, Range { start, end }) = (self.options.measure.sampler, wanted.samples.clone());
        let part = |set, first, count| {
            let pattern = SamplePattern::new(sampler, first + count);
            SetPart { pixel: wanted.pixel, pattern, set, first, count }
        };
        let half = (end - start) / 2;
        match sampler {
            SamplerKind::Sobol => parts.push(part(0, start, end - start)),
            SamplerKind::Independent => parts.extend([0, 1].map(|set| part(set, start / 2, half))),
            // A stratified set cannot be extended, so every pass begins new sets.
            SamplerKind::Stratified => parts.extend([0, 1].map(|set| part(2 * self.passes + set, 0, half))),
        }
    }

    fn errors(&self) -> ErrorSums {
        ErrorSums::total(self.tiles.iter().filter_map(|tile| Some(tile.lock().ok()?.errors)))
    }

    /// Turns samples into pixels. Pixels without samples show the preview.
    fn finish(self, preview: Option<Preview>) -> Frame {
        let estimate = self.estimate();
        let planes = Planes::wanted_by(self.options);
        let film = Film::new(self.options.width, self.options.height, planes);
        let mut counts = preview.as_ref().map_or(RayCounts::default(), |preview| preview.counts);
        counts += self.pilot.unwrap_or_default();
        let samples = SampleCounts { passes: self.passes, ..SampleCounts::default() };
        let whole = Mutex::new((film, counts, samples));
        self.tiles.into_par_iter().for_each(|tile| {
            let tile = tile.into_inner().unwrap_or_else(PoisonError::into_inner);
            let tile_film = tile.film(preview.as_ref(), planes);
            // A poisoned lock means that another thread has panicked; that panic will be reported.
            if let Ok(mut whole) = whole.lock() {
                let (film, counts, samples) = &mut *whole;
                film.place(tile.tile.x, tile.tile.row, &tile_film);
                tile.count_samples(samples);
                *counts += tile.counts;
            }
        });
        let (mut film, counts, samples) = whole.into_inner().unwrap_or_else(PoisonError::into_inner);
        if let (Some(variances), Some(estimate)) = (&mut film.variances, &estimate) {
            *variances = error_map::finished(variances, self.options.width as usize, 1.0, estimate);
        }
        let estimate = match &preview {
            Some(preview) if samples.unreached > 0 => {
                Some(estimate.unwrap_or_default().with_rest(samples.reached(), preview.error()))
            }
            _ => estimate,
        };
        Frame { film, counts, samples, estimate, filter: Duration::ZERO, writing: Duration::ZERO }
    }
}
