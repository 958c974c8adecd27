//! [`TileCost`]: what a tile has cost, and the [`Totals`] of all.

use super::error_sums::ErrorSums;
use super::frame::SampleCounts;
use crate::ray_counts::RayCounts;
use std::time::Duration;

/// What a tile has cost, and how wrong it is.
#[derive(Default)]
pub struct TileCost {
    pub samples: SampleCounts,
    pub counts: RayCounts,
    pub errors: ErrorSums,
    /// Time spent on turning samples into pixels; zero unless it is measured.
    pub filter: Duration,
}

/// The costs and the errors of all tiles.
#[derive(Default)]
pub struct Totals {
    pub counts: RayCounts,
    pub samples: SampleCounts,
    pub errors: ErrorSums,
    pub filter: Duration,
    /// Time spent on writing, summed over all threads.
    pub writing: Duration,
}

impl Totals {
    /// Adds a tile. They are added in their order, because sums of errors are rounded.
    pub fn add(&mut self, tile: TileCost) {
        self.counts += tile.counts;
        self.samples.merge(&tile.samples);
        self.errors = ErrorSums::total([self.errors, tile.errors]);
        self.filter += tile.filter;
    }
}
