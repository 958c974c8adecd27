//! Adaptive sampling: passes over the whole picture until a target error or a time limit is reached.
//!
//! The samples of a pixel are two halves, from which its error is estimated (see [`spread`](super::spread)): of one Sobol
//! sequence, or two sets of another sampler. With a target error, two samples a pixel are taken first. If that is not
//! enough, the [`pilot`] and the samples of its neighbours decide how many more each pixel gets (see
//! [`allocation`](super::allocation)); the pilot's rays are not part of the picture. Only the error of the whole
//! picture decides when to stop: what the samples say, what the pilot says, and what no ray can have met. So no pixel
//! is biased by its own samples, but for its small share in the error of the whole.

use super::allocation::{Allocation, Goal};
use super::bands::Bands;
use super::empty_tiles::EmptyTiles;
use super::error_estimate::ErrorEstimate;
use super::error_map;
use super::error_sums::ErrorSums;
use super::finishing::Finishing;
use super::frame::{Frame, SampleCounts};
use super::passes::Picture;
use super::pilot;
use super::preview::Preview;
use super::rays::RayMaker;
use super::spread::SetKind;
use super::tile_cost::TileCost;
use super::tile_samples::{Halves, TileSamples};
use super::tiles::{Progress, Silent, Tile, Tiles, decode_faces_ahead};
use super::tracer::tracer;
use super::unseen::Unseen;
use crate::error::Error;
use crate::film::{BandWriter, Columns, FilmWriter, Planes};
use crate::options::{Options, Region, SamplerKind};
use crate::plan::Plan;
use crate::ray_counts::RayCounts;
use crate::scene::Scene;
use crate::timing::Deadline;
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Number of the preview's sample set. The sets of the picture's halves begin at 0 and never get this far.
const PREVIEW_SET: u32 = 1 << 30;

/// Renders into memory until the target error is reached, or until there is just enough time left before `limit` to write
/// the picture. The picture is complete in any case.
pub fn render(scene: &Scene, plan: &Plan, options: &Options, limit: Deadline, progress: &dyn Progress) -> Frame {
    let mut film = FilmWriter::new(options.width, options.height, Planes::wanted_by(options));
    let sampled = sample(scene, plan, options, limit, vec![&mut film], progress);
    let (mut frame, of_samples) = sampled.expect("a film takes every band");
    frame.film = film.film;
    if let (Some(variances), Some(estimate)) = (&mut frame.film.variances, &of_samples) {
        *variances = error_map::finished(variances, options.width as usize, 1.0, estimate);
    }
    frame
}

/// Renders the same, and has each writer write band by band when sampling has ended. The frame has no film.
///
/// # Errors
/// The first error of a writer.
pub fn render_bands(
    scene: &Scene,
    plan: &Plan,
    options: &Options,
    limit: Deadline,
    writers: Vec<&mut dyn BandWriter>,
    progress: &dyn Progress,
) -> Result<Frame, Error> {
    Ok(sample(scene, plan, options, limit, writers, progress)?.0)
}

/// Takes samples and writes the picture. Returns the frame without a film, and the estimate for the pixels that have
/// samples.
fn sample(
    scene: &Scene,
    plan: &Plan,
    options: &Options,
    limit: Deadline,
    writers: Vec<&mut dyn BandWriter>,
    progress: &dyn Progress,
) -> Result<(Frame, Option<ErrorEstimate>), Error> {
    decode_faces_ahead(scene, plan, options);
    let bands = Tiles { region: Region::whole(options.width, options.height) };
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
        bands,
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
    picture.finish(preview, writers)
}

/// With two samples a pixel, a squared error of more than so many times the target's is far from it: then the pilot's
/// ray a pixel saves more than it costs. Else the samples of a pixel's neighbours say where more are needed.
const FAR: f64 = 8.0;

/// Pictures of fewer pixels get a pilot in any case: it costs little there, and a pixel's samples have a large share in the
/// error of the whole, by which neighbours alone would bias the picture.
const SMALL: u64 = 1 << 14;

/// The share of the target's squared error that is aimed at by the later passes, which know more.
const LATER_MARGIN: f64 = 0.9;

