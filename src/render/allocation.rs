//! How many samples each pixel needs for the whole picture to reach an error.
//!
//! In: the variance within each pixel, as a few *pilot* samples see it. Out: a number of samples for each pixel, most
//! where they help most. The pilot samples have no other use: were they part of the picture, or were the picture's own
//! samples to decide when to stop, a pixel whose first samples happen to agree would keep them, and the mean over many
//! runs would be wrong (Kirk and Arvo, Unbiased Sampling Techniques for Image Synthesis, SIGGRAPH 1991).
//!
//! The model: n samples in each of two halves leave a squared error of s^2 / (2 n^b), s^2 the pixel's variance and b
//! the sampler's [`convergence_order`](crate::options::SamplerKind::convergence_order). The sum of these over the pixels is smallest
//! for a given number of samples where n is proportional to (s^2)^(1/(1 + b)).

use rayon::prelude::*;

/// Pilot samples a pixel.
pub const PILOT_SAMPLES: u32 = 4;
/// No pixel gets more than this in each half: they are held in memory together.
const MAX_SAMPLES_A_HALF: u32 = 1 << 15;

/// Every pixel is taken to have at least this variance (in squared byte levels, of one sample), so that what the pilot
/// has missed is found when there is nothing else left to improve.
const LEAST_VARIANCE: f32 = 1.0;

/// Weights are rounded to so many steps a doubling, so that sums over all pixels are sums over a few steps.
const STEPS: f64 = 16.0;

/// What is known before sampling.
#[derive(Debug)]
pub struct Allocation {
    /// The weight (s^2)^(1/(1 + b)) of each pixel, s in levels, as its logarithm in steps.
    steps: Vec<u8>,
    /// The sum of s^2 over the pixels of each step.
    variances: Vec<f64>,
    order: f64,
    /// Samples in each half of a pixel are this times its weight.
    scale: f64,
    /// How many times larger the error has turned out to be than the model says.
    calibration: f64,
}

/// Returns the weight of a step.
fn weight(step: usize) -> f64 {
    (step as f64 / STEPS).exp2()
}

impl Allocation {
    /// `variances` are those of single samples in squared levels, one a pixel, rows of `width`.
    pub fn new(variances: &[f32], width: usize, order: f64) -> Self {
        let steps_a_doubling = (STEPS / (1.0 + order)) as f32;
        let steps: Vec<u8> = pooled(variances, width)
            .into_par_iter()
            .map(|variance| (steps_a_doubling * variance.max(LEAST_VARIANCE).log2()).round() as u8)
            .collect();
        let mut sums = vec![0.0; 256];
        steps.iter().for_each(|&step| sums[usize::from(step)] += weight(usize::from(step)).powf(1.0 + order));
        Self { steps, variances: sums, order, scale: 0.0, calibration: 1.0 }
    }

    /// Samples in each half of a pixel, at the present scale.
    pub fn goal(&self, pixel: usize) -> u32 {
        goal(weight(usize::from(self.steps[pixel])) * self.scale)
    }

    /// Returns the mean squared error in levels that the model expects with this scale.
    fn expected(&self, scale: f64) -> f64 {
        let error = |(step, variance): (usize, &f64)| {
            variance / (2.0 * f64::from(goal(weight(step) * scale)).powf(self.order))
        };
        self.variances.iter().enumerate().map(error).sum::<f64>() / self.steps.len() as f64
    }

    /// The mean squared error has turned out to be `measured` (squared levels).
    pub fn calibrate(&mut self, measured: f64) {
        let expected = self.expected(self.scale);
        if measured > 0.0 && expected > 0.0 {
            self.calibration = measured / expected;
        }
    }

    /// Raises the scale until the model, as calibrated, expects a mean squared error below `aim` (squared levels).
    /// False where no pixel may get more samples than it has.
    pub fn raise(&mut self, aim: f64) -> bool {
        let least = self.variances.iter().position(|&variance| variance > 0.0).unwrap_or(0);
        if weight(least) * self.scale >= f64::from(MAX_SAMPLES_A_HALF) {
            return false;
        }
        let old = self.scale;
        // At least a little more, so that every pass is worth its overhead, and at most as much more as what is known
        // about the error bears.
        let (mut low, mut high) = if old == 0.0 { (1e-6, 1e6) } else { (1.2 * old, 16.0 * old) };
        for _ in 0..40 {
            let middle = (low * high).sqrt();
            if self.calibration * self.expected(middle) > aim { low = middle } else { high = middle }
        }
        self.scale = high;
        true
    }
}

/// Returns a number of samples: rounded up to a power of two or one and a half of it, which Sobol's sequence spreads well.
fn goal(wanted: f64) -> u32 {
    if wanted <= 1.0 {
        return 1;
    }
    if wanted >= f64::from(MAX_SAMPLES_A_HALF) {
        return MAX_SAMPLES_A_HALF;
    }
    let wanted = wanted.ceil() as u32;
    let power = wanted.next_power_of_two();
    let between = power / 4 * 3;
    if wanted <= between { between } else { power }
}

/// Returns the variance of a pixel as its surroundings suggest it: edges run on from pixel to pixel, and four samples miss many.
fn pooled(variances: &[f32], width: usize) -> Vec<f32> {
    const OWN: f32 = 4.0;
    const BESIDE: f32 = 1.0;
    const DIAGONAL: f32 = 0.5;
    let height = variances.len() / width;
    let pixel = |index: usize| {
        let (x, row) = ((index % width) as isize, (index / width) as isize);
        let (mut sum, mut weights) = (0.0, 0.0);
        for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
            let (x, row) = (x + dx, row + dy);
            if x < 0 || row < 0 || x >= width as isize || row >= height as isize {
                continue;
            }
            let weight = [OWN, BESIDE, DIAGONAL][(dx.abs() + dy.abs()) as usize];
            sum += weight * variances[row as usize * width + x as usize];
            weights += weight;
        }
        sum / weights
    };
    (0..variances.len()).into_par_iter().map(pixel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_are_round_and_enough() {
        for (wanted, expected) in
            [(0.0, 1), (1.0, 1), (1.1, 2), (2.5, 3), (3.5, 4), (5.0, 6), (6.5, 8), (1e9, 1 << 15)]
        {
            assert_eq!(goal(wanted), expected, "{wanted}");
        }
    }

    #[test]
    fn noisy_pixels_get_most_and_their_neighbours_some() {
        let mut variances = vec![0.0; 49];
        variances[24] = 10_000.0;
        let mut allocation = Allocation::new(&variances, 7, 1.5);
        assert!(allocation.raise(1.0));
        assert!(allocation.expected(allocation.scale) <= 1.0);
        assert!(allocation.goal(24) > allocation.goal(25));
        assert!(allocation.goal(25) > allocation.goal(0));
        assert_eq!(allocation.goal(0), allocation.goal(48));
    }

    #[test]
    fn a_larger_error_than_expected_asks_for_more() {
        let mut allocation = Allocation::new(&[100.0; 16], 4, 1.0);
        allocation.raise(4.0);
        let before = allocation.goal(0);
        allocation.calibrate(8.0 * allocation.expected(allocation.scale));
        allocation.raise(4.0);
        assert!(allocation.goal(0) >= 4 * before, "{} {before}", allocation.goal(0));
    }
}
