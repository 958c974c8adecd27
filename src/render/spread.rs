//! [`SetKind`]: what the samples of one pixel say about the error of their mean, without a second set to compare with.
//!
//! Samples that are spread evenly are not independent: the differences within a set are larger than the error of its
//! mean, by a factor that depends on how fast the error falls with the number of samples. Write V(m) for the squared
//! error of sets of m samples. The set of n samples is divided into G *groups* that are evenly spread sets themselves.
//! The means of the groups differ by
//!
//! S(G) = sum of (mean of group - mean)^2 / (G (G - 1)), whose expectation is (V(n / G) - V(n)) / (G - 1).
//!
//! (This is exact for any sets whose groups are exchangeable: G V(n) is the mean of V(n / G) less the mean squared
//! differences.) Two such numbers, S(2) and S(4), summed over the whole picture, give V(n) if it falls as a power of
//! n: V(n) = S(2) / (3 S(4) / S(2) - 2). So the picture keeps all its samples in one set.
//!
//! - Sobol: the first and second half of a set, and its quarters, are such groups.
//! - Stratified: four neighbouring cells hold one sample of each of four groups. Their differences along x, along y
//!   and crosswise are known one by one. A jittered cell says nothing of the variance within itself, so a power law is
//!   not enough: [`SetKind::factor`] tells what was measured.
//! - Independent: every sample is a group, and the factor is 1.

use crate::options::SamplerKind;
use vecmath::{Real, Vector3};

/// Differences between the samples of a pixel, for each channel: the S(2) and S(4) of the module's docs.
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

/// The ratio S(4)/S(2) of Sobol samples if the squared error falls as n^-1.5, as at edges.
pub const USUAL_RATIO: f64 = 1.276;

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
    /// Cells that do not come in blocks of four: so many samples, rows of so many.
    Rows(u32, u32),
}

impl SetKind {
    /// Returns the kind of the sets of `samples` samples; `columns` is the number of cells in each row, 0 if the rows
    /// differ.
    pub fn new(sampler: SamplerKind, samples: u32, columns: u32) -> Self {
        match sampler {
            SamplerKind::Independent => Self::Independent,
            SamplerKind::Sobol => Self::Sobol(samples),
            SamplerKind::Stratified if columns > 0 && [columns, samples / columns].iter().all(|n| n % 2 == 0) => {
                Self::Grid(columns)
            }
            SamplerKind::Stratified => Self::Rows(samples, columns.max(1)),
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
                let groups = |count: usize| {
                    let size = colors.len().div_ceil(count);
                    between(colors.chunks(size).map(mean), colors.len().div_ceil(size))
                };
                let fine = groups(2);
                Spread { fine, coarse: if colors.len() < 4 { fine } else { groups(4) } }
            }
            Self::Grid(columns) => of_blocks(colors, columns as usize),
            Self::Rows(_, columns) => {
                let rows = colors.chunks(columns.max(2) as usize);
                let pairs = rows.flat_map(|row| row.chunks_exact(2)).map(|pair| square(pair[0] - pair[1]));
                let (sum, count) = pairs.fold(([0.0; 3], 0.0), |(sum, count), pair| (add(sum, pair), count + 1.0));
                let fine = sum.map(|sum| sum / (2.0 * count * colors.len() as f64));
                Spread { fine, coarse: fine }
            }
        }
    }

    /// Returns the squared error of the mean as a multiple of S(2), for a whole picture in which S(4)/S(2) is `ratio`.
    ///
    /// For n >= 16 Sobol samples it is the power law of the module's docs. Sets below 16 samples do not follow a power
    /// law yet: the numbers are the means over the seven scenes of `data/`. In a grid, 1 is exact for what is as rough as noise (ratio
    /// 1), and 1/4 for what is smooth (ratio 5/4); edges at all angles, at ratios 1.09 to 1.17, were measured at 0.38
    /// to 0.59. See docs/error-estimate.md.
    pub fn factor(self, ratio: f64) -> f64 {
        match self {
            Self::Independent | Self::Sequences => 1.0,
            Self::Sobol(0..4) => 1.0 / 2.6,
            Self::Sobol(4..8) => 1.0 / 2.2,
            Self::Sobol(samples) if samples < 16 || samples % 4 != 0 => 1.0 / 2.0,
            Self::Sobol(_) => 1.0 / (3.0 * ratio.clamp(1.0, 2.0) - 2.0),
            Self::Grid(_) => interpolated(&[(1.0, 1.0), (1.12, 0.47), (1.18, 0.47), (1.25, 0.25)], ratio),
            Self::Rows(2, _) => 1.0 / 1.3,
            Self::Rows(..) => 1.0 / 2.1,
        }
    }

    /// Returns the standard deviation of the logarithm of [`factor`](Self::factor), from scene to scene.
    pub fn factor_deviation(self) -> f64 {
        match self {
            Self::Independent => 0.0,
            Self::Sobol(_) | Self::Sequences => 0.22,
            Self::Grid(4..) => 0.25,
            Self::Grid(_) | Self::Rows(..) => 0.35,
        }
    }

    /// Returns the variance of the difference between a pixel's estimate and its squared error, as a multiple of the
    /// square of the estimate. `sets` is the number of means that were compared.
    pub fn relative_variance(self, sets: u32) -> f64 {
        match self {
            Self::Independent => {
                let (sets, kurtosis) = (f64::from(sets), 2.0);
                2.0 * sets / (sets - 1.0) / (1.0 + (kurtosis - 3.0) / sets + 2.0 / (sets - 1.0))
            }
            // Two halves, as above; and many blocks, whose estimate is steadier than the error.
            Self::Sobol(_) | Self::Sequences => 1.6,
            Self::Grid(_) | Self::Rows(..) => 2.0,
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
                let along = along_x[c] + along_y[c];
                fine[c] += (along + 2.0 * crosswise[c]) / 4.0;
                coarse[c] += (along + crosswise[c]) / 3.0;
            }
        }
    }
    let squared_count = (colors.len() as f64).powi(2);
    Spread { fine: fine.map(|sum| sum / squared_count), coarse: coarse.map(|sum| sum / squared_count) }
}

