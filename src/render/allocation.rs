//! [`Allocation`]: how many samples each pixel needs for the whole picture to reach a target error.
//!
//! In: the variance within each pixel, as the *pilot* rays (see [`pilot`](super::pilot)) or the samples of its neighbours
//! show it. Out: a number of samples for each pixel, most where they help most. The pilot rays are no part of the
//! picture. If they were, or if each pixel's own samples decided when it stops, a pixel whose first samples happen to
//! agree would keep only these, and the picture would be biased (Kirk and Arvo, Unbiased Sampling Techniques for Image
//! Synthesis, SIGGRAPH 1991).
//!
//! The model: with n samples the squared error of a pixel is s^2 / n^b, where s^2 is the pixel's variance and b the
//! sampler's [`convergence_order`](crate::options::SamplerKind::convergence_order). For a
//! given number of samples, the sum over all pixels is smallest if n is proportional to (s^2)^(1/(1 + b)). And every
//! pixel gets at least a *floor* of samples, so that nothing large is missed in any of them (see
//! [`Unseen`](super::unseen::Unseen)).

use super::error_map::{of_neighbours, pooled};
use super::tiles::Tile;
use super::unseen::Unseen;
use rayon::prelude::*;
use std::ops::RangeInclusive;

/// Smallest and largest number of samples of a pixel, as powers of two: two, because the error is estimated from them; and
/// not more than fit into memory at the same time.
const POWERS: RangeInclusive<i32> = 1..=16;

/// Least variance of a sample, in squared byte levels: 2 to this power. Pixels where the pilot has seen no variance get
/// at least this, so that smooth shading has a say.
const LEAST_VARIANCE_LOG2: f32 = -6.0;

/// Weights are rounded to this many steps a doubling, so that sums over all pixels become sums over a few steps.
const STEPS: i32 = 16;

/// The model is trusted to at most so many times too large an error: else samples that agree by chance would outvote
/// the pilot rays.
const MOST_TOO_LARGE: f64 = 16.0;

/// How many samples the pixels of a picture shall have.
pub enum Goal<'a> {
    /// Every pixel so many.
    Same(u32),
    Allocated(&'a Allocation),
}

impl Goal<'_> {
    /// Returns the number of samples of a pixel.
    pub fn of(&self, pixel: (u32, u32)) -> u32 {
        match self {
            Self::Same(samples) => *samples,
            Self::Allocated(allocation) => allocation.goal(allocation.part.index_of(pixel)),
        }
    }

    /// Returns the largest number of any pixel of a tile.
    pub fn most(&self, tile: &Tile) -> u32 {
        match self {
            Self::Same(samples) => *samples,
            Self::Allocated(allocation) => {
                let row = |row: u32| {
                    let first = allocation.part.index_of((tile.x, row));
                    allocation.steps[first..first + tile.width as usize].iter().max()
                };
                let most = (tile.row..tile.row + tile.height).filter_map(row).max();
                most.map_or(0, |&step| allocation.samples_of_step[usize::from(step)])
            }
        }
    }
}

/// The model of the error, and the number of samples of each pixel.
#[derive(Debug)]
pub struct Allocation {
    /// The part of the picture that is not exact.
    part: Tile,
    /// For each pixel the logarithm of its weight (s^2)^(1/(1 + b)), s^2 in multiples of the least, in steps.
    steps: Vec<u8>,
    /// The steps that pixels have.
    classes: Vec<Class>,
    order: f64,
    /// Pixels of the whole picture. All others are exact.
    pixels: f64,
    /// The variance of each pixel by the pilot; empty without one.
    pilot: Vec<f32>,
    /// The measured error divided by the error of the model.
    calibration: f64,
    goals: Goals,
    /// The number of samples of each step.
    samples_of_step: Vec<u32>,
}

/// The pixels with the same weight.
#[derive(Clone, Copy, Debug)]
struct Class {
    step: i32,
    pixels: f64,
    /// Sum of s^2.
    variance: f64,
}

