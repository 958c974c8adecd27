//! What the spread of samples must be multiplied by to be the squared error of their mean.

use super::spread::SetKind;
use super::stratified::Cells;

impl SetKind {
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
            Self::Rows(Cells { count: 2, .. }) => 1.0 / 1.55,
            Self::Rows(_) => 1.0 / 1.9,
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
            Self::Grid(_) | Self::Rows(_) => [0.45, 0.35],
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
            Self::Grid(_) | Self::Rows(_) => 2.0,
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

#[cfg(test)]
mod tests {
    use super::super::samples::mixed;
    use super::super::sobol::Sobol;
    use super::super::spread::mean;
    use super::*;
    use crate::options::SamplerKind;
    use vecmath::{Real, Vector3};

    fn gray(values: impl IntoIterator<Item = f64>) -> Vec<Vector3> {
        values.into_iter().map(|value| Vector3::splat(value as Real)).collect()
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
        let kind = SetKind::new(SamplerKind::Stratified, 16);
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
}
