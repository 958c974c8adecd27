//! The argument parser: a command line in, [`Options`] out.
//!
//! The flags are the course's long flags with one dash (`-input`); two dashes work too. `clap` splits the line into
//! flags and values. The values are checked here, so that every message names flag, value and expectation.

mod depth;
mod flags;
pub mod help;
mod measuring;
mod parts;
mod pixels;
mod typed;

pub use flags::{Flag, GROUPS, flags};

use crate::error::Error;
use crate::input::is_standard;
use crate::options::{
    CompareOptions, Epsilon, MAX_BOUNCES, MAX_SIDE, MAX_THREADS, MergeOptions, Options, has_extension,
};
use crate::simd::InstructionSet;
use parts::{check_region, merge_options, region};
use std::ffi::OsString;
use std::path::PathBuf;
use typed::{Typed, command, explained, must_be_a_picture, unlike, usage_error, with_two_dashes};

/// What a command line asks the program to do.
#[derive(Debug)]
pub enum Request {
    /// Print this text and end with exit code 0.
    Print(String),
    /// No arguments: print this text on standard error and end with exit code 2.
    PrintUsage(String),
    Render(Box<Options>),
    Compare(CompareOptions),
    Merge(MergeOptions),
}

/// Parses a command line, without the program's name.
///
/// # Errors
/// [`Error::Usage`] for a wrong command line.
pub fn parse(argv: impl IntoIterator<Item = OsString>) -> Result<Request, Error> {
    let argv = depth::with_two_ends_of_auto(argv.into_iter().map(with_two_dashes).collect());
    if argv.is_empty() {
        return Ok(Request::PrintUsage(help::screen()));
    }
    for (flag, text) in
        [("--h", help::screen as fn() -> String), ("--help", help::page), ("--version", help::version)]
    {
        // Beside flags whose values are missing, too.
        if argv.iter().any(|word| word == flag) {
            return Ok(Request::Print(text()));
        }
    }
    let command = command(&argv);
    let matches = command.try_get_matches_from(argv).map_err(|error| Error::Usage(explained(&error)))?;
    let typed = Typed(&matches);
    if typed.has("compare") {
        return compare_options(&typed).map(Request::Compare);
    }
    if typed.has("merge") {
        return merge_options(&typed).map(Request::Merge);
    }
    for only_with_compare in ["diff", "tolerance"] {
        if typed.has(only_with_compare) {
            return Err(usage_error(only_with_compare, "goes with -compare only"));
        }
    }
    options(&typed).map(|options| Request::Render(Box::new(options)))
}

fn options(typed: &Typed) -> Result<Options, Error> {
    let input = typed.scene()?.ok_or_else(|| Error::Usage("-input is missing: which scene?".into()))?;
    if !is_standard(&input) && !has_extension(&input, "txt") {
        return Err(unlike("input", &["txt"], &input));
    }
    let side = |index| {
        let expected = format!("two whole numbers from 1 to {MAX_SIDE}");
        typed.number("size", index, &expected, |n: &u32| (1..=MAX_SIDE).contains(n))
    };
    let bounces = format!("a whole number from 0 to {MAX_BOUNCES}");
    let threads = format!("a whole number from 1 to {MAX_THREADS}");
    let size = (side(0)?.unwrap_or(100), side(1)?.unwrap_or(100));
    let options = Options {
        input,
        color: typed.path("output").map(|path| must_be_a_picture("output", path)).transpose()?,
        depth: depth::picture(typed)?,
        normals: typed.png_path("normals")?,
        width: size.0,
        height: size.1,
        region: region(typed, size)?,
        skip_done: typed.has("skip-done"),
        bounces: typed.number("bounces", 0, &bounces, |n| *n <= MAX_BOUNCES)?.unwrap_or(0),
        bounces_are_given: typed.has("bounces"),
        shadows: typed.has("shadows"),
        jitter: measuring::jitter(typed),
        filter: typed.has("filter"),
        epsilon: epsilon(typed)?,
        robust: typed.has("robust"),
        plain: typed.has("plain"),
        threads: typed.number("threads", 0, &threads, |n| (1..=MAX_THREADS).contains(n))?,
        seed: typed.number("seed", 0, "a whole number from 0 to 2^64 - 1", |_| true)?.unwrap_or(0),
        quiet: typed.has("quiet"),
        max_memory: max_memory(typed)?,
        simd: instruction_set(typed)?,
        explain: typed.has("explain"),
        pixels: pixels::places(typed)?,
        cost: typed.png_path("cost")?,
        check: typed.has("check"),
        measure: measuring::options(typed)?,
    };
    if let (Some(flag), false) = (measuring::needs_color(&options.measure), options.renders_colors()) {
        return Err(usage_error(flag, "is about colours: give -output too"));
    }
    pixels::check(&options)?;
    let shows_something =
        options.renders_colors() || options.cost.is_some() || !options.pixels.is_empty() || options.check;
    if options.pictures().next().is_none() && !shows_something {
        let message = "no picture is asked for: give -output, -depth or -normals (or -convergence, or -check)";
        return Err(Error::Usage(message.into()));
    }
    check_region(&options)?;
    if options.check && options.measure.report.is_some() {
        return Err(usage_error("report", "does not go with -check, which renders nothing"));
    }
    Ok(options)
}

