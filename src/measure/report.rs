//! What the work amounted to, carried beside the pictures.

use super::reference::TrueError;
use crate::options::Options;
use crate::ray_counts::RayCounts;
use crate::render::SampleCounts;
use crate::render::error_estimate::ErrorEstimate;
use crate::timing::Times;

/// The parts of the work.
#[derive(Clone, Copy, Debug, Default)]
pub struct Phases {
    /// The scene's text.
    pub parse: Times,
    /// Meshes and pictures that the scene names, but not the building of trees.
    pub load: Times,
    /// The trees that find hits.
    pub build: Times,
    /// All rays.
    pub render: Times,
    /// From samples to pixels. This happens between rays on all threads; its wall time is its CPU time divided by
    /// the number of threads, and not contained in `render`. Zero for adaptive sampling, where samples
    /// are added up as they come.
    pub filter: Times,
    /// Writing pictures.
    pub encode: Times,
}

impl Phases {
    pub fn named(&self) -> [(&'static str, Times); 6] {
        [
            ("parse", self.parse),
            ("load", self.load),
            ("build", self.build),
            ("render", self.render),
            ("filter", self.filter),
            ("encode", self.encode),
        ]
    }
}

/// Everything that is known about a run.
#[derive(Debug)]
pub struct Report<'a> {
    pub args: &'a Options,
    pub threads: usize,
    pub phases: Phases,
    pub total: Times,
    pub counts: RayCounts,
    pub decoded_faces: usize,
    pub left_out: &'a [String],
    pub sampling: SampleCounts,
    /// `None` where nothing is random, or too few samples were taken to tell.
    pub estimate: Option<ErrorEstimate>,
    pub true_error: Option<TrueError>,
}

/// The most memory that this process has held at once, in bytes, where the system tells.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}