/// The number of samples of a pixel, rounded to the nearest power of two, which Sobol's sequence distributes evenly: its
/// weight times the scale, and at least the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Goals {
    /// Logarithm of the scale, in steps.
    scale: i32,
    /// As a power of two.
    floor: i32,
}

impl Goals {
    /// Returns the number of samples of a step as a power of two.
    fn power(self, step: i32) -> i32 {
        let nearest = (step + self.scale + STEPS / 2).div_euclid(STEPS);
        nearest.clamp(self.floor, *POWERS.end())
    }
}

impl Allocation {
    /// Makes an allocation for a picture of so many pixels. `order` is the convergence order. What it is told of pixels,
    /// by [`set_pilot`](Self::set_pilot) or [`refine`](Self::refine), is of a part of them: all others are exact.
    pub fn new(pixels: u64, part: Tile, order: f64) -> Self {
        Self {
            part,
            steps: Vec::new(),
            classes: Vec::new(),
            order,
            pixels: pixels as f64,
            pilot: Vec::new(),
            calibration: 1.0,
            goals: Goals { scale: -256, floor: *POWERS.start() },
            samples_of_step: Vec::new(),
        }
    }

    /// Takes the variance of a sample in each pixel, in squared levels, as a pilot saw it.
    pub fn set_pilot(&mut self, variances: &[f32]) {
        let pilot = pooled(variances, self.part.width as usize);
        self.set_variances(&pilot);
        self.pilot = pilot;
    }

    /// Takes the samples of each pixel's neighbours into account: `variances` of a sample by each pixel's own samples.
    /// A pixel's own samples have no say in how many more it gets.
    pub fn refine(&mut self, variances: &[f32]) {
        let calibration = self.calibration as f32;
        let mut variances = of_neighbours(variances, self.part.width as usize);
        let both = variances.par_iter_mut().zip(&self.pilot);
        both.for_each(|(samples, pilot)| *samples = (*samples + calibration * pilot) / 2.0);
        self.set_variances(&variances);
    }

    fn set_variances(&mut self, variances: &[f32]) {
        let weight_of_doubling = STEPS as f32 / (1.0 + self.order) as f32;
        let least = LEAST_VARIANCE_LOG2.exp2();
        // Most have the least, and a logarithm takes long.
        let step = |&variance: &f32| match variance > least {
            true => (weight_of_doubling * (variance / least).log2() + 0.5) as u8,
            false => 0,
        };
        self.steps = variances.par_iter().map(step).collect();
        let mut pixels = [0u32; 256];
        self.steps.iter().for_each(|&step| pixels[usize::from(step)] += 1);
        let class = |(step, &pixels): (usize, &u32)| {
            let (step, pixels) = (step as i32, f64::from(pixels));
            let variance_log2 = f64::from(LEAST_VARIANCE_LOG2) + f64::from(step) / f64::from(weight_of_doubling);
            Class { step, pixels, variance: pixels * variance_log2.exp2() }
        };
        self.classes = pixels.iter().enumerate().filter(|step| *step.1 > 0).map(class).collect();
    }

    /// Returns the number of samples of a pixel of the part, once [`raise`](Self::raise) has decided it.
    fn goal(&self, pixel: usize) -> u32 {
        self.samples_of_step[usize::from(self.steps[pixel])]
    }

    /// Returns the mean squared error of the model in squared levels, by the calibration so far.
    pub fn expected(&self) -> f64 {
        self.calibration * self.modelled(self.goals)
    }

    fn modelled(&self, goals: Goals) -> f64 {
        let error: Vec<f64> = (0..=*POWERS.end()).map(|power| (-self.order * f64::from(power)).exp2()).collect();
        let sum: f64 =
            self.classes.iter().map(|class| class.variance * error[goals.power(class.step) as usize]).sum();
        sum / self.pixels
    }

