//! How pixels are sampled, and what is measured about pictures.

use super::has_extension;
use std::path::PathBuf;

/// Samples with `-jitter` and without `-samples`: the course's number.
pub const DEFAULT_SAMPLES: u32 = 16;
/// Largest number of samples: all samples of a pixel are in memory at the same time.
pub const MAX_SAMPLES: u32 = 1 << 16;

/// How pixels are sampled, and what is measured about the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasureOptions {
    pub sampler: SamplerKind,
    /// Whether the sampler was named. Otherwise `-convergence` compares all of them.
    pub sampler_is_given: bool,
    /// Samples for each pixel of the traced grid with `-jitter`; `None`: [`DEFAULT_SAMPLES`], or with a time limit as many as
    /// there is time for.
    pub samples: Option<u32>,
    /// PNG of the estimated error.
    pub error_map: Option<PathBuf>,
    /// JSON.
    pub report: Option<PathBuf>,
    /// A table on standard error.
    pub stats: bool,
    /// The picture that counts as true: PNG, PFM or EXR.
    pub reference: Option<PathBuf>,
    /// SVG, HTML or CSV.
    pub convergence: Option<PathBuf>,
    /// Byte levels.
    pub target_error: Option<f64>,
    /// Seconds since the program started.
    pub time_limit: Option<f64>,
    /// Keep the colours as numbers in the film, even if no file needs them.
    pub keep_linear: bool,
}

impl MeasureOptions {
    /// Returns whether samples are taken in independent sets, from which the error of their mean is estimated.
    pub fn wants_estimate(&self) -> bool {
        self.stats
            || self.report.is_some()
            || self.error_map.is_some()
            || self.convergence.is_some()
            || self.is_adaptive()
    }

    /// Returns whether the estimated error of each pixel is kept: for a picture of its own, or for the page of
    /// `-convergence`.
    pub fn wants_error_map(&self) -> bool {
        self.error_map.is_some() || self.convergence.as_ref().is_some_and(|path| has_extension(path, "html"))
    }

    /// Returns whether times are measured.
    pub fn wants_times(&self) -> bool {
        self.stats || self.report.is_some()
    }

    /// Returns whether the number of samples is determined while rendering.
    pub fn is_adaptive(&self) -> bool {
        self.target_error.is_some() || self.time_limit.is_some()
    }
}

/// How the samples of a pixel are spread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SamplerKind {
    /// Each sample lies anywhere in the pixel.
    Independent,
    /// The pixel is divided into one cell for each sample. Cells have equal area and are nearly square: the course's
    /// "uniform sampling + random jitter".
    #[default]
    Stratified,
    /// Sobol's sequence in two dimensions with Owen's scrambling. More samples can follow at any time.
    Sobol,
}

impl SamplerKind {
    pub const ALL: [Self; 3] = [Self::Independent, Self::Stratified, Self::Sobol];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Independent => "independent",
            Self::Stratified => "stratified",
            Self::Sobol => "sobol",
        }
    }

    /// Returns the expected convergence order at an edge: b if the squared error falls as n^-b with n samples. A
    /// curved edge crosses about sqrt(n) of n cells, which gives 3/2 for one sample in each cell.
    pub fn convergence_order(self) -> f64 {
        match self {
            Self::Independent => 1.0,
            Self::Stratified | Self::Sobol => 1.5,
        }
    }
}
