//! [`Report`]: the pictures of a scene, their cost and their error. [`report_text`](super::report_text) prints it.

use super::convergence::Convergence;
use super::reference::TrueError;
use crate::cost::Cost;
use crate::error::Remarks;
use crate::inspect::InspectedPixel;
use crate::options::Options;
use crate::render::Frame;
use crate::scene::MeshFile;
use crate::timing::Times;
use std::time::Duration;

/// The pictures of a scene, their cost and their error.
#[derive(Debug)]
pub struct Report {
    pub frame: Frame,
    /// With `-pixel`.
    pub pixels: Vec<InspectedPixel>,
    /// With `-cost`.
    pub cost: Option<Cost>,
    /// Warnings and hints about the scene.
    pub remarks: Remarks,
    /// The range of the picture of depths.
    pub depth_range: Option<(f64, f64)>,
    /// The files of the scene's meshes.
    pub mesh_files: Vec<MeshFile>,
    /// What was left out and why, a sentence each.
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
    pub convergence: Option<Convergence>,
}

impl Report {
    /// Returns whether the estimated error, with what unseen details are expected to add, is at most `levels`.
    pub fn is_below(&self, levels: f64) -> bool {
        let is_whole = self.frame.samples.unreached == 0;
        is_whole && self.frame.estimate.is_some_and(|estimate| estimate.with_unseen() <= levels)
    }

    /// Returns whether the pictures are what was asked for: every pixel was reached, and the target error too, and all
    /// points of curves.
    pub fn is_complete(&self, options: &Options) -> bool {
        self.frame.samples.unreached == 0
            && self.convergence.as_ref().is_none_or(|convergence| convergence.is_whole)
            && options.measure.target_error.is_none_or(|target| self.is_below(target))
    }

    /// Returns the million rays of all kinds for each second of rendering.
    pub(super) fn million_rays_a_second(&self) -> f64 {
        let seconds = (self.phases.render.wall + self.phases.filter.wall).as_secs_f64();
        if seconds > 0.0 { self.frame.counts.total() as f64 / seconds / 1e6 } else { 0.0 }
    }
}

/// The times of the parts of the work.
#[derive(Clone, Copy, Debug, Default)]
pub struct Phases {
    /// The scene's text.
    pub parse: Times,
    /// Loading meshes and pictures, without building trees.
    pub load: Times,
    /// Building trees.
    pub build: Times,
    /// Tracing rays.
    pub render: Times,
    /// Turning samples into pixels. All threads do this between rays, so its wall time is its CPU time divided by the
    /// number of threads. `render` does not include it. Zero for adaptive sampling, which adds samples up at once.
    pub filter: Times,
    /// Writing pictures. What is done between rays is measured as filtering is, and is not in `render` either.
    pub encode: Times,
}

impl Phases {
    /// Subtracts the building of trees from loading, and what `threads` threads do `amid_rays` from rendering: filtering
    /// and writing.
    pub fn new(
        parse: Times,
        loading: Times,
        build: Times,
        rendering: Times,
        amid_rays: [Duration; 2],
        threads: usize,
    ) -> Self {
        let [filter, encode] = amid_rays.map(|cpu| Times { wall: cpu / threads as u32, cpu });
        let (load, render) = (loading.without(build), rendering.without(filter).without(encode));
        Self { parse, load, build, render, filter, encode }
    }

    /// Returns how long it took to read the scene and its files, and to build trees.
    pub fn before_rendering(&self) -> Duration {
        self.parse.wall + self.load.wall + self.build.wall
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

/// Returns the peak memory of this process in bytes, if the system tells.
pub(super) fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}
