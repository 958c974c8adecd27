//! The flags that choose samples, and those that ask how wrong the picture is and what it cost.

use super::typed::{Typed, has_extension, must_be_png, must_be_supported, usage_error};
use crate::error::Error;
use crate::render::SamplerKind;
use std::path::PathBuf;

/// Samples, and what is to be known about them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasureArgs {
    pub sampler: SamplerKind,
    /// Samples a pixel of the traced grid with `-jitter`; `None`: [`DEFAULT_SAMPLES`].
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

/// Samples with `-jitter` unless `-samples` says otherwise: what the course defines.
pub const DEFAULT_SAMPLES: u32 = 16;
/// The samples of a pixel are held in memory together.
pub const MAX_SAMPLES: u32 = 1 << 16;

/// Flags that make no sense without random samples, and therefore ask for them as `-jitter` does.
const IMPLY_JITTER: [&str; 6] = ["samples", "sampler", "error-map", "convergence", "target-error", "time-limit"];

impl MeasureArgs {
    pub(super) fn new(typed: &Typed) -> Result<Self, Error> {
        let samples = format!("a whole number from 1 to {MAX_SAMPLES}");
        let args = Self {
            sampler: sampler(typed)?,
            samples: typed.number("samples", 0, &samples, |n| (1..=MAX_SAMPLES).contains(n))?,
            error_map: typed.path("error-map").map(|path| must_be_png("error-map", path)).transpose()?,
            report: with_extension(typed, "report", &["json"])?,
            stats: typed.has("stats"),
            reference: with_extension(typed, "reference", &["png", "pfm", "exr"])?,
            convergence: with_extension(typed, "convergence", &["csv"])?,
            target_error: typed.number("target-error", 0, "a number of byte levels above 0", |n: &f64| {
                *n > 0.0 && n.is_finite()
            })?,
            time_limit: typed
                .number("time-limit", 0, "a number of seconds above 0", |n: &f64| *n > 0.0 && n.is_finite())?,
            keep_linear: false,
        };
        for (flag, given) in [("target-error", args.target_error.is_some()), ("time-limit", args.is_limited())] {
            if given && args.convergence.is_some() {
                return Err(usage_error("convergence", format!("does not go with -{flag}")));
            }
        }
        Ok(args)
    }

    fn is_limited(&self) -> bool {
        self.time_limit.is_some()
    }

    /// Flags that measure colours, which must then be rendered.
    pub(super) fn needs_color(&self) -> Option<&'static str> {
        [
            ("error-map", self.error_map.is_some()),
            ("reference", self.reference.is_some()),
            ("convergence", self.convergence.is_some()),
            ("target-error", self.target_error.is_some()),
        ]
        .into_iter()
        .find(|flag| flag.1)
        .map(|flag| flag.0)
    }

    /// Whether the samples are to be taken in a way that tells how wrong their mean is.
    pub fn wants_estimate(&self) -> bool {
        self.stats
            || self.report.is_some()
            || self.error_map.is_some()
            || self.convergence.is_some()
            || self.is_progressive()
    }

    /// Whether times are to be measured.
    pub fn wants_times(&self) -> bool {
        self.stats || self.report.is_some()
    }

    /// Whether the number of samples is found out while rendering.
    pub fn is_progressive(&self) -> bool {
        self.target_error.is_some() || self.time_limit.is_some()
    }

    /// The files to be written, with their flags.
    pub(super) fn outputs(&self) -> [Option<&PathBuf>; 3] {
        [self.error_map.as_ref(), self.report.as_ref(), self.convergence.as_ref()]
    }
}

/// Whether the samples are random: `-jitter`, or a flag that implies it.
pub(super) fn jitter(typed: &Typed) -> bool {
    typed.has("jitter") || IMPLY_JITTER.into_iter().any(|flag| typed.has(flag))
}

/// Stratified samples cannot be extended without a loss, so where the number of samples is found out while
/// rendering, the default is Sobol.
fn sampler(typed: &Typed) -> Result<SamplerKind, Error> {
    let Some(name) = typed.values("sampler").first().map(|name| name.to_string_lossy()) else {
        let is_progressive = typed.has("target-error") || typed.has("time-limit");
        return Ok(if is_progressive { SamplerKind::Sobol } else { SamplerKind::Stratified });
    };
    SamplerKind::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
        let names = SamplerKind::ALL.map(SamplerKind::name).join(", ");
        usage_error("sampler", format!("expected one of {names}, found '{name}'"))
    })
}

fn with_extension(typed: &Typed, flag: &str, extensions: &[&str]) -> Result<Option<PathBuf>, Error> {
    let Some(path) = typed.path(flag) else {
        return Ok(None);
    };
    if extensions.iter().any(|extension| has_extension(&path, extension)) {
        return must_be_supported(flag, path).map(Some);
    }
    let message =
        format!("expected a file name that ends in .{}, found '{}'", extensions.join(", ."), path.display());
    Err(usage_error(flag, message))
}
