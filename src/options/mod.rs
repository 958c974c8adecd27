//! [`Options`]: what the user wants, as plain data that every module may read.
//!
//! [`args`](crate::args) makes them of a command line. Nothing here does anything.

mod region;
mod sampling;

pub use region::Region;
pub use sampling::{DEFAULT_SAMPLES, MAX_SAMPLES, MeasureOptions, SamplerKind};

use crate::input::is_standard;
use crate::simd::InstructionSet;
use std::path::{Path, PathBuf};
use vecmath::Vector3;

/// Largest width and height of a picture.
pub const MAX_SIDE: u32 = 65_536;
pub const MAX_BOUNCES: u32 = 100_000;
pub const MAX_THREADS: usize = 1024;

/// How a scene is to be rendered, and into which files.
#[derive(Clone, Debug)]
pub struct Options {
    pub input: PathBuf,
    /// Colour picture.
    pub color: Option<PathBuf>,
    pub depth: Option<DepthPicture>,
    pub normals: Option<PathBuf>,
    /// Pixels.
    pub width: u32,
    pub height: u32,
    /// Only this part of the picture is rendered.
    pub region: Option<Region>,
    /// Leave alone what the same run has finished before.
    pub skip_done: bool,
    /// Depth of mirror recursion.
    pub bounces: u32,
    /// Whether it was typed.
    pub bounces_are_given: bool,
    pub shadows: bool,
    pub jitter: bool,
    pub filter: bool,
    /// Where shadow and mirror rays start.
    pub epsilon: Epsilon,
    /// Do without the starter's shortcuts where they give wrong pictures.
    pub robust: bool,
    /// Render one ray at a time, by the plain definition.
    pub plain: bool,
    /// Number of threads; `None`: one for each processor.
    pub threads: Option<usize>,
    pub seed: u64,
    pub quiet: bool,
    /// Bytes.
    pub max_memory: Option<u64>,
    /// The instruction set that rays are computed with.
    pub simd: InstructionSet,
    /// Print the plan.
    pub explain: bool,
    /// Places whose ray trees are shown.
    pub pixels: Vec<PixelPlace>,
    /// Picture of what each pixel costs.
    pub cost: Option<PathBuf>,
    /// Read everything and render nothing.
    pub check: bool,
    pub measure: MeasureOptions,
}

impl Options {
    /// Returns the pictures to write.
    pub fn pictures(&self) -> impl Iterator<Item = &Path> + Clone {
        let depth = self.depth.as_ref().map(|depth| depth.path.as_path());
        [self.color.as_deref(), self.normals.as_deref(), depth].into_iter().flatten()
    }

    /// Returns all files to write.
    pub fn files(&self) -> impl Iterator<Item = &Path> + Clone {
        self.files_by_flag().map(|file| file.1)
    }

    /// Returns all files to write, each with its flag.
    pub fn files_by_flag(&self) -> impl Iterator<Item = (&'static str, &Path)> + Clone {
        let MeasureOptions { error_map, report, convergence, .. } = &self.measure;
        let depth = self.depth.as_ref().map(|depth| &depth.path);
        let files = [
            ("output", self.color.as_ref()),
            ("normals", self.normals.as_ref()),
            ("depth", depth),
            ("cost", self.cost.as_ref()),
            ("error-map", error_map.as_ref()),
            ("report", report.as_ref()),
            ("convergence", convergence.as_ref()),
        ];
        files.into_iter().filter_map(|(flag, path)| Some((flag, path?.as_path())))
    }

    /// Returns whether a picture of colours is rendered: for a file, or for the curves of its error.
    pub fn renders_colors(&self) -> bool {
        self.color.is_some() || self.measure.convergence.is_some()
    }

    /// Returns whether colours are computed: for a picture, or to show how a pixel gets its colour and what it costs. What
    /// they need is what -check reads.
    pub fn wants_colors(&self) -> bool {
        self.renders_colors() || self.check || self.cost.is_some() || !self.pixels.is_empty()
    }

    /// Returns the number of samples for each pixel of the traced grid.
    pub fn samples(&self) -> u32 {
        if self.jitter { self.measure.samples.unwrap_or(DEFAULT_SAMPLES) } else { 1 }
    }

    /// Returns the most samples of a pixel of the picture that are taken before a time limit.
    pub fn most_samples_a_pixel(&self) -> u32 {
        self.measure.samples.unwrap_or(MAX_SAMPLES) * self.grid_pixels()
    }

