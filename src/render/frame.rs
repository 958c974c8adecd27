//! [`Frame`]: what rendering gives.

use super::error_estimate::ErrorEstimate;
use crate::film::Film;
use crate::ray_counts::RayCounts;
use std::time::Duration;

/// The pixels of a picture, and what they cost.
#[derive(Debug)]
pub struct Frame {
    pub film: Film,
    /// The rays traced for it.
    pub counts: RayCounts,
    pub samples: SampleCounts,
    /// How wrong the colours are; `None` where nothing is random, or too few samples were taken to tell.
    pub estimate: Option<ErrorEstimate>,
    /// Time that all threads together spent on turning samples into pixels; zero unless it was measured.
    pub filter: Duration,
}

/// How many samples the pixels of a picture got.
#[derive(Clone, Copy, Debug, Default)]
pub struct SampleCounts {
    pub pixels: u64,
    pub total: u64,
    /// In any pixel; `None` without pixels.
    pub least: Option<u32>,
    pub most: u32,
    /// Passes over the picture; 0 where the number of samples was known before.
    pub passes: u32,
}

impl SampleCounts {
    /// Returns the same number in every pixel.
    pub fn even(pixels: u64, samples: u32) -> Self {
        Self { pixels, total: pixels * u64::from(samples), least: Some(samples), most: samples, passes: 0 }
    }

    pub fn add_pixel(&mut self, samples: u32) {
        self.pixels += 1;
        self.total += u64::from(samples);
        self.least = Some(self.least.map_or(samples, |least| least.min(samples)));
        self.most = self.most.max(samples);
    }

    /// Samples a pixel.
    pub fn mean(&self) -> f64 {
        self.total as f64 / self.pixels.max(1) as f64
    }
}
