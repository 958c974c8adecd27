//! `-convergence`: the error of a scene's picture against what it costs, for each sampler and for adaptive sampling.
//!
//! Pictures of 1, 2, 4 ... N samples a pixel are rendered one after the other. Each is the picture that `-samples`
//! gives with that number. Adaptive sampling then goes for errors of the range that these pictures have. [`table`] has
//! one line for each picture, [`figure`] the curves, and [`page`] all of it with the picture.
//!
//! A first picture is thrown away, so that no point contains what is done once: reading cube map faces, building
//! trees. A picture that takes almost no time is rendered several times, and its time is the median.
//!
//! Each picture is rendered from the start. Sobol's sequence could be continued from one to the next, but a sample that is
//! added to a kept sum takes 1.2 times the instructions, so the curve would tell other times than `-samples` takes; and of
//! all pictures' samples it would save less than a sixth.

mod axis;
mod curve;
mod figure;
mod page;
mod svg;
mod table;
mod words;

use super::reference::{Reference, TrueError};
use crate::options::{Options, SamplerKind, has_extension};
use crate::plan::Plan;
use crate::render::error_estimate::ErrorEstimate;
use crate::render::{Frame, Progress, render_adaptive, render_uniform, render_uniform_before};
use crate::scene::Scene;
use crate::timing::{Deadline, Times, timed};
use std::path::Path;
use std::time::Duration;

/// When no more pictures are rendered.
const INTERRUPT: Deadline = Deadline::ON_INTERRUPT;

/// How the samples of a picture are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The same number in every pixel.
    Fixed(SamplerKind),
    /// Where they are needed, until the estimated error is below a target.
    Adaptive,
}

impl Method {
    fn name(self) -> &'static str {
        match self {
            Self::Fixed(sampler) => sampler.name(),
            Self::Adaptive => "adaptive",
        }
    }
}

/// A picture of a curve.
#[derive(Clone, Debug)]
pub struct Point {
    pub method: Method,
    /// A pixel of the traced grid, in the mean.
    pub samples: f64,
    /// Samples a pixel of the picture, as they are asked for; of adaptive sampling all camera rays, because it traces
    /// some before it takes samples.
    pub samples_a_pixel: f64,
    /// Camera rays a pixel of the picture: fewer than samples where it shows nothing but background.
    pub camera_rays: f64,
    /// The error that adaptive sampling was to reach, in levels.
    pub target: Option<f64>,
    pub times: Times,
    /// Of all kinds.
    pub rays: u64,
    pub estimate: Option<ErrorEstimate>,
    pub true_error: Option<TrueError>,
}

impl Point {
    /// Returns the error in levels: the true one if it is known, otherwise the estimated one.
    fn error(&self) -> Option<f64> {
        let estimated = || self.estimate.map(|estimate| estimate.levels.rmse);
        self.true_error.as_ref().map(|error| error.rmse_levels).or_else(estimated)
    }

    fn cpu_seconds(&self) -> f64 {
        self.times.cpu.as_secs_f64()
    }
}

/// All curves of a scene.
#[derive(Debug)]
pub struct Convergence {
    pub points: Vec<Point>,
    /// Whether all points are there that were asked for. Ctrl-C ends rendering and keeps what is done.
    pub is_whole: bool,
}

/// Renders the pictures of all curves. Returns the picture that the options ask for, or after Ctrl-C the one with the most
/// samples, and the points.
pub fn render(
    scene: &Scene,
    plan: &Plan,
    options: &Options,
    reference: Option<&Reference>,
    progress: &dyn Progress,
) -> (Frame, Convergence) {
    let studio = Studio { scene, plan, reference, progress };
    let own = options.measure.sampler;
    let is_given = options.measure.sampler_is_given;
    let samplers: Vec<_> = SamplerKind::ALL.into_iter().filter(|&kind| !is_given || kind == own).collect();
    let mut frame = render_uniform(scene, plan, &with_samples(options, own, 1), progress);
    let mut pictures = Vec::new();
    let doubled = |samples: &u32| (*samples < options.samples()).then(|| (2 * samples).min(options.samples()));
    for samples in std::iter::successors(Some(1), doubled) {
        for &sampler in &samplers {
            let picture = studio.picture(Method::Fixed(sampler), with_samples(options, sampler, samples));
            let Some((found, picture)) = picture else { break };
            pictures.push(picture);
            if sampler == own {
                frame = found;
            }
        }
    }
    let mut adaptive = options.clone();
    adaptive.measure.sampler = if is_given { own } else { SamplerKind::Sobol };
    for target in targets(pictures.iter().map(|picture| &picture.point)) {
        adaptive.measure.target_error = Some(target);
        pictures.extend(studio.picture(Method::Adaptive, adaptive.clone()).map(|(_, picture)| picture));
    }
    let is_whole = !INTERRUPT.is_over();
    studio.measure_short_ones_again(&mut pictures);
    let mut points: Vec<_> = pictures.into_iter().map(Picture::point).collect();
    points.sort_by_key(|point| match point.method {
        Method::Fixed(kind) => SamplerKind::ALL.iter().position(|&other| other == kind),
        Method::Adaptive => Some(SamplerKind::ALL.len()),
    });
    (frame, Convergence { points, is_whole })
}

