//! Passes: each takes samples in the pixels that have fewer than a goal.

use super::allocation::Goal;
use super::empty_tiles::EmptyTiles;
use super::finishing::{Finishing, tried};
use super::rays::{RayMaker, SetPart};
use super::samples::SamplePattern;
use super::spread::SetKind;
use super::tile_samples::{TileSamples, Wanted};
use super::tiles::{Progress, Tiles};
use super::tracer::{Tracer, tracer};
use super::uniform::RAYS_AT_ONCE;
use crate::camera::Place;
use crate::film::Planes;
use crate::options::{Options, SamplerKind};
use crate::plan::Plan;
use crate::ray_counts::RayCounts;
use crate::scene::Scene;
use crate::timing::{Deadline, Stopwatch};
use crate::trace::Seen;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Vectors that each thread keeps: a tile's pixels, those that need samples, their sets, where these lie, and what is seen there.
#[derive(Default)]
struct Scratch {
    pixels: Vec<(u32, u32)>,
    wanted: Vec<Wanted>,
    parts: Vec<SetPart>,
    places: Vec<Place>,
    seen: Vec<Seen>,
}

/// A picture that is being rendered.
pub struct Picture<'a> {
    pub scene: &'a Scene,
    pub plan: &'a Plan,
    pub options: &'a Options,
    pub maker: &'a RayMaker,
    pub empty: &'a EmptyTiles<'a>,
    pub kind: SetKind,
    /// When the picture must be written.
    pub limit: Deadline,
    /// No work is begun after this time, and what is under way is thrown away.
    pub deadline: Deadline,
    pub bands: Tiles,
    pub tiles: Vec<Mutex<TileSamples>>,
    pub progress: &'a dyn Progress,
    pub passes: u32,
    /// Rays of the pilot, once it is done.
    pub pilot: Option<RayCounts>,
    pub finishing: Finishing,
}

impl Picture<'_> {
    /// Takes samples until every pixel has `goal` of them. Returns false if there was no time for all, or is none for
    /// more.
    pub fn pass(&mut self, goal: &Goal) -> bool {
        let tried = tried(self.tiles.len());
        if self.passes == 0 && self.limit.is_set() && !self.is_late() {
            // What a few tiles with samples say is true of all.
            self.advance_tiles(tried.clone(), goal);
            self.leave_time_to_finish(tried.clone());
        }
        self.advance_tiles(0..self.tiles.len(), goal);
        self.passes += 1;
        self.leave_time_to_finish(tried);
        !self.is_late()
    }

    /// Takes samples in some tiles.
    fn advance_tiles(&mut self, tiles: Range<usize>, goal: &Goal) {
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
            let finished = |tile: &Mutex<TileSamples>| Some(tile.lock().ok()?.film(planes));
            let share = some.len() as f64 / self.tiles.len() as f64;
            let time = self.finishing.time(self.options, &self.tiles[some], share, finished);
            self.deadline = self.limit.earlier(time);
        }
    }

    fn advance_tile(&self, tracer: &mut dyn Tracer, scratch: &mut Scratch, tile: &mut TileSamples, goal: &Goal) {
        if tile.is_empty {
            return self.fill_tile(tracer, tile);
        }
        match goal {
            Goal::Same(2) if self.takes_pairs() && !tile.has_samples() => {
                self.take_pairs(tracer, scratch, tile);
            }
            _ => {
                tile.pixels_below(goal, &mut scratch.wanted);
                if scratch.wanted.is_empty() {
                    return;
                }
                self.take_wanted(tracer, scratch, tile);
            }
        }
        tile.counts += tracer.take_counts();
        tile.update_errors();
    }

    /// Returns whether the first two samples of a pixel are those of a sequence.
    fn takes_pairs(&self) -> bool {
        self.options.measure.sampler == SamplerKind::Sobol
    }

    /// Takes the first two samples of all pixels of a tile: the same as wanted ones, in fewer instructions.
    fn take_pairs(&self, tracer: &mut dyn Tracer, scratch: &mut Scratch, tile: &mut TileSamples) {
        let Scratch { pixels, places, seen, .. } = scratch;
        tile.make_room();
        tile.tile.list_pixels(pixels);
        for (number, pixels) in pixels.chunks(RAYS_AT_ONCE / 2).enumerate() {
            self.maker.set_pairs(pixels, places);
            // Paths that were cut short have lost light.
            if self.is_late() || !tracer.trace(self.maker.grid, places, seen) {
                break;
            }
            let first = number * RAYS_AT_ONCE / 2;
            tile.add_pairs(self.options.simd, first, seen, |seen| self.maker.displayed(seen));
        }
    }

    /// Takes the samples that the pixels of a tile want.
    fn take_wanted(&self, tracer: &mut dyn Tracer, scratch: &mut Scratch, tile: &mut TileSamples) {
        let Scratch { wanted, parts, places, seen, .. } = scratch;
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

    fn is_late(&self) -> bool {
        self.deadline.is_over()
    }
}
