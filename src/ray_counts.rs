//! [`RayCounts`]: how many rays a picture took.

use std::fmt;
use std::ops::AddAssign;

/// Rays by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    pub camera: u64,
    /// Camera rays that hit anything.
    pub camera_hits: u64,
    pub shadow: u64,
    pub mirror: u64,
    /// Shadow rays that were skipped because the light contributes exactly zero.
    pub shadow_left_out: u64,
}

impl RayCounts {
    pub fn total(&self) -> u64 {
        self.camera + self.shadow + self.mirror
    }
}

impl AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.camera += other.camera;
        self.camera_hits += other.camera_hits;
        self.shadow += other.shadow;
        self.mirror += other.mirror;
        self.shadow_left_out += other.shadow_left_out;
    }
}

impl fmt::Display for RayCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "camera rays: {}", self.camera)?;
        writeln!(f, "shadow rays: {}, left out: {}", self.shadow, self.shadow_left_out)?;
        writeln!(f, "mirror rays: {}", self.mirror)
    }
}
