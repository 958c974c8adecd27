//! [`Allocation`]: how many samples each pixel needs for the whole picture to reach a target error.
//!
//! In: the variance within each pixel, as the *pilot* rays show it (see [`pilot`](super::pilot)). Out: a number of samples
//! for each pixel, most where they help most. The pilot rays are no part of the picture. If they were, or if each
//! pixel's own samples decided when it stops, a pixel whose first samples happen to agree would keep only these, and the
//! picture would be biased (Kirk and Arvo, Unbiased Sampling Techniques for Image Synthesis, SIGGRAPH 1991).
//!
//! The model: with n samples the squared error of a pixel is s^2 / n^b, where s^2 is the pixel's variance and b the
//! sampler's [`convergence_order`](crate::options::SamplerKind::convergence_order). For a
//! given number of samples, the sum over all pixels is smallest if n is proportional to (s^2)^(1/(1 + b)). And every
//! pixel gets at least a *floor* of samples, so that nothing large is missed in any of them (see
//! [`Unseen`](super::error_estimate::Unseen)).

use super::error_estimate::{EXPECTED, Unseen};
use super::error_map::{of_neighbours, pooled};
use rayon::prelude::*;

/// Smallest number of samples of a pixel: its error is estimated from them.
const MIN_SAMPLES: u32 = 2;
/// Largest number of samples of a pixel: all of them are in memory at the same time.
const MAX_SAMPLES: u32 = 1 << 16;

/// Least variance of a sample, in squared byte levels: 2 to this power. Pixels where the pilot has seen no variance get
/// at least this, so that smooth shading has a say.
const LEAST_VARIANCE_LOG2: f32 = -6.0;

/// Weights are rounded to this many steps a doubling, so that sums over all pixels become sums over a few steps.
const STEPS: f64 = 16.0;

/// The model is trusted to at most so many times too large an error: else samples that agree by chance would outvote
/// the pilot rays.
const MOST_TOO_LARGE: f64 = 16.0;

/// The model of the error, and the number of samples of each pixel.
#[derive(Debug)]
pub struct Allocation {
    /// For each pixel the logarithm of its weight (s^2)^(1/(1 + b)), s^2 in multiples of the least, in steps.
    steps: Vec<u8>,
    /// For each step the number of its pixels, and the sum of their s^2.
    pixels: Vec<u64>,
    variances: Vec<f64>,
    order: f64,
    /// The variance of each pixel by the pilot.
    pilot: Vec<f32>,
    /// The measured error divided by the error of the model.
    calibration: f64,
    goals: Goals,
}

/// The number of samples of a pixel: its weight times the scale, and at least the floor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Goals {
    scale: f64,
    floor: u32,
}

impl Goals {
    fn of(self, step: usize) -> u32 {
        rounded(weight(step) * self.scale).max(self.floor)
    }
}

/// Returns the weight of a step.
fn weight(step: usize) -> f64 {
    (step as f64 / STEPS).exp2()
}

impl Allocation {
    /// Makes an allocation from the variance of a sample in each pixel, in squared levels, as the pilot saw it; rows of
    /// `width`. `order` is the convergence order.
    pub fn new(variances: &[f32], width: usize, order: f64) -> Self {
        let goals = Goals { scale: 0.0, floor: MIN_SAMPLES };
        let mut allocation = Self {
            steps: Vec::new(),
            pixels: Vec::new(),
            variances: Vec::new(),
            pilot: Vec::new(),
            order,
            calibration: 1.0,
            goals,
        };
        allocation.pilot = pooled(variances, width);
        allocation.set_variances(&allocation.pilot.clone());
        allocation
    }

    /// Takes the samples of each pixel's neighbours into account: `variances` of a sample by each pixel's own samples.
    /// A pixel's own samples have no say in how many more it gets.
    pub fn refine(&mut self, variances: &[f32], width: usize) {
        let calibration = self.calibration as f32;
        let both = of_neighbours(variances, width)
            .into_iter()
            .zip(&self.pilot)
            .map(|(samples, pilot)| (samples + calibration * pilot) / 2.0);
        self.set_variances(&both.collect::<Vec<_>>());
    }

    fn set_variances(&mut self, variances: &[f32]) {
        let order = self.order;
        let steps_a_doubling = (STEPS / (1.0 + order)) as f32;
        self.steps = variances
            .par_iter()
            .map(|variance| (steps_a_doubling * (variance.log2() - LEAST_VARIANCE_LOG2)).round() as u8)
            .collect();
        self.pixels = vec![0; 256];
        self.steps.iter().for_each(|&step| self.pixels[usize::from(step)] += 1);
        let variance = |(step, &pixels): (usize, &u64)| {
            pixels as f64 * (f64::from(LEAST_VARIANCE_LOG2)).exp2() * weight(step).powf(1.0 + order)
        };
        self.variances = self.pixels.iter().enumerate().map(variance).collect();
    }

    /// Returns the number of samples of a pixel.
    pub fn goal(&self, pixel: usize) -> u32 {
        self.goals.of(usize::from(self.steps[pixel]))
    }

