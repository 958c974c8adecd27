//! What `-depth auto` and `-depth-background` need to know: how far away things are, and where there is nothing.
//!
//! Both trace camera rays a second time, and only where they are asked for. So no depths must be kept as numbers, and
//! the picture of `-depth auto` is that of the same range typed in.

use super::tiles::Progress;
use super::uniform;
use crate::camera::PixelGrid;
use crate::objects::Hit;
use crate::options::{DepthPicture, MeasureOptions, Options};
use crate::plan::Plan;
use crate::scene::Scene;
use rayon::prelude::*;
use std::borrow::Cow;
use vecmath::{Real, Vector3};

/// Finds the range of `-depth auto`. Where nothing is hit, it stays as it is.
pub fn with_range<'a>(scene: &Scene, options: &'a Options) -> Cow<'a, Options> {
    let Some(depth) = options.depth.as_ref().filter(|depth| depth.is_auto) else { return Cow::Borrowed(options) };
    let Some((min, max)) = find_range(scene, options) else { return Cow::Borrowed(options) };
    let depth = DepthPicture { min, max, ..depth.clone() };
    Cow::Owned(Options { depth: Some(depth), ..options.clone() })
}

/// Returns whether rays through the corners of pixels hit anything between two distances.
pub fn has_hit_between(scene: &Scene, options: &Options, (a, b): (f64, f64)) -> bool {
    let range = a.min(b) as Real..=a.max(b) as Real;
    let rows = (0..options.height).into_par_iter();
    rows.any(|row| hits(scene, options, row).any(|hit| range.contains(&hit.surface.t)))
}

/// Iterates over what rays through the corners of a row's pixels hit.
fn hits(scene: &Scene, options: &Options, row: u32) -> impl Iterator<Item = Hit> {
    let grid = PixelGrid { width: options.width, height: options.height };
    let ray = move |x| scene.camera.ray(grid.ndc(grid.place((x, row), (0.0, 0.0))));
    (0..options.width).filter_map(move |x| scene.geometry.closest_hit(&ray(x)))
}

/// Returns the range of the distances that rays through the corners of all pixels find, rounded outward to a thousandth
/// of itself or better. `None` if they hit nothing. Where all distances are equal, the range begins at 0.
///
/// It ends with the farthest object that has an end itself: a plane goes on to the horizon, and all else would look black.
/// Where only planes are seen, it ends with them.
fn find_range(scene: &Scene, options: &Options) -> Option<(f64, f64)> {
    let range_of_row = |row: u32| {
        hits(scene, options, row).fold(Range::NOTHING, |range, hit| {
            let t = hit.surface.t;
            let has_end = scene.geometry.objects[hit.object as usize].bounds.is_some();
            range.joined(Range { nearest: t, farthest: t, farthest_end: if has_end { t } else { 0.0 } })
        })
    };
    let rows = (0..options.height).into_par_iter();
    let Range { nearest, farthest, farthest_end } =
        rows.map(range_of_row).reduce(|| Range::NOTHING, Range::joined);
    let end = if farthest_end > nearest { farthest_end } else { farthest };
    (nearest <= end).then(|| rounded_outward(nearest as f64, end as f64))
}

/// Distances of what is hit.
#[derive(Clone, Copy)]
struct Range {
    nearest: Real,
    farthest: Real,
    /// Of the farthest object that has an end; 0 if there is none.
    farthest_end: Real,
}

impl Range {
    const NOTHING: Self = Self { nearest: Real::INFINITY, farthest: 0.0, farthest_end: 0.0 };

    fn joined(self, other: Self) -> Self {
        Self {
            nearest: self.nearest.min(other.nearest),
            farthest: self.farthest.max(other.farthest),
            farthest_end: self.farthest_end.max(other.farthest_end),
        }
    }
}

fn rounded_outward(low: f64, high: f64) -> (f64, f64) {
    let size = if high > low { high - low } else { high };
    let low = if high > low { low } else { 0.0 };
    // The exponent of ten, without logarithms, whose last bits differ between machines.
    let exponent = format!("{size:e}").split_once('e').and_then(|parts| parts.1.parse::<i32>().ok()).unwrap_or(0);
    let decimals = 3 - exponent;
    // Numbers are scaled by whole powers of ten and written as decimals, so that they are what a person would type.
    let typed = |steps: f64| format!("{steps:.0}e{}", -decimals).parse::<f64>().unwrap_or(steps);
    let scaled = |number: f64| {
        format!("{number:e}").split_once('e').map_or(number, |(digits, power)| {
            format!("{digits}e{}", power.parse::<i32>().unwrap_or(0) + decimals).parse::<f64>().unwrap_or(number)
        })
    };
    (typed(scaled(low).floor()), typed(scaled(high).ceil()))
}

/// Returns the picture of depths with three bytes a pixel, in which `background` is seen where nothing is hit. `depths` has
/// one byte a pixel. The same rays as in the picture are traced, or with adaptive sampling as many as without it.
pub fn with_background(
    depths: &[u8],
    background: Vector3,
    scene: &Scene,
    plan: &Plan,
    options: &Options,
    progress: &dyn Progress,
) -> Vec<u8> {
    let Some(depth) = &options.depth else { return Vec::new() };
    // Everything that is hit lies beyond this range, so it is shown white.
    let everything = DepthPicture { min: -1.0, max: 0.0, ..depth.clone() };
    let mut options = Options { color: None, normals: None, depth: Some(everything), ..options.clone() };
    options.measure = MeasureOptions {
        sampler: options.measure.sampler,
        samples: options.measure.samples,
        ..Default::default()
    };
    let depths_only = Plan { color: false, normals: false, depth: true, ..plan.clone() };
    let hits = uniform::render(scene, &depths_only, &options, progress).film.depth.unwrap_or_default();
    let mut bytes = Vec::with_capacity(3 * depths.len());
    for (&depth, &hit) in depths.iter().zip(&hits) {
        let missed = Real::from(255 - hit) / 255.0;
        let shown = background.map(|c| (c * missed * 255.0).round() + Real::from(depth));
        bytes.extend(shown.to_array().map(|level| level as u8));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_rounded_outward_to_few_digits() {
        for (range, rounded) in [
            ((8.123_456, 17.987_654), (8.123, 17.988)),
            ((0.8, 1.0), (0.8, 1.0)),
            ((0.812_345_6, 0.998_765_4), (0.8123, 0.9988)),
            ((123_456.7, 987_654.3), (123_400.0, 987_700.0)),
            ((10.0, 10.0), (0.0, 10.0)),
            ((1e-7, 2.000_000_1e-7), (1e-7, 2.001e-7)),
        ] {
            assert_eq!(rounded_outward(range.0, range.1), rounded, "{range:?}");
        }
    }
}
