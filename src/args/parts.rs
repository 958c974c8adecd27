//! `-region`, `-tile`, `-skip-done` and `-merge`: pictures in parts.

use super::typed::{Typed, must_be_a_picture, usage_error};
use crate::error::Error;
use crate::options::{MAX_SIDE, MergeOptions, Options, Region};
use std::path::PathBuf;

/// Parses `-region` or `-tile`, for a picture of this size.
pub(super) fn region(typed: &Typed, size: (u32, u32)) -> Result<Option<Region>, Error> {
    if typed.has("region") && typed.has("tile") {
        return Err(usage_error("tile", "does not go with -region"));
    }
    if typed.has("tile") {
        return tile(typed, size).map(Some);
    }
    let expected = format!("four whole numbers from 0 to {MAX_SIDE}: X Y W H");
    let number = |index| typed.number("region", index, &expected, |n: &u32| *n <= MAX_SIDE);
    let (Some(x), Some(row), Some(width), Some(height)) = (number(0)?, number(1)?, number(2)?, number(3)?) else {
        return Ok(None);
    };
    let region = Region { x, row, width, height };
    if !region.lies_in(size) {
        let message =
            format!("expected pixels of a picture of {} x {}, found {x} {row} {width} {height}", size.0, size.1);
        return Err(usage_error("region", message));
    }
    Ok(Some(region))
}

fn tile(typed: &Typed, size: (u32, u32)) -> Result<Region, Error> {
    let typed = typed.values("tile").first().map_or(String::new(), |value| value.to_string_lossy().into_owned());
    let pixels = u64::from(size.0) * u64::from(size.1);
    let numbers =
        typed.split_once('/').and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
    match numbers.filter(|&(index, count)| (1..=count).contains(&index) && count <= pixels) {
        Some((index, count)) => Ok(Region::part(index - 1, count, size)),
        None => Err(usage_error(
            "tile",
            format!("expected I/N with I from 1 to N, and N up to {pixels}, found '{typed}'"),
        )),
    }
}

/// Checks that a part, or what may be skipped, does not ask for what only a whole picture or a new one has.
pub(super) fn check_region(options: &Options) -> Result<(), Error> {
    let measure = &options.measure;
    let flags = [
        ("target-error", measure.target_error.is_some()),
        ("time-limit", measure.time_limit.is_some()),
        ("error-map", measure.error_map.is_some()),
        ("convergence", measure.convergence.is_some()),
        ("reference", measure.reference.is_some()),
        ("depth auto", options.depth.as_ref().is_some_and(|depth| depth.is_auto)),
        ("depth-background", options.depth.as_ref().is_some_and(|depth| depth.background.is_some())),
        ("check", options.check),
        ("cost", options.cost.is_some()),
        ("pixel", !options.pixels.is_empty()),
    ];
    match flags.iter().find(|flag| flag.1 && options.wants_labels()) {
        Some((flag, _)) => Err(usage_error(flag, "does not go with -region, -tile or -skip-done")),
        None => Ok(()),
    }
}

pub(super) fn merge_options(typed: &Typed) -> Result<MergeOptions, Error> {
    typed.refuse_others("merge", &["quiet"], "a file and its parts")?;
    let mut files = typed.values("merge").into_iter().map(PathBuf::from);
    let output = files.next().map(|path| must_be_a_picture("merge", path)).transpose()?;
    let output = output.ok_or_else(|| usage_error("merge", "needs a file to write and parts"))?;
    Ok(MergeOptions { output, parts: files.collect() })
}