/// Parses a number of bytes, as in `500M`.
fn max_memory(typed: &Typed) -> Result<Option<u64>, Error> {
    let Some(size) = typed.values("max-memory").first().map(|size| size.to_string_lossy()) else {
        return Ok(None);
    };
    let (number, shift) = match size.char_indices().last() {
        Some((at, 'K' | 'k')) => (&size[..at], 10),
        Some((at, 'M' | 'm')) => (&size[..at], 20),
        Some((at, 'G' | 'g')) => (&size[..at], 30),
        _ => (&*size, 0),
    };
    let bytes = number.parse::<f64>().ok().filter(|n| n.is_finite() && *n > 0.0);
    let message = || format!("expected bytes above 0, or a number with K, M or G, found '{size}'");
    bytes.map(|n| Some((n * (1u64 << shift) as f64) as u64)).ok_or_else(|| usage_error("max-memory", message()))
}

fn instruction_set(typed: &Typed) -> Result<InstructionSet, Error> {
    let Some(name) = typed.values("simd").first().copied() else {
        return Ok(InstructionSet::detected());
    };
    let name = name.to_string_lossy();
    let names = InstructionSet::NAMES;
    if !names.contains(&&*name) && name != "scalar" {
        return Err(usage_error("simd", format!("expected one of {}, found '{name}'", names.join(", "))));
    }
    InstructionSet::named(&name).ok_or_else(|| usage_error("simd", format!("this processor has no {name}")))
}

/// Parses `-epsilon E|auto`; `-robust` means `auto` unless a number is given.
fn epsilon(typed: &Typed) -> Result<Epsilon, Error> {
    if typed.values("epsilon").first().is_some_and(|value| *value == "auto") {
        return Ok(Epsilon::Auto);
    }
    let number =
        typed.number("epsilon", 0, "'auto' or a distance from 0 to 1e30", |e| (0.0..=1e30).contains(e))?;
    let unless_given = if typed.has("robust") { Epsilon::Auto } else { Epsilon::default() };
    Ok(number.map_or(unless_given, Epsilon::Along))
}

fn compare_options(typed: &Typed) -> Result<CompareOptions, Error> {
    typed.refuse_others("compare", &["diff", "report", "tolerance", "quiet"], "two pictures")?;
    let report = typed.path("report");
    if report.as_deref().is_some_and(is_standard) {
        return Err(usage_error("report", "with -compare, standard output has the verdict: expected a file name"));
    }
    let pictures = typed.values("compare");
    let (levels, percent) = ("a whole number of levels from 0 to 255", "a percentage from 0 to 100");
    Ok(CompareOptions {
        a: PathBuf::from(pictures[0]),
        b: PathBuf::from(pictures[1]),
        diff: typed.png_path("diff")?,
        report,
        levels: typed.number("tolerance", 0, levels, |_| true)?.unwrap_or(1),
        percent: typed.number("tolerance", 1, percent, |n| (0.0..=100.0).contains(n))?.unwrap_or(0.01),
    })
}

#[cfg(test)]
mod tests;
