//! [`SetKind`]: what the samples of one pixel say about the error of their mean, without a second set to compare with.
//!
//! Samples that are spread evenly are not independent: the differences within a set are larger than the error of its
//! mean. Write V(m) for the squared error of sets of m samples. Of a set of n samples, made of two halves that are
//! evenly spread themselves, the means of the halves differ by
//!
//! S = (difference of the means)^2 / 4, whose expectation is V(n / 2) - V(n).
//!
//! (This is exact for any sets whose halves are exchangeable: 2 V(n) is the mean of V(n / 2) less the mean squared
//! difference of the halves.) So V(n) = S / (2^a - 1) if V falls as n^-a. Summed over a whole picture, S is the *fine*
//! spread here, and the picture keeps all its samples in one set.
//!
//! - Sobol: the halves are the first and second half of a set. The *coarse* spread compares pairs of samples that follow
//!   one another, in the same unit. It is equal to the fine one for noise, and for details smaller than the distance of
//!   two samples: these are *unresolved*, their samples are as if independent, and S is the error. It is larger once
//!   details are resolved. If V falls by one power all the way, it tells that too: (n / 2)^(a - 1) is the ratio of the two.
//! - Stratified: in a block of two by two cells there are three differences: along x, along y and crosswise. Each is the
//!   sum of the errors of the cells, and of the difference of their true means, which is smallest crosswise: 0 for a
//!   slope. So the fine spread is the crosswise one, and the coarse one the mean of all three.
//! - Independent: every sample is a group, and the factor is 1.
//!
//! [`spread_factor`](super::spread_factor) has the factors.

use super::stratified::Cells;
use crate::options::SamplerKind;
use vecmath::{Real, Vector3};

/// Differences between the samples of a pixel, for each channel: fine and coarse as in the module's docs. The fine one is
/// nearer to the error of a picture; of a single pixel the coarse one says more, because more samples are compared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    pub fine: [f64; 3],
    pub coarse: [f64; 3],
}

impl Spread {
    /// Returns the fine and the coarse spread, averaged over the channels.
    pub fn means(&self) -> [f64; 2] {
        [mean_of(self.fine), mean_of(self.coarse)]
    }

    /// Adds the spread of another pixel times a weight.
    pub fn add(&mut self, other: &Self, weight: f64) {
        for c in 0..3 {
            self.fine[c] += weight * other.fine[c];
            self.coarse[c] += weight * other.coarse[c];
        }
    }
}

/// Returns the mean over the channels.
pub fn mean_of(channels: [f64; 3]) -> f64 {
    channels.iter().sum::<f64>() / 3.0
}

/// How the samples of a pixel lie, as far as their differences depend on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SetKind {
    /// Independent samples, or independent sets of which only the means are compared.
    Independent,
    /// Samples of a sequence, so many.
    Sobol(u32),
    /// Sequences of several lengths, whose factors are in their spread already.
    Sequences,
    /// Cells in rows of so many; their number, and the number of rows, is even.
    Grid(u32),
    /// Cells that do not come in blocks of four.
    Rows(Cells),
}

impl SetKind {
    /// Returns the kind of the sets of `samples` samples.
    pub fn new(sampler: SamplerKind, samples: u32) -> Self {
        match sampler {
            SamplerKind::Independent => Self::Independent,
            SamplerKind::Sobol => Self::Sobol(samples),
            SamplerKind::Stratified => {
                let cells = Cells::new(samples);
                let is_even = |count: u32| count.is_multiple_of(2);
                match cells.in_longer_rows == 0 && is_even(cells.columns) && is_even(samples / cells.columns) {
                    true => Self::Grid(cells.columns),
                    false => Self::Rows(cells),
                }
            }
        }
    }

    /// Returns the spread of a set of at least two colours.
    pub fn spread(self, colors: &[Vector3]) -> Spread {
        match self {
            Self::Independent | Self::Sequences => {
                let spread = between(colors.iter().copied(), colors.len());
                Spread { fine: spread, coarse: spread }
            }
            Self::Sobol(_) => {
                let (first, second) = colors.split_at(colors.len().div_ceil(2));
                let fine = square(mean(first) - mean(second)).map(|square| square / 4.0);
                Spread { fine, coarse: of_pairs(std::iter::once(colors), colors.len()) }
            }
            Self::Grid(columns) => of_blocks(colors, columns as usize),
            Self::Rows(cells) => {
                let (longer, others) = colors.split_at(cells.in_longer_rows as usize);
                let columns = cells.columns as usize;
                let fine = of_pairs(longer.chunks(columns + 1).chain(others.chunks(columns)), colors.len());
                Spread { fine, coarse: fine }
            }
        }
    }
}

