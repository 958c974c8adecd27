//! [`ErrorEstimate`]: the error of a sampled picture, estimated from its own samples.
//!
//! The estimate is about the error of this one picture, not about the average of many: the root of the mean of
//! (colour - expected colour)^2 over all pixels and channels. *Linear* values are colours as traced, neither clamped
//! nor rounded. *Levels* are colours clamped to \[0, 1\] and multiplied by 255, but not truncated to whole numbers.
//!
//! What is estimated. For each pixel, v: the variance of its colour by the differences of its samples (see
//! [`spread`](super::spread)). The mean of v over all pixels is the estimate of the mean squared error.
//!
//! The interval. The sum of v and the sum of squared errors differ by a sum of independent terms, one a pixel. They have
//! mean 0, and a variance that is a known multiple of v^2: with R independent sets the terms are products of the errors
//! of different sets, with variance 2 V^2 R / (R - 1), where V is the true variance of the colour. V^2 is not known, but
//! the mean of v^2 is V^2 (1 + (k - 3) / R + 2 / (R - 1)), where k is the kurtosis of a set's mean: 3 for a normal
//! distribution, at least 1. We take 2, which is typical of edges. With two halves the two sums can change places, so
//! their ratio is as likely to be too large by some factor as too small: this part of the interval is symmetric on a
//! logarithmic scale. To it comes what is not known of the differences between samples and error
//! ([`SetKind::factor_deviations`](super::spread::SetKind::factor_deviations)).
//!
//! What no sample has met is no error that samples can show. It belongs into the upper end of the interval, and the
//! estimate is never less than what is expected of it (see [`unseen`](super::unseen)): no error is 0 unless nothing is
//! random.

use super::unseen::EXPECTED;

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
    /// What the differences of samples alone say, as RMSE in levels.
    pub seen: f64,
    /// What details between black and white that no sample has met may add at most with 95% probability, as RMSE in
    /// levels. The upper ends contain it, and what brighter details may add.
    pub unseen: f64,
}

impl ErrorEstimate {
    /// Returns the RMSE that a target error must hold, in levels: the estimate with what unseen details are expected to
    /// add.
    pub fn with_unseen(&self) -> f64 {
        (self.seen.powi(2) + self.expected_unseen()).sqrt()
    }

    /// Returns the mean squared error that unseen details are expected to add, in squared levels.
    pub fn expected_unseen(&self) -> f64 {
        EXPECTED * self.unseen.powi(2)
    }

    /// Returns the estimate of a picture of which `share` is estimated, and the rest shows something else, with an
    /// RMSE of about `rest` levels. Nothing is known of the rest but that it lies between black and white.
    #[must_use]
    pub fn with_rest(self, share: f64, rest: f64) -> Self {
        let mixed = |a: f64, b: f64| (share * a * a + (1.0 - share) * b * b).sqrt();
        let of = |interval: Interval, rest: f64, most: f64| Interval {
            rmse: mixed(interval.rmse, rest),
            low: mixed(interval.low, 0.0),
            high: mixed(interval.high, most),
        };
        Self {
            linear: of(self.linear, rest / 255.0, f64::INFINITY),
            levels: of(self.levels, rest, 255.0),
            seen: mixed(self.seen, rest),
            unseen: mixed(self.unseen, 255.0),
        }
    }
}
