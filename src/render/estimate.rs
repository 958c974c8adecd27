//! How wrong a sampled picture is, from its own samples.
//!
//! A pixel's samples come in R sets that are independent of each other, and its colour is the mean of the sets' means.
//! How much those differ among themselves tells the variance of the colour, whatever the sampler does within a set:
//!
//! v = sum of (mean of set r - mean)^2 over r / (R (R - 1))
//!
//! is without bias. (The usual formula, taken over all samples of a set, would be far too large for stratified and
//! Sobol samples.) The independent sampler's sets are its samples; the others' are two halves.
//!
//! What is estimated is the error that this very picture has, not what its like have on average: the root of the mean
//! of (colour - expected colour)^2 over all pixels and channels. In *linear* values colours are as traced, neither
//! clamped nor rounded; in *levels* both colours are clamped to \[0, 1\] and multiplied by 255, but not truncated to
//! whole numbers.
//!
//! The interval: the difference between the sum of v and the sum of squared errors is a sum of independent terms with
//! mean 0, one a pixel, each with variance 2 V^2 R / (R - 1) for normally distributed means of true variance V
//! (for R = 2 the term is -(a b) with a and b the errors of the halves: 4 V^2). As v^2 is V^2 (R + 1) / (R - 1) in the
//! mean, each pixel adds v^2 2 R / (R + 1) to the variance of the difference. That errs on the side of a wide interval
//! where samples are mostly equal and rarely far off.

use vecmath::Vector3;

/// An estimated root mean square error, and where the true one lies with 95% probability.
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

/// Sums over pixels.
#[derive(Clone, Copy, Debug, Default)]
pub struct ErrorSums {
    pixels: u64,
    linear: Sums,
    levels: Sums,
}

#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// Of the mean of v over the channels.
    variances: f64,
    /// Of that squared, times 2 R / (R + 1).
    squares: f64,
}

impl Sums {
    fn add(&mut self, variances: [f64; 3], spread: f64) {
        let variance = variances.iter().sum::<f64>() / 3.0;
        self.variances += variance;
        self.squares += spread * variance * variance;
    }

    fn merge(&mut self, other: &Self) {
        self.variances += other.variances;
        self.squares += other.squares;
    }

    fn interval(&self, pixels: f64, unit: f64) -> Interval {
        /// 95% of a normal distribution lie within so many standard deviations.
        const TWO_SIDED: f64 = 1.959_964;
        let half_width = TWO_SIDED * self.squares.sqrt();
        let root = |sum: f64| unit * (sum.max(0.0) / pixels).sqrt();
        Interval {
            rmse: root(self.variances),
            low: root(self.variances - half_width),
            high: root(self.variances + half_width),
        }
    }
}

impl ErrorSums {
    /// Adds a pixel whose sets' means differ by `deviations` (per channel, the sum of squares of their differences from
    /// `mean`), and returns its standard error in levels.
    pub fn add(&mut self, mean: Vector3, deviations: [f64; 3], sets: u32) -> f64 {
        let sets = f64::from(sets);
        let linear = deviations.map(|sum| sum / (sets * (sets - 1.0)));
        let mean = mean.to_array().map(|c| c as f64);
        let levels = [0, 1, 2].map(|c| clamped_variance(mean[c], linear[c]));
        let spread = 2.0 * sets / (sets + 1.0);
        self.pixels += 1;
        self.linear.add(linear, spread);
        self.levels.add(levels, spread);
        255.0 * (levels.iter().sum::<f64>() / 3.0).sqrt()
    }

    /// [`add`](Self::add) for two sets.
    pub fn add_halves(&mut self, halves: [Vector3; 2]) -> f64 {
        let mean = (halves[0] + halves[1]) * 0.5;
        let half_difference = (halves[0] - halves[1]) * 0.5;
        let deviations = half_difference.to_array().map(|d| 2.0 * (d as f64).powi(2));
        self.add(mean, deviations, 2)
    }

    /// The sum of parts, in their order, for sums depend on it.
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

    /// `None` without pixels.
    pub fn estimate(&self) -> Option<ErrorEstimate> {
        let pixels = self.pixels as f64;
        (self.pixels > 0).then(|| ErrorEstimate {
            linear: self.linear.interval(pixels, 1.0),
            levels: self.levels.interval(pixels, 255.0),
        })
    }
}

/// The mean square of what is left of an error of +-sqrt(`variance`) after the true and the shown value are clamped.
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
    fn what_is_clamped_away_is_no_error() {
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
        assert_eq!(estimate.levels.low, 0.0);
        assert!(estimate.levels.high > estimate.levels.rmse);
    }

    #[test]
    fn no_pixels_no_estimate() {
        assert_eq!(ErrorSums::default().estimate(), None);
    }
}