/// Returns S(G) of the means of G groups.
fn between(means: impl Iterator<Item = Vector3> + Clone, count: usize) -> [f64; 3] {
    let count = count as f64;
    let mean = means.clone().fold(Vector3::ZERO, |sum, mean| sum + mean) * (1.0 / count as Real);
    let squares = means.map(|group| square(group - mean)).fold([0.0; 3], add);
    squares.map(|sum| sum / (count * (count - 1.0)))
}

/// Returns the spread within pairs of neighbours in rows of so many colours altogether.
fn of_pairs<'a>(rows: impl Iterator<Item = &'a [Vector3]>, colors: usize) -> [f64; 3] {
    let pairs = rows.flat_map(|row| row.chunks_exact(2)).map(|pair| square(pair[0] - pair[1]));
    let (sum, count) = pairs.fold(([0.0; 3], 0.0), |(sum, count), pair| (add(sum, pair), count + 1.0));
    sum.map(|sum| sum / (2.0 * count * colors as f64))
}

/// Returns the spread within blocks of two by two cells, by their differences along x, along y and crosswise.
fn of_blocks(colors: &[Vector3], columns: usize) -> Spread {
    let (mut fine, mut coarse) = ([0.0; 3], [0.0; 3]);
    for rows in colors.chunks_exact(2 * columns) {
        let (upper, lower) = rows.split_at(columns);
        for (a, b) in upper.chunks_exact(2).zip(lower.chunks_exact(2)) {
            let along_x = square(a[0] - a[1] + b[0] - b[1]);
            let along_y = square(a[0] + a[1] - b[0] - b[1]);
            let crosswise = square(a[0] - a[1] - b[0] + b[1]);
            for c in 0..3 {
                fine[c] += crosswise[c];
                coarse[c] += (along_x[c] + along_y[c] + crosswise[c]) / 3.0;
            }
        }
    }
    let squared_count = (colors.len() as f64).powi(2);
    Spread { fine: fine.map(|sum| sum / squared_count), coarse: coarse.map(|sum| sum / squared_count) }
}

/// Returns the mean of colours.
pub fn mean(colors: &[Vector3]) -> Vector3 {
    colors.iter().fold(Vector3::ZERO, |sum, &color| sum + color) * (1.0 / colors.len() as Real)
}

fn square(difference: Vector3) -> [f64; 3] {
    difference.to_array().map(|d| (d as f64).powi(2))
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(values: impl IntoIterator<Item = f64>) -> Vec<Vector3> {
        values.into_iter().map(|value| Vector3::splat(value as Real)).collect()
    }

    #[test]
    fn independent_samples_give_the_textbook_variance() {
        // Mean 2, squares of deviations 1 + 1 + 0 + 0, divided by 4 * 3.
        let spread = SetKind::Independent.spread(&gray([1.0, 3.0, 2.0, 2.0]));
        assert!((spread.fine[0] - 2.0 / 12.0).abs() < 1e-7);
    }

    #[test]
    fn halves_and_pairs_of_a_sequence_are_compared() {
        let spread = SetKind::Sobol(8).spread(&gray([0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 4.0]));
        assert!((spread.fine[1] - 1.5f64.powi(2) / 4.0).abs() < 1e-7, "{spread:?}");
        assert!((spread.coarse[1] - 4.0 / 64.0).abs() < 1e-7, "{spread:?}");
        let odd = SetKind::Sobol(3).spread(&gray([0.0, 1.0, 4.0]));
        assert!((odd.fine[0] - 3.5f64.powi(2) / 4.0).abs() < 1e-6, "{odd:?}");
    }

    #[test]
    fn cells_are_compared_in_pairs_within_their_rows() {
        let kind = |samples| SetKind::new(SamplerKind::Stratified, samples);
        assert!((kind(2).spread(&gray([0.0, 1.0])).fine[0] - 0.25).abs() < 1e-7);
        assert_eq!(kind(9), SetKind::Rows(Cells::new(9)));
        // Rows of three, three and two: no pair has cells of two rows.
        let spread = kind(8).spread(&gray([1.0, 1.0, 5.0, 2.0, 2.0, 6.0, 3.0, 4.0]));
        assert!((spread.fine[0] - 1.0 / (2.0 * 3.0 * 8.0)).abs() < 1e-7, "{spread:?}");
    }
}
