//! [`Report`]: the pictures of a scene, and everything that is known about them. Its texts are in
//! [`report_text`](super::report_text).

use super::convergence::Point;
use super::reference::TrueError;
use crate::render::Frame;
use crate::timing::Times;
use std::time::Duration;

/// The pictures of a scene, and everything that is known about them.
#[derive(Debug)]
pub struct Report {
    pub frame: Frame,
    /// What the scene's author should know.
    pub warnings: Vec<String>,
    /// What was not done, a sentence each.
    pub left_out: Vec<String>,
    /// Cube map faces that had to be decoded.
    pub decoded_faces: usize,
    pub threads: usize,
    pub phases: Phases,
    /// From the start of the program.
    pub total: Times,
    /// With `-reference`.
    pub true_error: Option<TrueError>,
    /// With `-convergence`.
    pub convergence: Vec<Point>,
}

impl Report {
    /// Whether the estimated error is at most `levels`.
    pub fn is_below(&self, levels: f64) -> bool {
        let is_whole = self.frame.samples.least > Some(0);
        is_whole && self.frame.estimate.is_some_and(|estimate| estimate.levels.rmse <= levels)
    }

    /// Million rays of all kinds a second of rendering.
    pub(super) fn million_rays_a_second(&self) -> f64 {
        let seconds = (self.phases.render.wall + self.phases.filter.wall).as_secs_f64();
        if seconds > 0.0 { self.frame.counts.total() as f64 / seconds / 1e6 } else { 0.0 }
    }
}

/// How long the parts of the work took.
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
    /// the number of threads, and not contained in `render`. Zero for adaptive sampling, where samples are added up as
    /// they come.
    pub filter: Times,
    /// Writing pictures.
    pub encode: Times,
}

impl Phases {
    /// Takes the building of trees out of loading, and filtering on `threads` threads out of rendering.
    pub fn new(
        parse: Times,
        loading: Times,
        build: Times,
        rendering: Times,
        filter: Duration,
        threads: usize,
    ) -> Self {
        let filter = Times { wall: filter / threads as u32, cpu: filter };
        let (load, render) = (loading.without(build), rendering.without(filter));
        Self { parse, load, build, render, filter, encode: Times::default() }
    }

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

/// The most memory that this process has held at once, in bytes, where the system tells.
pub(super) fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}
