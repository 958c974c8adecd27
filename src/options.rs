//! [`Options`]: what the user wants, as plain data that every module may read.
//!
//! [`args`](crate::args) makes them of a command line. Nothing here decides or does anything.

use crate::simd::InstructionSet;
use std::path::{Path, PathBuf};

/// Largest width and height of a picture.
pub const MAX_SIDE: u32 = 65_536;
/// Largest number of pixels: every machine has the memory for a picture of three bytes each.
pub const MAX_PIXELS: u64 = 1 << 28;
pub const MAX_BOUNCES: u32 = 100_000;
pub const MAX_THREADS: usize = 1024;
/// Samples with `-jitter` unless `-samples` says otherwise: the course's number.
pub const DEFAULT_SAMPLES: u32 = 16;
/// Largest number of samples: those of a pixel are in memory together.
pub const MAX_SAMPLES: u32 = 1 << 16;

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
    /// Depth of mirror recursion.
    pub bounces: u32,
    pub shadows: bool,
    pub jitter: bool,
    pub filter: bool,
    /// Where shadow and mirror rays start.
    pub epsilon: Epsilon,
    /// Depart from the starter where its shortcuts give wrong pictures.
    pub robust: bool,
    /// Render one ray at a time, by the plain definition.
    pub plain: bool,
    /// `None`: as many as the machine has.
    pub threads: Option<usize>,
    pub seed: u64,
    pub quiet: bool,
    /// The instruction set that rays are computed with.
    pub simd: InstructionSet,
    /// Print the plan.
    pub explain: bool,
    pub measure: MeasureOptions,
}

impl Options {
    /// Samples for each pixel of the traced grid.
    pub fn samples(&self) -> u32 {
        if self.jitter { self.measure.samples.unwrap_or(DEFAULT_SAMPLES) } else { 1 }
    }

    /// Pixels of the traced grid for each pixel of the picture.
    pub fn grid_pixels(&self) -> u32 {
        if self.filter { 9 } else { 1 }
    }

    /// Whether the colour picture's file holds numbers instead of bytes.
    pub fn color_is_numbers(&self) -> bool {
        self.color.as_ref().is_some_and(|path| !has_extension(path, "png"))
    }

    /// Whether colours are kept as numbers, for a file or for a comparison.
    pub fn keeps_linear(&self) -> bool {
        let wanted = self.color_is_numbers() || self.measure.reference.is_some() || self.measure.keep_linear;
        wanted && self.color.is_some()
    }
}

/// `-depth MIN MAX FILE`
#[derive(Clone, Debug, PartialEq)]
pub struct DepthPicture {
    pub min: f64,
    pub max: f64,
    pub path: PathBuf,
}

/// How pixels are sampled, and what is measured about the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasureOptions {
    pub sampler: SamplerKind,
    /// Samples for each pixel of the traced grid with `-jitter`; `None`: [`DEFAULT_SAMPLES`].
    pub samples: Option<u32>,
    /// PNG of the estimated error.
    pub error_map: Option<PathBuf>,
    /// JSON.
    pub report: Option<PathBuf>,
    /// A table on standard error.
    pub stats: bool,
    /// The picture that counts as true: PNG, PFM or EXR.
    pub reference: Option<PathBuf>,
    /// CSV.
    pub convergence: Option<PathBuf>,
    /// Byte levels.
    pub target_error: Option<f64>,
    /// Seconds since the program started.
    pub time_limit: Option<f64>,
    /// Keep the colours as numbers in the film, even if no file is to hold them.
    pub keep_linear: bool,
}

impl MeasureOptions {
    /// Whether samples are taken in independent sets, which tell how wrong their mean is.
    pub fn wants_estimate(&self) -> bool {
        self.stats
            || self.report.is_some()
            || self.error_map.is_some()
            || self.convergence.is_some()
            || self.is_adaptive()
    }

    /// Whether times are measured.
    pub fn wants_times(&self) -> bool {
        self.stats || self.report.is_some()
    }

    /// Whether the number of samples is found out while rendering.
    pub fn is_adaptive(&self) -> bool {
        self.target_error.is_some() || self.time_limit.is_some()
    }
}

/// `-compare A B`
#[derive(Clone, Debug)]
pub struct CompareOptions {
    pub a: PathBuf,
    pub b: PathBuf,
    pub diff: Option<PathBuf>,
    /// Two pixels are alike when no channel differs by more levels than this.
    pub levels: u8,
    /// Percentage of pixels that may be unlike.
    pub percent: f64,
}

/// Shadow and mirror rays start this far from the surface: in world units, times the length of their direction. The
/// course's pictures depend on it.
pub const STARTER_EPSILON: f64 = 0.01;

/// What keeps shadow and mirror rays from meeting the surface that they leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Epsilon {
    /// A distance along the ray, in world units: [`STARTER_EPSILON`] for the course's pictures.
    Along(f64),
    /// The rounding error of the hit at hand, along the surface's normal.
    Auto,
}

impl Default for Epsilon {
    fn default() -> Self {
        Self::Along(STARTER_EPSILON)
    }
}

/// How the samples of a pixel are spread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SamplerKind {
    /// Each sample lies anywhere in the pixel.
    Independent,
    /// One sample in each of as many cells of equal area, as nearly square as their number allows: the course's
    /// "uniform sampling + random jitter".
    #[default]
    Stratified,
    /// Sobol's sequence with Owen's scrambling, by the crate `sobol_burley` (Burley, Practical Hash-based Owen
    /// Scrambling, JCGT 9(4), 2020). More samples can follow at any time.
    Sobol,
}

impl SamplerKind {
    pub const ALL: [Self; 3] = [Self::Independent, Self::Stratified, Self::Sobol];

    /// As the command line calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Independent => "independent",
            Self::Stratified => "stratified",
            Self::Sobol => "sobol",
        }
    }

    /// The convergence order to expect at an edge: the power of the number of samples by which the squared error falls.
    /// A curved edge through n cells meets about the root of n of them, which for one sample a cell makes 3/2.
    pub fn convergence_order(self) -> f64 {
        match self {
            Self::Independent => 1.0,
            Self::Stratified | Self::Sobol => 1.5,
        }
    }
}

/// Whether a file's name ends in `.extension`, in capitals or not.
pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}
