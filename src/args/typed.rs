//! The flags and values as typed: `clap` splits the line, and its errors are put into this program's words.

use crate::error::{Error, probably_meant};
use crate::options::has_extension;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, ArgAction, ArgMatches};
use std::ffi::OsString;
use std::path::PathBuf;
use std::str::FromStr;

/// Help text: all differences of `-robust` from the starter.
const ROBUST_HELP: &str = "
With -robust, and without losing a digit of what the default gets right:
  - shadow and mirror rays start as far off a surface as its rounding asks for (-epsilon auto), not 0.01 along them
  - a plane's normal is shaded and shown as a unit vector, whatever its length in the scene
  - what is behind a light casts no shadow: the way to it is measured from where the shadow ray starts
  - a surface stands in the way of a light behind it: shadow rays start on the side that is seen
  - a mirror's smoothed normal sends no ray into the mirror: the normal of the face then takes its place
";

/// Name, value names, help.
type Flag = (&'static str, &'static [&'static str], &'static str);

pub(super) const FLAGS: &[Flag] = &[
    ("input", &["FILE"], "Scene file, name ends in .txt"),
    ("output", &["FILE"], "Colour picture: .png, or .pfm or .exr for numbers that are not rounded"),
    ("size", &["W", "H"], "Picture size in pixels [default: 100 100]"),
    (
        "depth",
        &["MIN", "MAX", "FILE"],
        "Depth picture (PNG): black at distance MIN, white at MAX; or auto FILE: finds them",
    ),
    (
        "depth-background",
        &["R", "G", "B"],
        "Colour of the depth picture where nothing is hit, 0 to 1 [default: black]",
    ),
    ("normals", &["FILE"], "Picture of the surface normals (PNG): (n + 1)/2 per component"),
    ("bounces", &["N"], "Depth of mirror recursion [default: 0]"),
    ("shadows", &[], "Trace shadow rays"),
    ("jitter", &[], "16 jittered samples per pixel"),
    ("samples", &["N"], "With random samples: so many per pixel [default: 16]; implies -jitter"),
    (
        "sampler",
        &["NAME"],
        "independent, stratified or sobol [default: stratified; with -target-error or -time-limit sobol]; implies \
         -jitter",
    ),
    ("filter", &[], "Render at 3 times the size, then filter down with a Gaussian"),
    (
        "epsilon",
        &["E"],
        "Shadow and mirror rays start E along them [default: 0.01], or auto: just off the surface",
    ),
    ("robust", &[], "Right at every scale, not the starter's shortcuts (listed below)"),
    (
        "pixel",
        &["X", "Y"],
        "Print how this pixel gets its colour; X from the left, Y from the top; can be repeated",
    ),
    ("cost", &["FILE"], "Picture of the rays, boxes and triangles that each pixel takes (PNG)"),
    (
        "plain",
        &[],
        "Render by the plain definition, one ray at a time: slower, same bytes; the first thing to try when a \
         picture looks wrong",
    ),
    ("threads", &["N"], "Worker threads [default: one per processor]"),
    ("seed", &["S"], "Seed of the random samples [default: 0]"),
    ("simd", &["NAME"], "Instruction set: sse2, avx2 or avx512, same pictures [default: the best here]"),
    ("stats", &[], "Table of times, rays, memory and estimated error on standard error"),
    ("report", &["FILE"], "The same as JSON; with -compare: what it found"),
    ("reference", &["FILE"], "Picture that counts as true (.png, .pfm, .exr): report the error against it"),
    ("error-map", &["FILE"], "Picture of the estimated error (PNG), white at 16 levels; implies -jitter"),
    (
        "convergence",
        &["FILE"],
        "Error against time and samples, each sampler: .svg, .html or .csv; implies -jitter",
    ),
    ("target-error", &["LEVELS"], "Sample where needed until the estimated RMSE is below; implies -jitter"),
    ("time-limit", &["SECONDS"], "Stop in time with the best picture so far; implies -jitter"),
    ("max-memory", &["SIZE"], "Refuse what needs more memory: bytes, or a number with K, M or G (powers of 1024)"),
    ("explain", &[], "Say on standard error what this scene needs and what is left out"),
    ("quiet", &[], "No progress bar and no warnings"),
    (
        "compare",
        &["A", "B"],
        "Compare two pictures instead: exit code 0 if alike, 1 if not, 2 if that cannot be told, 3 if sizes differ",
    ),
    ("diff", &["FILE"], "With -compare: write A, B and their differences side by side (PNG)"),
    (
        "tolerance",
        &["LEVELS", "PERCENT"],
        "With -compare: alike means at most LEVELS apart on all but PERCENT of the pixels [default: 1 0.01]",
    ),
    ("help", &[], "Print this help"),
    ("version", &[], "Print the version"),
];

/// Turns `-input` into `--input`, as clap expects it. Values (numbers, words, a single dash) stay as they are.
pub(super) fn with_two_dashes(typed: OsString) -> OsString {
    let Some(text) = typed.to_str() else {
        return typed;
    };
    match text.strip_prefix('-') {
        // clap does not take all of these for numbers: -.5, -1e-3.
        Some(number) if number.starts_with(|c: char| c == '.' || c.is_ascii_digit()) => {
            number.parse::<f64>().map_or(typed, |number| format!("-{number}").into())
        }
        Some(name) if name.starts_with(|c: char| c.is_ascii_alphabetic()) => format!("--{name}").into(),
        _ => typed,
    }
}

/// Makes the clap command of all flags. If a flag is given twice, the last one counts.
pub(super) fn command() -> clap::Command {
    let flag = |&(name, values, _): &Flag| {
        let arg = Arg::new(name).long(name);
        if values.is_empty() {
            // Counted, because a repeated switch is not an error.
            arg.action(ArgAction::Count)
        } else {
            let repeatable = if name == "pixel" { ArgAction::Append } else { ArgAction::Set };
            arg.action(repeatable)
                .num_args(values.len())
                .value_parser(clap::value_parser!(OsString))
                .allow_negative_numbers(true)
        }
    };
    clap::Command::new("a2")
        .no_binary_name(true)
        .disable_help_flag(true)
        .disable_version_flag(true)
        .args_override_self(true)
        .args(FLAGS.iter().map(flag))
}

/// Returns the text of `-help`.
pub(super) fn usage() -> String {
    let mut text = "Usage: a2 -input SCENE.txt -output PICTURE.png [flags]\n\n\
                    Renders a scene into PNG pictures of colour, depth and normals.\n\nFlags (one dash or two):\n"
        .to_owned();
    for (name, values, help) in FLAGS {
        let typed = format!("-{name} {}", values.join(" "));
        text += &format!("  {typed:<28} {help}\n");
    }
    text += ROBUST_HELP;
    text += "\nExample: a2 -input data/scene06_bunny_1k.txt -output out.png -size 300 300 -bounces 4\n";
    text
}

/// Puts an error of clap into this program's words.
pub(super) fn explained(error: &clap::Error) -> String {
    let context = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.clone()),
        Some(ContextValue::Strings(texts)) => texts.first().cloned(),
        _ => None,
    };
    let word = context(ContextKind::InvalidArg).unwrap_or_default();
    let name = word.trim_start_matches('-').split([' ', '=']).next().unwrap_or_default();
    let known = FLAGS.iter().find(|flag| flag.0 == name);
    match (error.kind(), known) {
        (ErrorKind::WrongNumberOfValues | ErrorKind::TooFewValues | ErrorKind::InvalidValue, Some(flag)) => {
            format!("-{name} needs {} value(s): -{name} {}", flag.1.len(), flag.1.join(" "))
        }
        (ErrorKind::TooManyValues, Some(_)) => format!("-{name} takes no value"),
        (ErrorKind::UnknownArgument, _) if word.starts_with('-') => {
            let meant = probably_meant(name, FLAGS.iter().map(|flag| flag.0));
            let hint = meant.map_or(String::new(), |flag| format!(" (did you mean -{flag}?)"));
            format!("unknown flag -{name}{hint}")
        }
        (ErrorKind::UnknownArgument, _) => format!("'{word}' belongs to no flag"),
        _ => error.to_string().trim_start_matches("error: ").trim_end().to_owned(),
    }
}

