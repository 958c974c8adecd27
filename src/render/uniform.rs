//! Uniform sampling: every pixel gets the same number of samples. Threads render tile by tile ([`Bands`]).

use super::bands::Bands;
use super::empty_tiles::EmptyTiles;
use super::error_estimate::ErrorEstimate;
use super::error_map;
use super::error_sums::ErrorSums;
use super::frame::{Frame, SampleCounts};
use super::pixel::{Pixel, fill, filter_weight, finite, store};
use super::rays::RayMaker;
use super::spread::{SetKind, Spread};
use super::tile_cost::{TileCost, Totals};
use super::tiles::{Progress, Tile, Tiles, decode_faces_ahead};
use super::tracer::{Tracer, tracer};
use crate::camera::Place;
use crate::error::Error;
use crate::film::{BandWriter, Columns, Film, FilmWriter, Planes};
use crate::options::Options;
use crate::plan::Plan;
use crate::scene::Scene;
use crate::simd::packet::PACKET;
use crate::timing::Deadline;
use crate::trace::Seen;
use crate::wide::PACKETS_AT_ONCE;
use std::mem::take;
use std::time::{Duration, Instant};
use vecmath::Vector3;

/// Number of rays that are traced together: so few that they fit into the processor's nearest caches, so many that
/// they share work.
pub const RAYS_AT_ONCE: usize = PACKETS_AT_ONCE * PACKET;

/// Renders the pictures of `plan` into memory. A pixel depends only on its place, so the picture is the same for any
/// number of threads.
pub fn render(scene: &Scene, plan: &Plan, options: &Options, progress: &dyn Progress) -> Frame {
    render_before(scene, plan, options, Deadline::NEVER, progress)
}

/// Renders the same. Pixels that are not done before the deadline show anything, and are counted as not reached.
pub fn render_before(
    scene: &Scene,
    plan: &Plan,
    options: &Options,
    deadline: Deadline,
    progress: &dyn Progress,
) -> Frame {
    let shown = options.shown();
    let mut film = FilmWriter::new(shown.width, shown.height, Planes::wanted_by(options));
    let rendered = render_tiles(scene, plan, options, deadline, vec![&mut film], progress);
    let totals = rendered.expect("a film takes every band");
    let mut film = film.film;
    let kind = set_kind(options);
    if let (Some(variances), Some(estimate)) = (&mut film.variances, estimate(&totals.errors, options)) {
        let factor = totals.errors.coarse_factor(kind);
        *variances = error_map::finished(variances, options.width as usize, factor, &estimate);
    }
    frame(film, totals, scene, plan, options)
}

/// Renders the same, and has each writer write each band while others are rendered. The frame has no film.
///
/// # Errors
/// The first error of a writer, which ends rendering.
pub fn render_bands(
    scene: &Scene,
    plan: &Plan,
    options: &Options,
    writers: Vec<&mut dyn BandWriter>,
    progress: &dyn Progress,
) -> Result<Frame, Error> {
    let totals = render_tiles(scene, plan, options, Deadline::NEVER, writers, progress)?;
    Ok(frame(Film::new(0, 0, Planes::default()), totals, scene, plan, options))
}

fn render_tiles(
    scene: &Scene,
    plan: &Plan,
    options: &Options,
    deadline: Deadline,
    writers: Vec<&mut dyn BandWriter>,
    progress: &dyn Progress,
) -> Result<Totals, Error> {
    decode_faces_ahead(scene, plan, options);
    let maker = RayMaker::new(options);
    let empty = EmptyTiles::new(scene, plan, options, &maker);
    let tiles = Tiles { region: options.shown() };
    let bands = Bands::new(tiles, Planes::wanted_by(options), writers);
    bands.render(progress, &|| {
        let mut renderer = TileRenderer::new(scene, plan, options, deadline, &maker);
        let empty = &empty;
        Box::new(move |tile, film| match empty.contain(tile) {
            true => renderer.fill(tile, film, empty),
            false => renderer.render(tile, film),
        })
    })
}

fn frame(film: Film, totals: Totals, scene: &Scene, plan: &Plan, options: &Options) -> Frame {
    let Totals { counts, samples, mut errors, filter, writing } = totals;
    // Without an estimate no errors are added up.
    let estimate = wants_estimate(options).then(|| {
        errors.see_brightest(scene.brightest(plan));
        estimate(&errors, options)
    });
    let estimate = estimate.flatten();
    Frame { film, counts, samples, estimate, filter, writing }
}

fn estimate(errors: &ErrorSums, options: &Options) -> Option<ErrorEstimate> {
    errors.estimate(set_kind(options), options.samples_a_pixel())
}

/// Renders tiles: makes rays of their pixels, traces them, and makes pixels of what they see.
struct TileRenderer<'a> {
    tracer: Box<dyn Tracer + 'a>,
    deadline: Deadline,
    maker: &'a RayMaker,
    options: &'a Options,
    /// How samples lie, if their error is estimated.
    kind: Option<SetKind>,
    planes: Planes,
    errors: ErrorSums,
    /// Spread of the tile's pixels so far, in squared levels; empty without `-error-map`.
    variances: Vec<f32>,
    filter: Duration,
    /// Scratch: the columns and rows of a tile's pixels, the pixels, places to trace, what is seen through them, and the
    /// colours of a set.
    tile_places: Vec<(u32, u32)>,
    pixels: Vec<Pixel>,
    places: Vec<Place>,
    seen: Vec<Seen>,
    colors: Vec<Vector3>,
}

