//! [`Unseen`]: what no sample of a picture has met.
//!
//! If samples agree, that is no proof: n samples in each of N pixels miss a detail that covers the share p of one pixel
//! with probability (1 - p)^n. By the *rule of three*, with 95% probability all that was missed covers no more than 3 / n of
//! a pixel in sum. If it differs by the whole range of levels, it adds at most 3 * 255^2 / (n^2 N) to the mean squared
//! error. Half a missed detail is expected where none was seen (Jeffreys' prior), a sixth of that.

/// What unseen details are expected to add, as a share of what they add at most with 95% probability: half a detail
/// where it may be three.
pub const EXPECTED: f64 = 1.0 / 6.0;

/// How much of a picture its samples can have missed.
#[derive(Clone, Copy, Debug)]
pub struct Unseen {
    /// The smallest number of samples of any pixel.
    pub samples: u32,
    pub pixels: u64,
}

impl Unseen {
    /// Returns the mean squared error that unseen details of a brightness may add to a picture, with 95% probability, as a
    /// share of white.
    ///
    /// A detail of brightness A that covers the share p of a pixel changes it by min(1, p A), since white is the most
    /// that a pixel shows. So the squared error for each share missed is at most A / n, once A is above n.
    pub fn mean_square(&self, brightness: f64) -> f64 {
        let in_a_sample = brightness / f64::from(self.samples.max(1));
        3.0 * in_a_sample * in_a_sample.min(1.0) / self.pixels.max(1) as f64
    }

    /// Returns the same for colours that are not clamped.
    pub fn linear_mean_square(&self, brightness: f64) -> f64 {
        3.0 * (brightness / f64::from(self.samples.max(1))).powi(2) / self.pixels.max(1) as f64
    }

    /// Returns the mean squared error that unseen details are expected to add, in squared levels.
    pub fn expected(&self) -> f64 {
        EXPECTED * 255.0 * 255.0 * self.mean_square(1.0)
    }
}