    /// Returns the sum of all goals.
    fn samples(&self, goals: Goals) -> f64 {
        self.classes.iter().map(|class| class.pixels * f64::from(1 << goals.power(class.step))).sum()
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
        let goals = (self.goals.floor..=*POWERS.end()).filter_map(|floor| {
            let rest = aim - unseen(1 << floor).expected();
            (rest > 0.0).then(|| self.goals_for(floor, margin * rest))
        });
        let best = goals.min_by(|a, b| self.samples(*a).total_cmp(&self.samples(*b)));
        let goals = best.unwrap_or(Goals { floor: *POWERS.end(), ..self.goals });
        let is_more = self.samples(goals) > self.samples(self.goals);
        if is_more {
            self.goals = goals;
            self.samples_of_step = (0..256).map(|step| 1 << goals.power(step)).collect();
        }
        is_more
    }

    /// Returns the smallest scale with this floor for which the model's error is at most `aim`.
    fn goals_for(&self, floor: i32, aim: f64) -> Goals {
        // From two samples at most for the noisiest pixels to the most for all.
        let (mut low, mut high) = (-256, STEPS * POWERS.end());
        // Not very much more at once, because the calibration may still be wrong.
        if self.goals.scale > low {
            (low, high) = (self.goals.scale - 1, high.min(self.goals.scale + 4 * STEPS));
        }
        while high - low > 1 {
            let middle = (low + high).div_euclid(2);
            let error = self.calibration * self.modelled(Goals { scale: middle, floor });
            if error > aim { low = middle } else { high = middle }
        }
        Goals { scale: high, floor }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing can be missed.
    fn nothing(samples: u32) -> Unseen {
        Unseen { samples, pixels: u64::MAX }
    }

    fn with_pilot(variances: &[f32], width: usize, order: f64) -> Allocation {
        let height = (variances.len() / width) as u32;
        let part = Tile { x: 0, row: 0, width: width as u32, height };
        let mut allocation = Allocation::new(variances.len() as u64, part, order);
        allocation.set_pilot(variances);
        allocation
    }

    #[test]
    fn goals_are_rounded_to_the_nearest_power_of_two() {
        let goals = Goals { scale: 0, floor: 1 };
        for (step, power) in [(-40, 1), (0, 1), (23, 1), (24, 2), (39, 2), (40, 3), (1000, 16)] {
            assert_eq!(goals.power(step), power, "{step}");
        }
        assert_eq!(Goals { scale: 16, floor: 3 }.power(0), 3);
        assert_eq!(Goals { scale: 16, floor: 3 }.power(48), 4);
    }

    #[test]
    fn noisy_pixels_get_most_and_their_neighbours_some() {
        let mut variances = vec![0.0; 49];
        variances[24] = 10_000.0;
        let mut allocation = with_pilot(&variances, 7, 1.5);
        assert!(allocation.raise(1.0, 1.0, nothing));
        assert!(allocation.expected() <= 1.0);
        assert!(allocation.goal(24) > allocation.goal(25));
        assert!(allocation.goal(25) > allocation.goal(0));
        assert_eq!(allocation.goal(0), allocation.goal(48));
    }

    #[test]
    fn calibration_with_a_larger_error_gives_more_samples() {
        let mut allocation = with_pilot(&[100.0; 16], 4, 1.0);
        allocation.raise(4.0, 1.0, nothing);
        let before = allocation.goal(0);
        allocation.calibrate(8.0 * allocation.modelled(allocation.goals));
        allocation.raise(4.0, 1.0, nothing);
        assert!(allocation.goal(0) >= 4 * before, "{} {before}", allocation.goal(0));
    }

    #[test]
    fn every_pixel_gets_so_many_samples_that_nothing_large_is_missed() {
        // A sixth of 3 * 255^2 / (n^2 * 1024) is below 0.25 from 12 samples on.
        let mut allocation = with_pilot(&[0.0; 1024], 32, 1.5);
        let unseen = |floor| Unseen { samples: floor, pixels: 1024 };
        assert!(allocation.raise(0.25, 1.0, unseen));
        assert_eq!(allocation.goal(0), 16);
        assert!(!allocation.raise(0.25, 1.0, unseen), "nothing more is needed");
    }
}
