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
//! The interval: the sum of v and the sum of squared errors differ by a sum of independent terms, one a pixel: products
//! of the errors of different sets, with mean 0 and variance 2 V^2 R / (R - 1), V being the true variance of the colour
//! (for R = 2 the term is -(a b) with a and b the errors of the halves: 4 V^2). V^2 is not known, but v^2 is
//! V^2 (1 + (k - 3) / R + 2 / (R - 1)) in the mean, where k is the kurtosis of a set's mean: 3 for a normal
//! distribution, 1 at least. We take 2, as edges make it, and err on the side of a wide interval where errors are rare
//! and large. With two halves the two sums can change places (exchange b and -b), so their ratio is as likely to be
//! some factor too large as too small: the interval is symmetric on a logarithmic scale.

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
    /// Of the variance of the difference from the true squared error.
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
fn spread(sets: f64) -> f64 {
    const KURTOSIS: f64 = 2.0;
    2.0 * sets / (sets - 1.0) / (1.0 + (KURTOSIS - 3.0) / sets + 2.0 / (sets - 1.0))
}

impl ErrorSums {
    /// Adds a pixel whose sets' means differ by `deviations` (per channel, the sum of squares of their differences from
    /// `mean`), and returns its standard error in levels.
    pub fn add(&mut self, mean: Vector3, deviations: [f64; 3], sets: u32) -> f64 {
        let sets = f64::from(sets);
        let linear = deviations.map(|sum| sum / (sets * (sets - 1.0)));
        let mean = mean.to_array().map(|c| c as f64);
        let levels = [0, 1, 2].map(|c| clamped_variance(mean[c], linear[c]));
        let spread = spread(sets);
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

    /// Returns the sum of parts, in their order, for sums depend on it.
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

/// Returns the mean square of what is left of an error of +-sqrt(`variance`) after the true and the shown value are clamped.
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
        let ratios = [estimate.levels.high / estimate.levels.rmse, estimate.levels.rmse / estimate.levels.low];
        assert!(ratios[0] > 1.0 && (ratios[0] / ratios[1] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn no_pixels_no_estimate() {
        assert_eq!(ErrorSums::default().estimate(), None);
    }
}