impl Picture<'_> {
    /// Takes as many samples in every pixel as there is time for, or as were asked for.
    fn sample_evenly(&mut self) {
        let goal = self.options.most_samples_a_pixel().next_power_of_two().max(2);
        let mut samples = 2;
        while self.pass(&Goal::Same(samples.min(goal))) && samples < goal {
            samples *= 2;
        }
    }

    /// Takes samples where they are needed until the estimated error is at most `levels`, with what no sample has met.
    fn sample_to_error(&mut self, levels: f64) {
        let aim = levels * levels;
        if !self.pass(&Goal::Same(2)) {
            return;
        }
        let first = self.estimate();
        if first.is_none_or(|estimate| estimate.with_unseen() <= levels) {
            return;
        }
        let Some(part) = self.part_with_objects() else { return };
        let order = self.options.measure.sampler.convergence_order();
        let pixels = u64::from(self.options.width) * u64::from(self.options.height);
        let mut allocation = Allocation::new(pixels, part, order);
        let is_far = first.is_some_and(|estimate| estimate.seen.powi(2) > FAR * aim) || pixels < SMALL;
        if is_far {
            let tracer = || tracer(self.scene, self.plan, self.deadline);
            let Some((variances, counts)) = pilot::variances(part, self.maker, self.empty, tracer) else { return };
            self.pilot = Some(counts);
            allocation.set_pilot(&variances);
        }
        // What the first samples say of the model is rough. If it asks for many more, that may be too many.
        let mut margin = if is_far { 1.5 } else { 0.8 };
        let mut variances = vec![0.0; (part.width * part.height) as usize];
        loop {
            let Some(estimate) = self.estimate() else { return };
            let measured = estimate.seen.powi(2);
            allocation.calibrate(measured);
            if self.passes > 1 && allocation.expected() + estimate.expected_unseen() <= aim {
                return;
            }
            if self.passes > 1 || !is_far {
                self.copy_variances(part, order, &mut variances);
                allocation.refine(&variances);
                allocation.calibrate(measured);
            }
            let unseen = |floor: u32| Unseen { samples: floor + u32::from(is_far), pixels };
            let is_more = allocation.raise(aim, margin, unseen) || allocation.raise(aim, LATER_MARGIN, unseen);
            if !is_more || !self.pass(&Goal::Allocated(&allocation)) {
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

    /// Replaces the variances of a sample of each pixel of a part of the picture, in squared levels and by its own samples,
    /// where there are new ones.
    fn copy_variances(&self, part: Tile, order: f64, variances: &mut [f32]) {
        let powers = std::array::from_fn(|power| (order * power as f64).exp2() as f32);
        let tiles = self.tiles.iter().filter_map(|tile| tile.lock().ok()).filter(|tile| !tile.is_empty);
        tiles.for_each(|mut tile| tile.copy_variances(&powers, part, variances));
    }

    /// Returns the estimated error of the pixels that have samples; `None` if there are none.
    fn estimate(&self) -> Option<ErrorEstimate> {
        self.estimate_of(&self.errors())
    }

    fn estimate_of(&self, errors: &ErrorSums) -> Option<ErrorEstimate> {
        let least = |tile: &Mutex<TileSamples>| tile.lock().ok()?.fewest();
        let least = self.tiles.par_iter().filter_map(least).min().unwrap_or(2);
        errors.estimate(self.kind, least + u32::from(self.pilot.is_some()))
    }

    fn errors(&self) -> ErrorSums {
        ErrorSums::total(self.tiles.iter().filter_map(|tile| Some(tile.lock().ok()?.errors)))
    }

    /// Turns samples into pixels, and has them written. Pixels without samples show the preview. Returns what
    /// [`sample`] does.
    fn finish(
        self,
        preview: Option<Preview>,
        writers: Vec<&mut dyn BandWriter>,
    ) -> Result<(Frame, Option<ErrorEstimate>), Error> {
        let mut errors = self.errors();
        errors.see_brightest(self.scene.brightest(self.plan));
        let of_samples = self.estimate_of(&errors);
        let planes = Planes::wanted_by(self.options);
        let mut counts = preview.as_ref().map_or(RayCounts::default(), |preview| preview.counts);
        counts += self.pilot.unwrap_or_default();
        let finished = |tile: &Tile, film: &mut Columns| {
            let place = self.bands.number_of(tile);
            // A poisoned lock means that another thread has panicked; that panic will be reported.
            let mut samples = self.tiles[place].lock().unwrap_or_else(PoisonError::into_inner);
            samples.store(preview.as_ref(), film);
            let (counted, counts) = (samples.count_samples(), samples.counts);
            samples.free();
            TileCost { samples: counted, counts, ..TileCost::default() }
        };
        let bands = Bands::new(self.bands, planes, writers);
        let totals = bands.render(&Silent, &|| Box::new(finished))?;
        counts += totals.counts;
        let samples = SampleCounts { passes: self.passes, ..totals.samples };
        let estimate = match &preview {
            Some(preview) if samples.unreached > 0 => {
                Some(of_samples.unwrap_or_default().with_rest(samples.reached(), preview.error()))
            }
            _ => of_samples,
        };
        Ok((Frame { counts, samples, estimate, writing: totals.writing, ..Frame::empty() }, of_samples))
    }
}