    /// Returns the number of pixels of the traced grid for each pixel of the picture.
    pub fn grid_pixels(&self) -> u32 {
        if self.filter { 9 } else { 1 }
    }

    /// Returns the number of samples of a pixel of the picture.
    pub fn samples_a_pixel(&self) -> u32 {
        self.samples() * self.grid_pixels()
    }

    /// Returns the part of the picture that is rendered.
    pub fn shown(&self) -> Region {
        self.region.unwrap_or(Region::whole(self.width, self.height))
    }

    /// Returns the number of pixels that are rendered.
    pub fn pixel_count(&self) -> u64 {
        let shown = self.shown();
        u64::from(shown.width) * u64::from(shown.height)
    }

    /// Returns whether files are labelled, so that they can be joined, or be recognised.
    pub fn wants_labels(&self) -> bool {
        self.region.is_some() || self.skip_done
    }

    /// Returns whether the whole picture stays in memory until it is written: where pixels are rendered again, or are
    /// compared with others. Otherwise it is written while it is rendered.
    pub fn keeps_film(&self) -> bool {
        let measure = &self.measure;
        let is_compared = measure.reference.is_some() || measure.wants_error_map() || measure.keep_linear;
        let has_background = self.depth.as_ref().is_some_and(|depth| depth.background.is_some());
        is_compared || measure.convergence.is_some() || has_background
    }

    /// Returns whether the colour picture's file holds numbers instead of bytes.
    pub fn color_is_numbers(&self) -> bool {
        self.color.as_ref().is_some_and(|path| !has_extension(path, "png") && !is_standard(path))
    }

    /// Returns whether colours are kept as numbers, for a file or for a comparison.
    pub fn keeps_linear(&self) -> bool {
        let wanted = self.color_is_numbers() || self.measure.reference.is_some() || self.measure.keep_linear;
        wanted && self.renders_colors()
    }
}

/// `-pixel X Y`: a place in the picture, in pixels from its upper left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelPlace {
    pub x: f64,
    pub y: f64,
}

impl PixelPlace {
    /// Returns column and row of the pixel.
    pub fn pixel(&self) -> (u32, u32) {
        (self.x as u32, self.y as u32)
    }
}

/// `-merge OUT PART...`
#[derive(Clone, Debug)]
pub struct MergeOptions {
    pub output: PathBuf,
    /// At least one.
    pub parts: Vec<PathBuf>,
}

/// `-depth MIN MAX FILE`
#[derive(Clone, Debug, PartialEq)]
pub struct DepthPicture {
    pub min: f64,
    pub max: f64,
    /// Whether the range is found while rendering; until then it is 0 to 1.
    pub is_auto: bool,
    /// The colour where nothing is hit, each component from 0 to 1; `None`: black.
    pub background: Option<Vector3>,
    pub path: PathBuf,
}

/// `-compare A B`
#[derive(Clone, Debug)]
pub struct CompareOptions {
    pub a: PathBuf,
    pub b: PathBuf,
    /// PNG of both pictures and their differences.
    pub diff: Option<PathBuf>,
    /// JSON.
    pub report: Option<PathBuf>,
    /// Two pixels are alike when no channel differs by more levels than this.
    pub levels: u8,
    /// Percentage of pixels that may be unlike.
    pub percent: f64,
}

impl CompareOptions {
    /// Returns whether two pictures are alike of which this percentage of the pixels is not.
    pub fn are_alike(&self, percent: f64) -> bool {
        percent <= self.percent
    }
}

/// The starter's ray offset: shadow and mirror rays start this far along their direction, in world units times the
/// length of the direction. The course's pictures depend on it.
pub const STARTER_EPSILON: f64 = 0.01;

/// The ray offset, which keeps shadow and mirror rays from hitting the surface that they leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Epsilon {
    /// A distance along the ray, in world units: [`STARTER_EPSILON`] for the course's pictures.
    Along(f64),
    /// The error bound of each hit, along the surface's normal.
    Auto,
}

impl Default for Epsilon {
    fn default() -> Self {
        Self::Along(STARTER_EPSILON)
    }
}

/// Returns the format of a picture of numbers by its name; `None` for one of bytes.
pub fn format_of_numbers(path: &Path) -> Option<&'static str> {
    ["pfm", "exr"].into_iter().find(|extension| has_extension(path, extension))
}

/// Returns whether a file's name ends in `.extension`, in capitals or not.
pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}
