//! Parses the flags about the picture of depths.

use super::typed::{Typed, must_be_png, usage_error};
use crate::error::Error;
use crate::options::DepthPicture;
use std::ffi::OsString;
use std::path::PathBuf;
use vecmath::Vector3;

/// Turns `-depth auto FILE` into `-depth auto auto FILE`, so that the flag has three values in any case.
pub(super) fn with_two_ends_of_auto(mut argv: Vec<OsString>) -> Vec<OsString> {
    let autos: Vec<usize> = (1..argv.len()).filter(|&i| argv[i] == "auto" && argv[i - 1] == "--depth").collect();
    autos.into_iter().rev().for_each(|i| argv.insert(i, "auto".into()));
    argv
}

/// Parses `-depth MIN MAX FILE`, or `-depth auto auto FILE`, with `-depth-background`.
pub(super) fn picture(typed: &Typed) -> Result<Option<DepthPicture>, Error> {
    let background = background(typed)?;
    if let [min, _, path] = typed.values("depth")[..]
        && min == "auto"
    {
        let path = must_be_png("depth", PathBuf::from(path))?;
        return Ok(Some(DepthPicture { min: 0.0, max: 1.0, is_auto: true, background, path }));
    }
    let expected = "two finite numbers and a file name, or auto and a file name";
    let (min, max) = (
        typed.number("depth", 0, expected, |n: &f64| n.is_finite())?,
        typed.number("depth", 1, expected, |n: &f64| n.is_finite())?,
    );
    let (Some(min), Some(max), Some(path)) = (min, max, typed.values("depth").get(2).map(PathBuf::from)) else {
        return Ok(None);
    };
    let path = must_be_png("depth", path)?;
    Ok(Some(DepthPicture { min, max, is_auto: false, background, path }))
}

/// Parses `-depth-background R G B`.
fn background(typed: &Typed) -> Result<Option<Vector3>, Error> {
    let flag = "depth-background";
    let component = |index| typed.number(flag, index, "three numbers from 0 to 1", |c| (0.0..=1.0).contains(c));
    let (Some(red), Some(green), Some(blue)) = (component(0)?, component(1)?, component(2)?) else {
        return Ok(None);
    };
    if !typed.has("depth") {
        return Err(usage_error(flag, "is about the picture of depths: give -depth too"));
    }
    Ok(Some(Vector3::new(red, green, blue)))
}