fn with_samples(options: &Options, sampler: SamplerKind, samples: u32) -> Options {
    let mut options = options.clone();
    options.measure.sampler = sampler;
    options.measure.samples = Some(samples);
    options
}

/// What all pictures of the curves have in common.
struct Studio<'a> {
    scene: &'a Scene,
    plan: &'a Plan,
    reference: Option<&'a Reference>,
    progress: &'a dyn Progress,
}

/// A point, and how to render its picture again.
struct Picture {
    options: Options,
    point: Point,
    /// Of each rendering.
    times: Vec<Times>,
}

impl Studio<'_> {
    fn render(&self, method: Method, options: &Options) -> Frame {
        match method {
            Method::Fixed(_) => render_uniform_before(self.scene, self.plan, options, INTERRUPT, self.progress),
            Method::Adaptive => render_adaptive(self.scene, self.plan, options, INTERRUPT, self.progress),
        }
    }

    /// Renders a picture and measures it. `None` after an interrupt: the picture may not be whole.
    fn picture(&self, method: Method, options: Options) -> Option<(Frame, Picture)> {
        if INTERRUPT.is_over() {
            return None;
        }
        let (frame, times) = timed(|| self.render(method, &options));
        if INTERRUPT.is_over() {
            return None;
        }
        let pixels = f64::from(options.width) * f64::from(options.height);
        let grid = f64::from(options.grid_pixels());
        let camera_rays = frame.counts.camera as f64 / pixels;
        let (samples, samples_a_pixel) = match method {
            Method::Fixed(_) => (f64::from(options.samples()), f64::from(options.samples()) * grid),
            Method::Adaptive => (frame.samples.mean() / grid, camera_rays),
        };
        let point = Point {
            method,
            samples,
            samples_a_pixel,
            camera_rays,
            target: options.measure.target_error,
            times,
            rays: frame.counts.total(),
            estimate: frame.estimate,
            true_error: self.reference.and_then(|reference| reference.error_of(&frame.film)),
        };
        Some((frame, Picture { options, point, times: vec![times] }))
    }

    /// Renders pictures that take almost no time again. In rounds over all of them, because what disturbs a machine
    /// for a moment would else be all that is known of one point.
    fn measure_short_ones_again(&self, pictures: &mut [Picture]) {
        /// Pictures that have taken so long are measured well enough.
        const LONG: Duration = Duration::from_millis(100);
        const ROUNDS: usize = 6;
        for _ in 0..ROUNDS {
            for picture in &mut *pictures {
                if picture.times.iter().map(|times| times.cpu).sum::<Duration>() < LONG {
                    let (_, times) = timed(|| self.render(picture.point.method, &picture.options));
                    // What was interrupted says nothing.
                    picture.times.extend((!INTERRUPT.is_over()).then_some(times));
                }
            }
        }
    }
}

impl Picture {
    /// Returns the point with the median times.
    fn point(self) -> Point {
        let median = |of: fn(&Times) -> Duration| {
            let mut some: Vec<_> = self.times.iter().map(of).collect();
            some.sort();
            some[some.len() / 2]
        };
        let times = Times { wall: median(|times| times.wall), cpu: median(|times| times.cpu) };
        Point { times, ..self.point }
    }
}

/// Returns the points as the file that is asked for: a page, a figure or a table.
///
/// # Errors
/// As [`page::html`].
pub fn shown(path: &Path, options: &Options, frame: &Frame, curves: &Convergence) -> std::io::Result<String> {
    if has_extension(path, "html") {
        page::html(options, frame, curves)
    } else if has_extension(path, "svg") {
        Ok(figure::svg(options, curves))
    } else {
        // Most readers of tables take a line that begins so for a comment, or can be told to.
        let remark = if curves.is_whole { String::new() } else { format!("# {}\n", words::INTERRUPTED) };
        Ok(table::csv(&curves.points) + &remark)
    }
}

pub use words::sentences;

/// Returns the target errors of adaptive sampling: powers of two, or of its root where these are few, between the errors
/// of these points. Estimated errors, because adaptive sampling knows no others.
fn targets<'a>(points: impl Iterator<Item = &'a Point>) -> Vec<f64> {
    const FEW: usize = 3;
    let errors = points.filter_map(|point| Some(point.estimate?.levels.rmse)).filter(|&error| error > 0.0);
    let (least, most) = errors.fold((f64::INFINITY, 0.0_f64), |(least, most), e| (least.min(e), most.max(e)));
    let powers = |steps: f64| {
        let (first, last) = ((steps * most.log2()).floor() as i32, (steps * least.log2()).ceil() as i32);
        (last..=first).rev().map(|power| (f64::from(power) / steps).exp2()).collect::<Vec<_>>()
    };
    if least > most {
        return Vec::new();
    }
    let whole = powers(1.0);
    if whole.len() < FEW { powers(2.0) } else { whole }
}

#[cfg(test)]
mod tests;
