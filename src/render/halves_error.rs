//! [`HalvesError`]: what two halves of a pixel's samples say of the error of their mean.

use vecmath::Vector3;

/// Pixels whose halves are compared together.
const AT_ONCE: usize = 8;

/// What two halves say of the error of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HalvesError {
    /// Root of the mean squared error of the colour as traced, over the channels. A square may be beyond an `f32`.
    linear: f32,
    /// Mean squared error in squared levels.
    pub squared_levels: f32,
}

impl HalvesError {
    /// Compares the means of two halves, whose squared difference is `factor` times four times the squared error.
    #[inline]
    pub fn new(a: Vector3, b: Vector3, factor: f64) -> Self {
        let [mut linear, mut levels] = [0.0; 2];
        for (a, b) in [(a.x, b.x), (a.y, b.y), (a.z, b.z)] {
            let (mean, variance) = mean_and_variance(a as f64, b as f64, factor);
            linear += variance;
            levels += clamped_variance(mean, variance);
        }
        Self::of_sums(linear, levels)
    }

    /// Makes it of sums over the channels; a level is a 255th.
    #[inline(always)]
    fn of_sums(linear: f64, levels: f64) -> Self {
        Self { linear: (linear / 3.0).sqrt() as f32, squared_levels: (255.0 * 255.0 / 3.0 * levels) as f32 }
    }

    /// Compares the halves of each pixel, given their sum and the second half. To the same bits as [`new`](Self::new), in a
    /// third of the instructions. Call it inside `vectorize`.
    #[inline(always)]
    pub fn write_each(errors: &mut [Self], sums: &[Vector3], seconds: &[Vector3], factor: f64) {
        let halves = sums.chunks(AT_ONCE).zip(seconds.chunks(AT_ONCE));
        for (errors, (sums, seconds)) in errors.chunks_mut(AT_ONCE).zip(halves) {
            let halves = [0, 1, 2].map(|axis| {
                let mut halves = [[0.0; AT_ONCE]; 2];
                for (lane, (sum, second)) in sums.iter().zip(seconds).enumerate() {
                    (halves[0][lane], halves[1][lane]) = ((sum[axis] - second[axis]) as f64, second[axis] as f64);
                }
                halves
            });
            let mut variances = [0.0; AT_ONCE];
            // Numbers as large as the variances, so that both are in lanes of one size.
            let mut clamped = [0.0; AT_ONCE];
            for [a, b] in halves {
                for lane in 0..AT_ONCE {
                    let (mean, variance) = mean_and_variance(a[lane], b[lane], factor);
                    variances[lane] += variance;
                    clamped[lane] += if is_within(mean, variance) { 0.0 } else { 1.0 };
                }
            }
            for (lane, error) in errors.iter_mut().enumerate() {
                *error = match clamped[lane] == 0.0 {
                    true => Self::of_sums(variances[lane], variances[lane]),
                    false => Self::new(sums[lane] - seconds[lane], seconds[lane], factor),
                };
            }
        }
    }

    /// Returns the mean squared error of the colour as traced.
    #[inline]
    pub fn squared_linear(&self) -> f64 {
        f64::from(self.linear).powi(2)
    }
}

#[inline(always)]
fn mean_and_variance(a: f64, b: f64, factor: f64) -> (f64, f64) {
    (0.5 * (a + b), (0.5 * (a - b)).powi(2) * factor)
}

/// Returns whether no value with an error of +-sqrt(`variance`) is clamped.
#[inline(always)]
fn is_within(mean: f64, variance: f64) -> bool {
    let room = if mean < 1.0 - mean { mean } else { 1.0 - mean };
    room >= 0.0 && variance <= room * room
}

/// Returns the mean squared error that remains of an error of +-sqrt(`variance`) after both values are clamped.
#[inline]
pub fn clamped_variance(mean: f64, variance: f64) -> f64 {
    if is_within(mean, variance) {
        return variance;
    }
    let (error, shown) = (variance.sqrt(), mean.clamp(0.0, 1.0));
    let square = |other: f64| (other.clamp(0.0, 1.0) - shown).powi(2);
    (square(mean + error) + square(mean - error)) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{InstructionSet, Simd, vectorize, with_simd};

    #[test]
    fn errors_outside_the_clamped_range_do_not_count() {
        assert_eq!(clamped_variance(0.5, 0.01), 0.01);
        assert_eq!(clamped_variance(3.0, 1.0), 0.0);
        assert_eq!(clamped_variance(-1.0, 0.25), 0.0);
        // At the edge, only one side of the error is left.
        assert!((clamped_variance(1.0, 0.01) - 0.005).abs() < 1e-15);
    }

    #[test]
    fn many_halves_are_compared_like_each_with_every_instruction_set() {
        let large = f64::from(f32::MAX);
        let numbers = [0.0, 0.2, 0.5, 0.99, 1.0, -3.0, 30.0, large, -large, f64::INFINITY, f64::NAN];
        let grays = numbers.map(|value| Vector3::splat(value as vecmath::Real));
        let colors = [Vector3::new(0.1, 0.9, 0.4), Vector3::new(0.3, 0.9, 2.0)];
        let all: Vec<_> = grays.into_iter().chain(colors).collect();
        let pairs: Vec<_> = all.iter().flat_map(|&a| all.iter().map(move |&b| (a + b, b))).collect();
        let (sums, seconds): (Vec<_>, Vec<_>) = pairs.iter().copied().unzip();
        let expected: Vec<_> = pairs.iter().map(|&(sum, b)| HalvesError::new(sum - b, b, 0.4)).collect();
        for simd in InstructionSet::available() {
            let mut written = vec![HalvesError::default(); pairs.len()];
            let (errors, sums, seconds) = (written.as_mut_slice(), sums.as_slice(), seconds.as_slice());
            with_simd!(simd, simd => vectorize!(simd, HalvesError::write_each(errors, sums, seconds, 0.4)));
            // Not by `==`, because some are not numbers.
            assert_eq!(format!("{written:?}"), format!("{expected:?}"), "{simd:?}");
        }
    }
}
