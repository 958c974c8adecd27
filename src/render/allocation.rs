//! [`Allocation`]: how many samples each pixel needs for the whole picture to reach a target error.
//!
//! In: the variance within each pixel, estimated from a few *pilot* samples. Out: a number of samples for each pixel,
//! most where they help most. The pilot samples are not used for anything else. If they were part of the picture, or
//! if each pixel's own samples decided when it stops, a pixel whose first samples happen to agree would keep only
//! these, and the picture would be biased (Kirk and Arvo, Unbiased Sampling Techniques for Image Synthesis, SIGGRAPH
//! 1991).
//!
//! The model: with n samples in each of two halves the squared error of a pixel is s^2 / (2 n^b), where s^2 is the
//! pixel's variance and b the sampler's [`convergence_order`](crate::options::SamplerKind::convergence_order). For a
//! given number of samples, the sum over all pixels is smallest if n is proportional to (s^2)^(1/(1 + b)).

use rayon::prelude::*;

/// Number of pilot samples a pixel.
pub const PILOT_SAMPLES: u32 = 4;
/// Largest number of samples in each half of a pixel: all samples of a pixel are in memory at the same time.
const MAX_SAMPLES_A_HALF: u32 = 1 << 15;

/// Least variance of a sample, in squared byte levels. Pixels where the pilot has seen no variance get at least this,
/// so that details it has missed are found at last.
const LEAST_VARIANCE: f32 = 1.0;

/// Weights are rounded to this many steps a doubling, so that sums over all pixels become sums over a few steps.
const STEPS: f64 = 16.0;

/// The model of the error, and the number of samples of each pixel.
#[derive(Debug)]
pub struct Allocation {
    /// For each pixel the logarithm of its weight (s^2)^(1/(1 + b)), s in levels, in steps.
    steps: Vec<u8>,
    /// The sum of s^2 over the pixels of each step.
    variances: Vec<f64>,
    order: f64,
    /// Number of samples in each half of a pixel, divided by the pixel's weight.
    scale: f64,
    /// The measured error divided by the error of the model.
    calibration: f64,
}

/// Returns the weight of a step.
fn weight(step: usize) -> f64 {
    (step as f64 / STEPS).exp2()
}

impl Allocation {
    /// Makes an allocation from the variance of a sample in each pixel, in squared levels, rows of `width`. `order`
    /// is the convergence order.
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

    /// Returns the number of samples in each half of a pixel.
    pub fn goal(&self, pixel: usize) -> u32 {
        goal(weight(usize::from(self.steps[pixel])) * self.scale)
    }

    /// Returns the mean squared error of the model at a scale, in squared levels.
    fn expected(&self, scale: f64) -> f64 {
        let error = |(step, variance): (usize, &f64)| {
            variance / (2.0 * f64::from(goal(weight(step) * scale)).powf(self.order))
        };
        self.variances.iter().enumerate().map(error).sum::<f64>() / self.steps.len() as f64
    }

    /// Sets the calibration so that the model gives the measured mean squared error, in squared levels.
    pub fn calibrate(&mut self, measured: f64) {
        let expected = self.expected(self.scale);
        if measured > 0.0 && expected > 0.0 {
            self.calibration = measured / expected;
        }
    }

    /// Raises the scale until the calibrated model gives a mean squared error below `aim`, in squared levels. Returns
    /// false if no pixel may get more samples.
    pub fn raise(&mut self, aim: f64) -> bool {
        let least = self.variances.iter().position(|&variance| variance > 0.0).unwrap_or(0);
        if weight(least) * self.scale >= f64::from(MAX_SAMPLES_A_HALF) {
            return false;
        }
        let old = self.scale;
        // At least a little more, so that every pass is worth its overhead. Not very much more, because the
        // calibration may still be wrong.
        let (mut low, mut high) = if old == 0.0 { (1e-6, 1e6) } else { (1.2 * old, 16.0 * old) };
        for _ in 0..40 {
            let middle = (low * high).sqrt();
            if self.calibration * self.expected(middle) > aim { low = middle } else { high = middle }
        }
        self.scale = high;
        true
    }
}

/// Rounds a number of samples up to 2^k or 1.5 * 2^k, which Sobol's sequence distributes evenly.
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

/// Averages variances over neighbouring pixels: an edge crosses many pixels, and four samples of one pixel often miss
/// it.
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
    fn goals_are_rounded_up() {
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
    fn calibration_with_a_larger_error_gives_more_samples() {
        let mut allocation = Allocation::new(&[100.0; 16], 4, 1.0);
        allocation.raise(4.0);
        let before = allocation.goal(0);
        allocation.calibrate(8.0 * allocation.expected(allocation.scale));
        allocation.raise(4.0);
        assert!(allocation.goal(0) >= 4 * before, "{} {before}", allocation.goal(0));
    }
}