    /// Returns the mean squared error of the model in squared levels, by the calibration so far.
    pub fn expected(&self) -> f64 {
        self.calibration * self.modelled(self.goals)
    }

    fn modelled(&self, goals: Goals) -> f64 {
        let error = |(step, variance): (usize, &f64)| variance / f64::from(goals.of(step)).powf(self.order);
        self.variances.iter().enumerate().map(error).sum::<f64>() / self.steps.len() as f64
    }

    /// Returns the sum of all goals.
    fn samples(&self, goals: Goals) -> f64 {
        let samples = |(step, &pixels): (usize, &u64)| pixels as f64 * f64::from(goals.of(step));
        self.pixels.iter().enumerate().map(samples).sum()
    }

    /// Sets the calibration so that the model gives the measured mean squared error, in squared levels.
    pub fn calibrate(&mut self, measured: f64) {
        let modelled = self.modelled(self.goals);
        if modelled > 0.0 {
            self.calibration = (measured / modelled).max(1.0 / MOST_TOO_LARGE);
        }
    }

    /// Raises the goals until the calibrated model gives a mean squared error of at most `margin` times what the
    /// unseen leaves of `aim`, in squared levels, with the fewest samples. Returns false if no pixel may get more.
    pub fn raise(&mut self, aim: f64, margin: f64, unseen: impl Fn(u32) -> Unseen) -> bool {
        let floors = (0..=16).map(|power| 1 << power);
        let floors = floors.filter(|floor| (self.goals.floor..=MAX_SAMPLES).contains(floor));
        let goals = floors.filter_map(|floor| {
            let rest = aim - 255.0 * 255.0 * EXPECTED * unseen(floor).mean_square(1.0);
            (rest > 0.0).then(|| self.goals_for(floor, margin * rest))
        });
        let best = goals.min_by(|a, b| self.samples(*a).total_cmp(&self.samples(*b)));
        let goals = best.unwrap_or(Goals { floor: MAX_SAMPLES, ..self.goals });
        let is_more = self.samples(goals) > self.samples(self.goals);
        self.goals = goals;
        is_more
    }

    /// Returns the smallest scale with this floor for which the model's error is at most `aim`.
    fn goals_for(&self, floor: u32, aim: f64) -> Goals {
        let old = self.goals.scale;
        // Not very much more at once, because the calibration may still be wrong.
        let (mut low, mut high) = if old == 0.0 { (1e-6, 1e6) } else { (old, 16.0 * old) };
        for _ in 0..40 {
            let middle = (low * high).sqrt();
            let goals = Goals { scale: middle, floor };
            if self.calibration * self.modelled(goals) > aim { low = middle } else { high = middle }
        }
        Goals { scale: high, floor }
    }
}

/// Rounds a number of samples to the nearest power of two, which Sobol's sequence distributes evenly.
fn rounded(wanted: f64) -> u32 {
    wanted.clamp(f64::from(MIN_SAMPLES), f64::from(MAX_SAMPLES)).log2().round().exp2() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing can be missed.
    fn nothing(samples: u32) -> Unseen {
        Unseen { samples, pixels: u64::MAX }
    }

    #[test]
    fn goals_are_rounded_to_the_nearest_power_of_two() {
        for (wanted, expected) in [(0.0, 2), (1.0, 2), (2.5, 2), (3.0, 4), (5.6, 4), (5.7, 8), (1e9, 1 << 16)] {
            assert_eq!(rounded(wanted), expected, "{wanted}");
        }
    }

    #[test]
    fn noisy_pixels_get_most_and_their_neighbours_some() {
        let mut variances = vec![0.0; 49];
        variances[24] = 10_000.0;
        let mut allocation = Allocation::new(&variances, 7, 1.5);
        assert!(allocation.raise(1.0, 1.0, nothing));
        assert!(allocation.expected() <= 1.0);
        assert!(allocation.goal(24) > allocation.goal(25));
        assert!(allocation.goal(25) > allocation.goal(0));
        assert_eq!(allocation.goal(0), allocation.goal(48));
    }

    #[test]
    fn calibration_with_a_larger_error_gives_more_samples() {
        let mut allocation = Allocation::new(&[100.0; 16], 4, 1.0);
        allocation.raise(4.0, 1.0, nothing);
        let before = allocation.goal(0);
        allocation.calibrate(8.0 * allocation.modelled(allocation.goals));
        allocation.raise(4.0, 1.0, nothing);
        assert!(allocation.goal(0) >= 4 * before, "{} {before}", allocation.goal(0));
    }

    #[test]
    fn every_pixel_gets_so_many_samples_that_nothing_large_is_missed() {
        // A sixth of 3 * 255^2 / (n^2 * 1024) is below 0.25 from 12 samples on.
        let mut allocation = Allocation::new(&[0.0; 1024], 32, 1.5);
        let unseen = |floor| Unseen { samples: floor, pixels: 1024 };
        assert!(allocation.raise(0.25, 1.0, unseen));
        assert_eq!(allocation.goal(0), 16);
        assert!(!allocation.raise(0.25, 1.0, unseen), "nothing more is needed");
    }
}
