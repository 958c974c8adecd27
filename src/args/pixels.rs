//! Parses `-pixel`, and checks it and `-cost`.

use super::typed::{Typed, usage_error};
use crate::error::Error;
use crate::input::is_standard;
use crate::options::{MAX_SIDE, Options, PixelPlace};

/// Parses `-pixel X Y`, each time it is given. A whole number names the middle of a column or row.
pub(super) fn places(typed: &Typed) -> Result<Vec<PixelPlace>, Error> {
    let place = |index: usize| {
        let is_whole = typed.values("pixel")[index].to_str().is_some_and(|text| text.parse::<u32>().is_ok());
        let expected = format!("two numbers from 0 to {}", MAX_SIDE - 1);
        let number = typed.number("pixel", index, &expected, |n: &f64| (0.0..f64::from(MAX_SIDE)).contains(n));
        number.map(|number| number.unwrap_or_default() + if is_whole { 0.5 } else { 0.0 })
    };
    let count = typed.values("pixel").len() / 2;
    (0..count).map(|i| Ok(PixelPlace { x: place(2 * i)?, y: place(2 * i + 1)? })).collect()
}

/// Refuses pixels beyond the picture, and those whose samples are not known beforehand.
pub(super) fn check(options: &Options) -> Result<(), Error> {
    let (width, height) = (options.width, options.height);
    let is_beyond = |place: &&PixelPlace| place.pixel().0 >= width || place.pixel().1 >= height;
    if let Some((x, y)) = options.pixels.iter().find(is_beyond).map(PixelPlace::pixel) {
        let message = format!(
            "{x} {y} lies beyond the picture, whose pixels are 0 0 to {} {} (-size {width} {height})",
            width - 1,
            height - 1
        );
        return Err(usage_error("pixel", message));
    }
    if !options.pixels.is_empty() && options.files().any(is_standard) {
        return Err(usage_error(
            "pixel",
            "is printed on standard output, where no file can go then: give it a name",
        ));
    }
    let has_unknown_samples = options.measure.is_adaptive() || options.measure.convergence.is_some();
    let flags = [("pixel", !options.pixels.is_empty()), ("cost", options.cost.is_some())];
    if let Some((flag, _)) = flags.into_iter().find(|flag| has_unknown_samples && flag.1) {
        let message = "does not go with -target-error, -time-limit and -convergence, which choose the samples";
        return Err(usage_error(flag, message));
    }
    Ok(())
}