impl<'a> TileRenderer<'a> {
    fn new(
        scene: &'a Scene,
        plan: &'a Plan,
        options: &'a Options,
        deadline: Deadline,
        maker: &'a RayMaker,
    ) -> Self {
        Self {
            tracer: tracer(scene, plan, deadline),
            deadline,
            maker,
            options,
            kind: wants_estimate(options).then(|| set_kind(options)),
            planes: Planes::wanted_by(options),
            errors: ErrorSums::default(),
            variances: Vec::new(),
            filter: Duration::ZERO,
            tile_places: Vec::new(),
            pixels: Vec::new(),
            places: Vec::new(),
            seen: Vec::new(),
            colors: Vec::new(),
        }
    }

    fn render(&mut self, tile: &Tile, film: &mut Columns) -> TileCost {
        let rays_a_pixel = self.options.samples_a_pixel() as usize;
        let pixels_at_once = (RAYS_AT_ONCE / rays_a_pixel).max(1);
        let (mut places, mut pixels) = (take(&mut self.tile_places), take(&mut self.pixels));
        tile.list_pixels(&mut places);
        pixels.clear();
        let is_whole = places.chunks(pixels_at_once).all(|places| self.resolve(places, &mut pixels));
        pixels.resize(places.len(), Pixel::default());
        store(&pixels, film);
        let cost = self.finished(pixels.len(), film, if is_whole { rays_a_pixel as u32 } else { 0 });
        (self.tile_places, self.pixels) = (places, pixels);
        cost
    }

    /// Renders a tile through which nothing but a background of one colour is seen: one ray shows it.
    fn fill(&mut self, tile: &Tile, film: &mut Columns, empty: &EmptyTiles) -> TileCost {
        let seen = empty.seen_through(tile, &mut *self.tracer);
        // Summed up like any other pixel, because sums round.
        let rays_a_pixel = self.options.samples_a_pixel() as usize;
        let pixel = self.maker.mean(&vec![seen; rays_a_pixel]);
        fill(&pixel, film);
        let pixels = (tile.width * tile.height) as usize;
        self.errors.add_exact(pixels as u64);
        self.variances.resize(if self.planes.error_map { pixels } else { 0 }, 0.0);
        self.finished(pixels, film, 1)
    }

    fn finished(&mut self, pixels: usize, film: &mut Columns, samples: u32) -> TileCost {
        film.set_variances(&self.variances);
        self.variances.clear();
        TileCost {
            samples: SampleCounts::of_pixels(pixels as u64, samples),
            counts: self.tracer.take_counts(),
            errors: take(&mut self.errors),
            filter: take(&mut self.filter),
        }
    }

    /// Traces some pixels of the picture and adds them to `resolved`. Returns false if the deadline came first.
    fn resolve(&mut self, pixels: &[(u32, u32)], resolved: &mut Vec<Pixel>) -> bool {
        if self.deadline.is_over() {
            return false;
        }
        self.maker.set_places(pixels, &mut self.places);
        if !self.tracer.trace(self.maker.grid, &self.places, &mut self.seen) {
            return false;
        }
        let start = self.options.measure.wants_times().then(Instant::now);
        let rays_a_pixel = self.seen.len() / pixels.len();
        let seen = take(&mut self.seen);
        if rays_a_pixel == 1 && !self.options.jitter {
            let first = resolved.len();
            resolved.resize(first + seen.len(), Pixel::default());
            // In place, because copying a pixel takes longer than making it.
            resolved[first..].iter_mut().zip(&seen).for_each(|(pixel, seen)| self.maker.display(seen, pixel));
        } else {
            resolved.extend(seen.chunks(rays_a_pixel).map(|seen| self.resolved(seen)));
        }
        self.seen = seen;
        self.filter += start.map_or(Duration::ZERO, |start| start.elapsed());
        true
    }

    /// Makes one pixel of the picture of everything that its rays saw.
    fn resolved(&mut self, seen: &[Seen]) -> Pixel {
        let mean = self.maker.mean(seen);
        if let Some(kind) = self.kind {
            self.add_error(kind, seen, mean.color);
        }
        mean
    }

    /// Adds the error of a pixel of the picture with this mean colour.
    fn add_error(&mut self, kind: SetKind, seen: &[Seen], mean: Vector3) {
        let samples = self.options.samples();
        let mut spread = Spread::default();
        for (index, seen) in seen.chunks(samples as usize).enumerate() {
            self.colors.clear();
            self.colors.extend(seen.iter().map(|seen| finite(seen.color)));
            self.errors.see(self.colors.iter().fold(Vector3::ZERO, |brightest, &color| brightest.greater(color)));
            let weight = if self.options.filter { filter_weight(index) } else { 1.0 };
            spread.add(&kind.spread(&self.colors), weight as f64 * weight as f64);
        }
        let squared_levels = self.errors.add(kind, mean, &spread, samples);
        if self.planes.error_map {
            self.variances.push(squared_levels as f32);
        }
    }
}

/// Returns whether the error of the picture is to be estimated, and can be.
fn wants_estimate(options: &Options) -> bool {
    options.measure.wants_estimate() && options.samples() > 1 && options.renders_colors()
}

fn set_kind(options: &Options) -> SetKind {
    SetKind::new(options.measure.sampler, options.samples())
}
