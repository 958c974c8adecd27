//! [`ErrorEstimate`]: the error of a sampled picture, estimated from its own samples.
//!
//! A pixel's samples are R independent sets, and its colour is the mean of the sets' means. The differences of these
//! means give the variance of the colour, for any sampler within a set:
//!
//! v = sum of (mean of set r - mean)^2 over r / (R (R - 1))
//!
//! This estimate is unbiased. (The usual formula over all samples of a set would be far too large for stratified and
//! Sobol samples.) For the independent sampler each sample is a set; the other samplers have two halves.
//!
//! The estimate is about the error of this one picture, not about the average of many: the root of the mean of
//! (colour - expected colour)^2 over all pixels and channels. *Linear* values are colours as traced, neither clamped
//! nor rounded. *Levels* are colours clamped to \[0, 1\] and multiplied by 255, but not truncated to whole numbers.
//!
//! The interval: the sum of v and the sum of squared errors differ by a sum of independent terms, one a pixel. The
//! terms are products of the errors of different sets. They have mean 0 and variance 2 V^2 R / (R - 1), where V is
//! the true variance of the colour. (For R = 2 the term is -(a b) with a and b the errors of the halves: 4 V^2.) V^2
//! is not known, but the mean of v^2 is V^2 (1 + (k - 3) / R + 2 / (R - 1)), where k is the kurtosis of a set's mean:
//! 3 for a normal distribution, at least 1. We take 2, which is typical of edges; where errors are rare and large,
//! the interval becomes too wide rather than too narrow. With two halves the two sums can change places (exchange b
//! and -b), so their ratio is as likely to be too large by some factor as too small: the interval is symmetric on a
//! logarithmic scale.

use vecmath::Vector3;

/// An estimated root mean square error, and the interval that contains the true one with 95% probability.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Interval {
    pub rmse: f64,
    pub low: f64,
    pub high: f64,
}

/// The estimated error of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorEstimate {
    /// Of colours as traced.
    pub linear: Interval,
    /// Of colours clamped to \[0, 1\], times 255.
    pub levels: Interval,
}

/// Sums over pixels, from which the error is estimated.
#[derive(Clone, Copy, Debug, Default)]
pub struct ErrorSums {
    pixels: u64,
    linear: Sums,
    levels: Sums,
}

#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// Sum of v, averaged over the channels.
    variances: f64,
    /// Sum of the variances of the difference between v and the true squared error.
    squares: f64,
}

impl Sums {
    fn add(&mut self, variances: [f64; 3], relative_variance: f64) {
        let variance = variances.iter().sum::<f64>() / 3.0;
        self.variances += variance;
        self.squares += relative_variance * variance * variance;
    }

    fn merge(&mut self, other: &Self) {
        self.variances += other.variances;
        self.squares += other.squares;
    }

    fn interval(&self, pixels: f64, unit: f64) -> Interval {
        /// Number of standard deviations within which 95% of a normal distribution lie.
        const TWO_SIDED: f64 = 1.959_964;
        if self.variances <= 0.0 {
            return Interval::default();
        }
        let relative = self.squares / self.variances.powi(2);
        // The logarithm of a ratio of two sums of n squares has the variance 4/n (1 + 1/n).
        let half_width = TWO_SIDED * (relative * (1.0 + relative / 4.0)).sqrt();
        let rmse = unit * (self.variances / pixels).sqrt();
        let factor = (half_width / 2.0).exp();
        Interval { rmse, low: rmse / factor, high: rmse * factor }
    }
}

/// Returns the variance of the difference between v and the squared error, as a multiple of v^2.
fn relative_variance(sets: f64) -> f64 {
    const KURTOSIS: f64 = 2.0;
    2.0 * sets / (sets - 1.0) / (1.0 + (KURTOSIS - 3.0) / sets + 2.0 / (sets - 1.0))
}

impl ErrorSums {
    /// Adds a pixel, and returns its standard error in levels. `deviations` is for each channel the sum of squared
    /// differences of the sets' means from `mean`.
    pub fn add(&mut self, mean: Vector3, deviations: [f64; 3], sets: u32) -> f64 {
        let sets = f64::from(sets);
        let linear = deviations.map(|sum| sum / (sets * (sets - 1.0)));
        let mean = mean.to_array().map(|c| c as f64);
        let levels = [0, 1, 2].map(|c| clamped_variance(mean[c], linear[c]));
        let relative_variance = relative_variance(sets);
        self.pixels += 1;
        self.linear.add(linear, relative_variance);
        self.levels.add(levels, relative_variance);
        255.0 * (levels.iter().sum::<f64>() / 3.0).sqrt()
    }

    /// Adds a pixel of two halves, and returns its standard error in levels.
    pub fn add_halves(&mut self, halves: [Vector3; 2]) -> f64 {
        let mean = (halves[0] + halves[1]) * 0.5;
        let half_difference = (halves[0] - halves[1]) * 0.5;
        let deviations = half_difference.to_array().map(|d| 2.0 * (d as f64).powi(2));
        self.add(mean, deviations, 2)
    }

    /// Adds parts up in their order, because rounding depends on the order.
    pub fn total(parts: &[Self]) -> Self {
        let mut total = Self::default();
        parts.iter().for_each(|part| total.merge(part));
        total
    }

    fn merge(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.linear.merge(&other.linear);
        self.levels.merge(&other.levels);
    }

    /// Returns the estimate; `None` without pixels.
    pub fn estimate(&self) -> Option<ErrorEstimate> {
        let pixels = self.pixels as f64;
        (self.pixels > 0).then(|| ErrorEstimate {
            linear: self.linear.interval(pixels, 1.0),
            levels: self.levels.interval(pixels, 255.0),
        })
    }
}

/// Returns the mean squared error that remains of an error of +-sqrt(`variance`) after both values are clamped.
fn clamped_variance(mean: f64, variance: f64) -> f64 {
    let error = variance.sqrt();
    let shown = mean.clamp(0.0, 1.0);
    if error <= mean.min(1.0 - mean) {
        return variance;
    }
    let square = |other: f64| (other.clamp(0.0, 1.0) - shown).powi(2);
    (square(mean + error) + square(mean - error)) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_outside_the_clamped_range_do_not_count() {
        assert_eq!(clamped_variance(0.5, 0.01), 0.01);
        assert_eq!(clamped_variance(3.0, 1.0), 0.0);
        assert_eq!(clamped_variance(-1.0, 0.25), 0.0);
        // At the edge, only one side of the error is left.
        assert!((clamped_variance(1.0, 0.01) - 0.005).abs() < 1e-15);
    }

    #[test]
    fn halves_and_sets_agree() {
        let halves = [Vector3::new(0.2, 0.4, 0.6), Vector3::new(0.4, 0.4, 0.5)];
        let mut sums = ErrorSums::default();
        let levels = sums.add_halves(halves);
        let expected = ((0.1f64.powi(2) + 0.05f64.powi(2)) / 3.0).sqrt();
        let estimate = sums.estimate().unwrap();
        assert!((estimate.linear.rmse - expected).abs() < 1e-6);
        assert!((estimate.levels.rmse - 255.0 * expected).abs() < 1e-4);
        assert!((levels - 255.0 * expected).abs() < 1e-4);
        let ratios = [estimate.levels.high / estimate.levels.rmse, estimate.levels.rmse / estimate.levels.low];
        assert!(ratios[0] > 1.0 && (ratios[0] / ratios[1] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn no_pixels_no_estimate() {
        assert_eq!(ErrorSums::default().estimate(), None);
    }
}
