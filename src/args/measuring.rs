//! Parses the flags about samples, errors and cost.

use super::typed::{Typed, must_be_supported, unlike, usage_error};
use crate::error::Error;
use crate::input::is_standard;
use crate::options::{MAX_SAMPLES, MeasureOptions, SamplerKind, has_extension};
use std::path::PathBuf;

/// Flags that need random samples, and therefore imply `-jitter`.
const IMPLY_JITTER: [&str; 6] = ["samples", "sampler", "error-map", "convergence", "target-error", "time-limit"];

pub(super) fn options(typed: &Typed) -> Result<MeasureOptions, Error> {
    let samples = format!("a whole number from 1 to {MAX_SAMPLES}");
    let above_zero = |n: &f64| *n > 0.0 && n.is_finite();
    let options = MeasureOptions {
        sampler: sampler(typed)?,
        sampler_is_given: typed.has("sampler"),
        samples: typed.number("samples", 0, &samples, |n| (1..=MAX_SAMPLES).contains(n))?,
        error_map: typed.png_path("error-map")?,
        report: with_extension(typed, "report", &["json"])?,
        stats: typed.has("stats"),
        reference: with_extension(typed, "reference", &["png", "pfm", "exr"])?,
        convergence: with_extension(typed, "convergence", &["svg", "html", "csv"])?,
        target_error: typed.number("target-error", 0, "a number of byte levels above 0", above_zero)?,
        time_limit: typed.number("time-limit", 0, "a number of seconds above 0", above_zero)?,
        keep_linear: false,
    };
    let adaptive = [("target-error", options.target_error), ("time-limit", options.time_limit)];
    match adaptive.into_iter().find(|flag| flag.1.is_some()) {
        Some(("target-error", _)) if options.samples.is_some() => {
            Err(usage_error("samples", "does not go with -target-error, which chooses the samples"))
        }
        Some((flag, _)) if options.convergence.is_some() => {
            Err(usage_error("convergence", format!("does not go with -{flag}")))
        }
        _ => Ok(options),
    }
}

/// Returns the first given flag that measures colours and so needs a colour picture. `-convergence` renders its own.
pub(super) fn needs_color(options: &MeasureOptions) -> Option<&'static str> {
    let flags = [
        ("error-map", options.error_map.is_some()),
        ("reference", options.reference.is_some()),
        ("target-error", options.target_error.is_some()),
    ];
    flags.into_iter().find(|flag| flag.1).map(|flag| flag.0)
}

/// Returns whether the samples are random: `-jitter`, or a flag that implies it.
pub(super) fn jitter(typed: &Typed) -> bool {
    typed.has("jitter") || IMPLY_JITTER.into_iter().any(|flag| typed.has(flag))
}

/// Parses `-sampler`. A stratified set cannot be extended, so the default is Sobol where the number of samples is
/// determined while rendering.
fn sampler(typed: &Typed) -> Result<SamplerKind, Error> {
    let Some(name) = typed.values("sampler").first().map(|name| name.to_string_lossy()) else {
        let is_adaptive = typed.has("target-error") || typed.has("time-limit");
        return Ok(if is_adaptive { SamplerKind::Sobol } else { SamplerKind::Stratified });
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
    if flag == "report" && is_standard(&path) {
        return Ok(Some(path));
    }
    if extensions.iter().any(|extension| has_extension(&path, extension)) {
        return must_be_supported(flag, path).map(Some);
    }
    Err(unlike(flag, extensions, &path))
}