pub(super) fn usage_error(flag: &str, message: impl std::fmt::Display) -> Error {
    Error::Usage(format!("-{flag}: {message}"))
}

/// The flags and values as typed.
pub(super) struct Typed<'a>(pub(super) &'a ArgMatches);

impl Typed<'_> {
    pub(super) fn has(&self, flag: &str) -> bool {
        self.0.value_source(flag) == Some(clap::parser::ValueSource::CommandLine)
    }

    pub(super) fn values(&self, flag: &str) -> Vec<&OsString> {
        self.0.get_many(flag).map(Iterator::collect).unwrap_or_default()
    }

    pub(super) fn path(&self, flag: &str) -> Option<PathBuf> {
        self.values(flag).first().map(PathBuf::from)
    }

    /// Returns the path of a picture to write; its name must end in `.png`.
    pub(super) fn png_path(&self, flag: &str) -> Result<Option<PathBuf>, Error> {
        self.path(flag).map(|path| must_be_png(flag, path)).transpose()
    }

    /// Parses the `index`th value of a flag as a `T`. `accepts` says whether it is in range.
    pub(super) fn number<T: FromStr>(
        &self,
        flag: &str,
        index: usize,
        expected: &str,
        accepts: impl Fn(&T) -> bool,
    ) -> Result<Option<T>, Error> {
        let Some(value) = self.values(flag).get(index).copied() else {
            return Ok(None);
        };
        match value.to_str().and_then(|text| text.parse().ok()).filter(accepts) {
            Some(number) => Ok(Some(number)),
            None => {
                let message = format!("expected {expected}, found '{}'", value.to_string_lossy());
                Err(usage_error(flag, message))
            }
        }
    }
}

pub(super) fn must_be_png(flag: &str, path: PathBuf) -> Result<PathBuf, Error> {
    if has_extension(&path, "png") {
        return Ok(path);
    }
    let message = format!("expected a file name that ends in .png, found '{}'", path.display());
    Err(usage_error(flag, message))
}

/// Checks the name of the colour picture, which may also hold numbers instead of bytes.
pub(super) fn must_be_a_picture(path: PathBuf) -> Result<PathBuf, Error> {
    if ["pfm", "exr"].iter().any(|extension| has_extension(&path, extension)) {
        return must_be_supported("output", path);
    }
    must_be_png("output", path)
}

/// Refuses EXR pictures where the program is built without the feature `exr`.
pub(super) fn must_be_supported(flag: &str, path: PathBuf) -> Result<PathBuf, Error> {
    if cfg!(feature = "exr") || !has_extension(&path, "exr") {
        return Ok(path);
    }
    let message = format!("this build has no EXR support: give a .pfm instead of '{}'", path.display());
    Err(usage_error(flag, message))
}
