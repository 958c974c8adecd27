//! The map of estimated errors: variances of pixels, pooled over their neighbours.

use super::error_estimate::ErrorEstimate;
use rayon::prelude::*;

/// Makes squared errors of the spread of pixels in squared levels, rows of `width`.
///
/// The samples of one pixel often agree though they are wrong: an edge crosses many pixels, and few samples miss it in
/// some. So neighbours have a say, and no pixel is stated to be exact.
pub fn finished(spread: &[f32], width: usize, factor: f64, estimate: &ErrorEstimate) -> Vec<f32> {
    let least = estimate.expected_unseen();
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
    let row_of = |row: usize| &values[row * width..(row + 1) * width];
    let pool_row = |(row, pooled): (usize, &mut [f32])| {
        let this = row_of(row);
        let others = [row.checked_sub(1), Some(row + 1).filter(|&next| next < height)];
        let count = others.into_iter().flatten().count() as f32;
        // Of each column the weighted sum of the three rows: what it is for the pixel in it, and for those beside it.
        let mut of_side = this.to_vec();
        pooled.iter_mut().zip(this).for_each(|(sum, value)| *sum = own * value);
        for row in others.into_iter().flatten().map(row_of) {
            for ((middle, side), value) in pooled.iter_mut().zip(&mut of_side).zip(row) {
                *middle += BESIDE * value;
                *side += DIAGONAL * value;
            }
        }
        let (middle_weight, side_weight) = (own + BESIDE * count, BESIDE + DIAGONAL * count);
        pooled.iter_mut().skip(1).zip(&of_side).for_each(|(sum, side)| *sum += side);
        pooled.iter_mut().zip(&of_side[1..]).for_each(|(sum, side)| *sum += side);
        // The first and the last pixel have one side less.
        let weight = |sides: usize| middle_weight + sides as f32 * side_weight;
        match pooled {
            [only] => *only /= weight(0),
            [first, inner @ .., last] => {
                [first, last].into_iter().for_each(|sum| *sum /= weight(1));
                inner.iter_mut().for_each(|sum| *sum /= weight(2));
            }
            [] => {}
        }
    };
    let mut pooled = vec![0.0; values.len()];
    pooled.par_chunks_mut(width).enumerate().for_each(pool_row);
    pooled
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_averaged_over_neighbours() {
        // A corner: 4 times itself, twice a pixel beside it, half a pixel across.
        let values = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
        assert_eq!(pooled(&values, 3)[0], (4.0 + 2.0 + 8.0 + 8.0) / 6.5);
        assert_eq!(pooled(&values, 3)[4], (64.0 + 2.0 + 8.0 + 32.0 + 0.5 + 2.0) / 8.0);
        assert_eq!(of_neighbours(&values, 3)[4], (2.0 + 8.0 + 32.0 + 0.5 + 2.0) / 4.0);
        assert_eq!(of_neighbours(&[3.0], 1), [3.0]);
    }
}
