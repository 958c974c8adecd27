//! `-convergence`: a table of error against cost, from one run.
//!
//! Pictures of 1, 2, 4 ... N samples a pixel are rendered one after the other. Each is the picture that `-samples`
//! gives with that number, and each line of the table has the cost of one picture. (Adding samples to the previous
//! picture would cost half as much, but a stratified set of samples cannot be extended.)

use super::reference::{Reference, TrueError};
use crate::options::Options;
use crate::plan::Plan;
use crate::render::error_estimate::ErrorEstimate;
use crate::render::{Frame, Progress, render_uniform};
use crate::scene::Scene;
use crate::timing::{Times, timed};
use std::fmt::Write as _;

/// A line of the table.
#[derive(Clone, Debug)]
pub struct Point {
    /// Per pixel of the traced grid.
    pub samples: u32,
    pub times: Times,
    /// Of all kinds.
    pub rays: u64,
    pub estimate: Option<ErrorEstimate>,
    pub true_error: Option<TrueError>,
}

/// Renders all pictures. Returns the last one and the table.
pub fn render_doubling(
    scene: &Scene,
    plan: &Plan,
    options: &Options,
    reference: Option<&Reference>,
    progress: &dyn Progress,
) -> (Frame, Vec<Point>) {
    let mut points = Vec::new();
    let mut current = options.clone();
    let mut samples = 1;
    loop {
        current.measure.samples = Some(samples);
        let (frame, times) = timed(|| render_uniform(scene, plan, &current, progress));
        points.push(Point {
            samples,
            times,
            rays: frame.counts.total(),
            estimate: frame.estimate,
            true_error: reference.and_then(|reference| reference.error_of(&frame.film)),
        });
        if samples == options.samples() {
            return (frame, points);
        }
        samples = (2 * samples).min(options.samples());
    }
}

/// Returns the table as CSV; unknown values are empty.
pub fn csv(options: &Options, points: &[Point]) -> String {
    let mut text = "sampler,samples,seconds,cpu_seconds,rays,estimated_rmse_levels,estimated_low_95,\
                    estimated_high_95,estimated_rmse_linear,true_rmse_levels,true_rmse_linear,true_ssim\n"
        .to_owned();
    let known = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    for point in points {
        let (levels, linear) = (point.estimate.map(|e| e.levels), point.estimate.map(|e| e.linear));
        let fields = [
            options.measure.sampler.name().to_owned(),
            point.samples.to_string(),
            point.times.wall.as_secs_f64().to_string(),
            point.times.cpu.as_secs_f64().to_string(),
            point.rays.to_string(),
            known(levels.map(|levels| levels.rmse)),
            known(levels.map(|levels| levels.low)),
            known(levels.map(|levels| levels.high)),
            known(linear.map(|linear| linear.rmse)),
            known(point.true_error.as_ref().map(|error| error.rmse_levels)),
            known(point.true_error.as_ref().map(|error| error.rmse_linear)),
            known(point.true_error.as_ref().map(|error| error.ssim)),
        ];
        let _ = writeln!(text, "{}", fields.join(","));
    }
    text
}
