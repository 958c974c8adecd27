//! The map of estimated errors: variances of pixels, pooled over their neighbours.

use super::error_estimate::{EXPECTED, ErrorEstimate};
use rayon::prelude::*;

/// Makes squared errors of the spread of pixels in squared levels, rows of `width`.
///
/// The samples of one pixel often agree though they are wrong: an edge crosses many pixels, and few samples miss it in
/// some. So neighbours have a say, and no pixel is stated to be exact.
pub fn finished(spread: &[f32], width: usize, factor: f64, estimate: &ErrorEstimate) -> Vec<f32> {
    let least = EXPECTED * estimate.unseen.powi(2);
    pooled(spread, width).into_iter().map(|spread| (f64::from(spread) * factor + least) as f32).collect()
}

/// Averages values over the pixel itself and those beside and across.
pub fn pooled(values: &[f32], width: usize) -> Vec<f32> {
    pooled_with(values, width, 4.0)
}

/// Averages values over the pixels beside and across, not the pixel itself. The only pixel of a picture gets its own.
pub fn of_neighbours(values: &[f32], width: usize) -> Vec<f32> {
    pooled_with(values, width, if values.len() > 1 { 0.0 } else { 1.0 })
}

fn pooled_with(values: &[f32], width: usize, own: f32) -> Vec<f32> {
    const BESIDE: f32 = 1.0;
    const DIAGONAL: f32 = 0.5;
    let height = values.len() / width;
    let pixel = |index: usize| {
        let (x, row) = ((index % width) as isize, (index / width) as isize);
        let (mut sum, mut weights) = (0.0, 0.0);
        for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
            let (x, row) = (x + dx, row + dy);
            if x < 0 || row < 0 || x >= width as isize || row >= height as isize {
                continue;
            }
            let weight = [own, BESIDE, DIAGONAL][(dx.abs() + dy.abs()) as usize];
            sum += weight * values[row as usize * width + x as usize];
            weights += weight;
        }
        sum / weights
    };
    (0..values.len()).into_par_iter().map(pixel).collect()
}
