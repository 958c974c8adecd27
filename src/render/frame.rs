//! [`Frame`]: the result of rendering.

use super::error_estimate::ErrorEstimate;
use crate::film::{Film, Planes};
use crate::ray_counts::RayCounts;
use std::time::Duration;

/// The pixels of a picture, and their cost.
#[derive(Debug)]
pub struct Frame {
    /// Empty if the pictures were written while they were rendered.
    pub film: Film,
    /// Rays traced.
    pub counts: RayCounts,
    pub samples: SampleCounts,
    /// The estimated error of the colours; `None` without random samples, or with too few of them.
    pub estimate: Option<ErrorEstimate>,
    /// Time spent on turning samples into pixels, summed over all threads; zero unless it was measured.
    pub filter: Duration,
    /// Time spent on writing bands, summed over all threads.
    pub writing: Duration,
}

impl Frame {
    /// Makes a frame without pictures.
    pub fn empty() -> Self {
        Self {
            film: Film::new(0, 0, Planes::default()),
            counts: RayCounts::default(),
            samples: SampleCounts::default(),
            estimate: None,
            filter: Duration::ZERO,
            writing: Duration::ZERO,
        }
    }
}

/// The numbers of samples of a picture's pixels.
#[derive(Clone, Copy, Debug, Default)]
pub struct SampleCounts {
    pub pixels: u64,
    pub total: u64,
    /// The smallest number of any pixel; `None` without pixels.
    pub least: Option<u32>,
    pub most: u32,
    /// Pixels without samples.
    pub unreached: u64,
    /// Passes of adaptive sampling; 0 if the number of samples was known before.
    pub passes: u32,
}

impl SampleCounts {
    /// Adds pixels with so many samples each.
    pub fn add_pixels(&mut self, pixels: u64, samples: u32) {
        self.pixels += pixels;
        self.total += pixels * u64::from(samples);
        self.least = Some(self.least.map_or(samples, |least| least.min(samples)));
        self.most = self.most.max(samples);
        self.unreached += if samples == 0 { pixels } else { 0 };
    }

    /// Returns the counts of pixels with their numbers of samples. Sums without branches, because there are many.
    pub fn of_each(samples: &[u32]) -> Self {
        Self {
            pixels: samples.len() as u64,
            total: samples.iter().map(|&samples| u64::from(samples)).sum(),
            least: samples.iter().copied().min(),
            most: samples.iter().copied().max().unwrap_or(0),
            unreached: samples.iter().map(|&samples| u64::from(samples == 0)).sum(),
            passes: 0,
        }
    }

    /// Returns the counts of pixels with so many samples each.
    pub fn of_pixels(pixels: u64, samples: u32) -> Self {
        let mut counts = Self::default();
        counts.add_pixels(pixels, samples);
        counts
    }

    /// Adds the pixels of another part of the picture.
    pub fn merge(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.total += other.total;
        self.least = self.least.into_iter().chain(other.least).min();
        self.most = self.most.max(other.most);
        self.unreached += other.unreached;
    }

    /// Returns the share of the pixels that have samples.
    pub fn reached(&self) -> f64 {
        1.0 - self.unreached as f64 / self.pixels.max(1) as f64
    }

    /// Returns the mean number of samples a pixel.
    pub fn mean(&self) -> f64 {
        self.total as f64 / self.pixels.max(1) as f64
    }
}
