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
                let (first, second) = colors.split_at(colors.len().div_ceil(2));
                let fine = square(mean(first) - mean(second)).map(|square| square / 4.0);
                Spread { fine, coarse: of_pairs(colors, colors.len()) }
            }
            Self::Grid(columns) => of_blocks(colors, columns as usize),
            Self::Rows(_, columns) => {
                let fine = of_pairs(colors, columns.max(2) as usize);
                Spread { fine, coarse: fine }
            }
        }
    }

    /// Returns the squared error of the mean as a multiple of the fine spread, for a whole picture in which the coarse one
    /// is `ratio` times the fine one.
    ///
    /// Where a power law does not hold yet, or only in part, the numbers are measured on the seven scenes of `data/`. See
    /// docs/error-estimate.md.
    pub fn factor(self, ratio: f64) -> f64 {
        match self {
            Self::Independent | Self::Sequences => 1.0,
            Self::Sobol(samples) if samples < 4 => Self::usual_factor(samples),
            Self::Sobol(samples) => {
                // Details that are not resolved, whose samples are as if independent, have the factor 1.
                let resolved = ((ratio - 0.95) / 0.25).clamp(0.0, 1.0);
                let divisor = 1.0 + resolved * (1.0 / Self::usual_factor(samples) - 1.0);
                let has_power_law = samples >= 32 && samples.is_power_of_two();
                1.0 / divisor.max(if has_power_law { divisor_by_power_law(samples, ratio) } else { 1.0 })
            }
            // Noise, details as small as the cells, edges at all angles, and a slope, where it is exact again.
            Self::Grid(_) => {
                interpolated(&[(1.0, 1.0), (1.2, 0.725), (1.6, 0.83), (2.2, 0.75), (5.0, 1.0)], ratio)
            }
            Self::Rows(2, _) => 1.0 / 1.55,
            Self::Rows(..) => 1.0 / 2.1,
        }
    }

    /// Returns the least factor that is likely for a picture with such a ratio: of Sobol samples it is the one for
    /// details that are resolved. Pictures of the same ratio differ in how many have just been resolved.
    pub fn least_factor(self, ratio: f64) -> f64 {
        match self {
            Self::Sobol(samples) => self.factor(ratio).min(Self::usual_factor(samples)),
            _ => self.factor(ratio),
        }
    }

    /// Returns the factor of Sobol samples if nothing is known but their number.
    pub fn usual_factor(samples: u32) -> f64 {
        let is_even = samples.is_multiple_of(2);
        match samples {
            ..16 if !is_even => 1.0 / 1.8,
            4 => 1.0 / 2.2,
            8 => 1.0 / 2.0,
            ..16 => 1.0 / 2.6,
            _ if is_even && !samples.is_power_of_two() => 1.0 / 2.2,
            _ => 1.0 / 1.9,
        }
    }

    /// Returns how far [`factor`](Self::factor) may be off: standard deviations of its logarithm, from scene to scene,
    /// where it is too large and where it is too small. It is too large where details are as small as the distance of
    /// two samples: then the error falls faster than before.
    pub fn factor_deviations(self) -> [f64; 2] {
        match self {
            Self::Independent => [0.0, 0.0],
            Self::Sobol(_) | Self::Sequences | Self::Grid(4..) => [0.33, 0.22],
            Self::Grid(_) | Self::Rows(..) => [0.45, 0.35],
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

/// Returns the fine spread of Sobol samples, divided by the squared error, if the error falls by one power of their number:
/// 2^a - 1, from independent samples (a = 1) to smooth colours (a = 3), with the bend that the curve has at edges.
fn divisor_by_power_law(samples: u32, ratio: f64) -> f64 {
    let doublings = f64::from(samples.ilog2()) - 1.0;
    let by_power_law = (2.0 * ratio.powf(1.0 / doublings) - 1.0).clamp(1.0, 7.0);
    1.0 + 0.72 * (by_power_law - 1.0)
}

/// Returns S(G) of the means of G groups.
fn between(means: impl Iterator<Item = Vector3> + Clone, count: usize) -> [f64; 3] {
    let count = count as f64;
    let mean = means.clone().fold(Vector3::ZERO, |sum, mean| sum + mean) * (1.0 / count as Real);
    let squares = means.map(|group| square(group - mean)).fold([0.0; 3], add);
    squares.map(|sum| sum / (count * (count - 1.0)))
}

/// Returns the spread within pairs of neighbours in rows of so many colours.
fn of_pairs(colors: &[Vector3], columns: usize) -> [f64; 3] {
    let rows = colors.chunks(columns);
    let pairs = rows.flat_map(|row| row.chunks_exact(2)).map(|pair| square(pair[0] - pair[1]));
    let (sum, count) = pairs.fold(([0.0; 3], 0.0), |(sum, count), pair| (add(sum, pair), count + 1.0));
    sum.map(|sum| sum / (2.0 * count * colors.len() as f64))
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
    use super::super::samples::mixed;
    use super::super::sobol::Sobol;
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

    /// At edges the error of 64 samples is stated to a fifth, and where all is noise, too.
    #[test]
    fn the_power_law_of_a_sequence_holds_at_edges_and_in_noise() {
        const SETS: u64 = 4000;
        let kind = SetKind::Sobol(64);
        let random = |n: u64| mixed(n) as f64 / 2.0f64.powi(64);
        let edge = |set: u64, x: f64, y: f64| {
            // The line is a random one through the pixel's middle, whose half is 1.
            let angle = std::f64::consts::TAU * random(7 * set);
            f64::from((x - 0.5) * angle.cos() + (y - 0.5) * angle.sin() > 0.0)
        };
        let noise = |_: u64, x: f64, y: f64| f64::from(mixed(x.to_bits() ^ mixed(y.to_bits())) >> 63 == 1);
        let integrands: [&dyn Fn(u64, f64, f64) -> f64; 2] = [&edge, &noise];
        for value in integrands {
            let (mut fine, mut coarse, mut error) = (0.0, 0.0, 0.0);
            for set in 0..SETS {
                let sobol = Sobol::new([mixed(2 * set + 1), mixed(2 * set + 2)]);
                let places = (0..64).map(|index| sobol.sample(index));
                let colors = gray(places.map(|(x, y)| value(set, x as f64, y as f64)));
                let spread = kind.spread(&colors);
                (fine, coarse) = (fine + spread.fine[0], coarse + spread.coarse[0]);
                error += (mean(&colors).x as f64 - 0.5).powi(2);
            }
            let stated = fine * kind.factor(coarse / fine);
            assert!((stated / error - 1.0).abs() < 0.2, "{} {}", stated / error, coarse / fine);
        }
    }

    /// Discs of 0.18 pixels: 4 samples do not resolve them, 16 in part, and 64 do.
    #[test]
    fn details_that_have_just_been_resolved_are_told_from_noise() {
        const SETS: u64 = 8000;
        const RADIUS: f64 = 0.09;
        let random = |n: u64| mixed(n) as f64 / 2.0f64.powi(64);
        let disc = |set: u64, (x, y): (f64, f64)| {
            let [middle_x, middle_y] = [5, 6].map(|n| 0.1 + 0.8 * random(7 * set + n));
            f64::from((x - middle_x).hypot(y - middle_y) < RADIUS)
        };
        let in_cell = |set: u64, cell: u64| {
            let [x, y] = [0, 1].map(|n| random((1 << 40) | (128 * set + 2 * cell + n)));
            (((cell % 8) as f64 + x) / 8.0, ((cell / 8) as f64 + y) / 8.0)
        };
        for kind in [SetKind::Sobol(4), SetKind::Sobol(16), SetKind::Sobol(64), SetKind::Grid(8)] {
            let (mut fine, mut coarse, mut error) = (0.0, 0.0, 0.0);
            for set in 0..SETS {
                let sobol = Sobol::new([mixed(2 * set + 1), mixed(2 * set + 2)]);
                let of_sequence = |(x, y): (Real, Real)| disc(set, (x as f64, y as f64));
                let colors = match kind {
                    SetKind::Sobol(count) => gray((0..count).map(|index| of_sequence(sobol.sample(index)))),
                    _ => gray((0..64).map(|cell| disc(set, in_cell(set, cell)))),
                };
                let spread = kind.spread(&colors);
                (fine, coarse) = (fine + spread.fine[0], coarse + spread.coarse[0]);
                error += (mean(&colors).x as f64 - std::f64::consts::PI * RADIUS * RADIUS).powi(2);
            }
            let ratio = coarse / fine;
            let [stated, least] =
                [kind.factor(ratio), kind.least_factor(ratio)].map(|factor| factor * fine / error);
            assert!((0.8..1.2).contains(&stated) && least <= stated, "{kind:?}: {stated} {least} {ratio}");
        }
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