/// Returns the value at `x` of straight lines between points, and of the outermost points beyond them.
fn interpolated(points: &[(f64, f64)], x: f64) -> f64 {
    let (first, last) = (points[0], points[points.len() - 1]);
    let x = x.clamp(first.0, last.0);
    let pair = points.windows(2).find(|pair| x <= pair[1].0);
    pair.map_or(last.1, |pair| {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    })
}

fn mean(colors: &[Vector3]) -> Vector3 {
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
    fn halves_and_quarters_of_a_sequence_are_compared() {
        let spread = SetKind::Sobol(8).spread(&gray([0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0]));
        assert!((spread.fine[1] - 0.25).abs() < 1e-7, "{spread:?}");
        assert!((spread.coarse[1] - 2.0 / 12.0).abs() < 1e-7, "{spread:?}");
    }

    #[test]
    fn smooth_colours_and_noise_have_the_exact_factors_of_a_grid() {
        // Four by four cells. A slope: cells differ along x only, by 1, and each has the variance of a uniform number.
        let kind = SetKind::new(SamplerKind::Stratified, 16, 4);
        assert_eq!(kind, SetKind::Grid(4));
        // The PCG hash (Jarzynski and Olano, Hash Functions for GPU Rendering, JCGT 9(3), 2020).
        let random = |n: u32| {
            let state = n.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
            f64::from((word >> 22) ^ word) / 2.0f64.powi(32)
        };
        let (mut fine, mut coarse, mut noise_fine, mut noise_coarse) = (0.0, 0.0, 0.0, 0.0);
        for set in 0..4000 {
            let slope = kind.spread(&gray((0..16).map(|i| f64::from(i % 4) + random(16 * set + i))));
            let noise = kind.spread(&gray((0..16).map(|i| random(7 + 16 * set + i))));
            (fine, coarse) = (fine + slope.fine[0], coarse + slope.coarse[0]);
            (noise_fine, noise_coarse) = (noise_fine + noise.fine[0], noise_coarse + noise.coarse[0]);
        }
        let expected = 4000.0 / 12.0 / 16.0;
        for (fine, coarse) in [(fine, coarse), (noise_fine, noise_coarse)] {
            let estimate = fine * kind.factor(coarse / fine);
            assert!((estimate / expected - 1.0).abs() < 0.2, "{estimate} {expected} {}", coarse / fine);
        }
    }

    #[test]
    fn odd_rows_are_compared_in_pairs() {
        let kind = SetKind::new(SamplerKind::Stratified, 2, 2);
        assert_eq!(kind, SetKind::Rows(2, 2));
        assert!((kind.spread(&gray([0.0, 1.0])).fine[0] - 0.25).abs() < 1e-7);
        assert_eq!(SetKind::new(SamplerKind::Stratified, 9, 3), SetKind::Rows(9, 3));
    }
}
