//! The command line: what was typed in, what is meant out.
//!
//! The flags are the course's single-dash long flags (`-input`); the double-dash spelling works too. `clap` splits the
//! line into flags and values; the values are judged here, so that every message names flag, value and expectation.

mod measuring;

pub use measuring::{DEFAULT_SAMPLES, MAX_SAMPLES, MeasureArgs};

use crate::accel::simd::Level;
use crate::error::{Error, probably_meant};
use crate::film::ExtraPlanes;
use crate::render::robust::Epsilon;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, ArgAction, ArgMatches};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// What the program is asked to do.
#[derive(Debug)]
pub enum Request {
    /// Print this text and end well.
    Print(String),
    /// No arguments: print this text and end with exit code 1, as the starter does.
    PrintUsage(String),
    Render(Box<RenderArgs>),
    Compare(CompareArgs),
}

/// Render a scene.
#[derive(Clone, Debug)]
pub struct RenderArgs {
    pub input: PathBuf,
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
    /// `None`: as many as the machine has.
    pub threads: Option<usize>,
    pub seed: u64,
    pub quiet: bool,
    /// The processor level at which rays are culled.
    pub simd: Level,
    /// Print the plan.
    pub explain: bool,
    pub measure: MeasureArgs,
}

impl RenderArgs {
    /// Samples a pixel of the traced grid.
    pub fn samples(&self) -> u32 {
        if self.jitter { self.measure.samples.unwrap_or(DEFAULT_SAMPLES) } else { 1 }
    }

    /// Whether the colour picture's file is to hold numbers instead of bytes.
    pub fn color_is_numbers(&self) -> bool {
        self.color.as_ref().is_some_and(|path| !has_extension(path, "png"))
    }

    pub fn extra_planes(&self) -> ExtraPlanes {
        let measure = &self.measure;
        let linear = self.color_is_numbers() || measure.reference.is_some() || measure.keep_linear;
        ExtraPlanes { linear: linear && self.color.is_some(), error_map: measure.error_map.is_some() }
    }

    /// Pixels of the traced grid a pixel of the picture.
    pub fn grid_pixels(&self) -> u32 {
        if self.filter { 9 } else { 1 }
    }
}

/// `-depth MIN MAX FILE`
#[derive(Clone, Debug, PartialEq)]
pub struct DepthPicture {
    pub min: f64,
    pub max: f64,
    pub path: PathBuf,
}

/// `-compare A B`
#[derive(Clone, Debug)]
pub struct CompareArgs {
    pub a: PathBuf,
    pub b: PathBuf,
    pub diff: Option<PathBuf>,
    /// Two pixels are alike when no channel differs by more levels than this.
    pub levels: u8,
    /// Percentage of pixels that may be unlike.
    pub percent: f64,
}

/// Largest width and height of a picture.
const MAX_SIDE: u32 = 65_536;
/// Largest number of pixels: at three bytes each, memory for one such picture is at hand everywhere.
const MAX_PIXELS: u64 = 1 << 28;
const MAX_BOUNCES: u32 = 100_000;
const MAX_THREADS: usize = 1024;

/// Every way in which `-robust` departs from the starter.
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

const FLAGS: &[Flag] = &[
    ("input", &["FILE"], "Scene file, name ends in .txt"),
    ("output", &["FILE"], "Colour picture: .png, or .pfm or .exr for numbers that are not rounded"),
    ("size", &["W", "H"], "Picture size in pixels [default: 100 100]"),
    ("depth", &["MIN", "MAX", "FILE"], "Depth picture (PNG): black at distance MIN, white at MAX"),
    ("normals", &["FILE"], "Picture of the surface normals (PNG): (n + 1)/2 per component"),
    ("bounces", &["N"], "Depth of mirror recursion [default: 0]"),
    ("shadows", &[], "Trace shadow rays"),
    ("jitter", &[], "16 jittered samples per pixel"),
    ("samples", &["N"], "With random samples: so many per pixel [default: 16]; implies -jitter"),
    ("sampler", &["NAME"], "independent, stratified or sobol [default: stratified]; implies -jitter"),
    ("filter", &[], "Render at 3 times the size, then filter down with a Gaussian"),
    (
        "epsilon",
        &["E"],
        "Shadow and mirror rays start E along them [default: 0.01], or auto: just off the surface",
    ),
    ("robust", &[], "Right at every scale, not the starter's shortcuts (listed below)"),
    ("threads", &["N"], "Worker threads [default: one per processor]"),
    ("seed", &["S"], "Seed of the random samples [default: 0]"),
    ("simd", &["LEVEL"], "scalar or avx2, same pictures [default: the best this processor has]"),
    ("stats", &[], "Table of times, rays, memory and estimated error on standard error"),
    ("report", &["FILE"], "The same as JSON; with either, samples are taken in two independent halves"),
    ("reference", &["FILE"], "Picture that counts as true (.png, .pfm, .exr): report the error against it"),
    ("error-map", &["FILE"], "Picture of the estimated error (PNG), white at 16 levels; implies -jitter"),
    ("convergence", &["FILE"], "Table (CSV) of error against samples 1, 2, 4 ... N; implies -jitter"),
    ("target-error", &["LEVELS"], "Sample where needed until the estimated RMSE is below; implies -jitter"),
    ("time-limit", &["SECONDS"], "Stop in time with the best picture so far; implies -jitter"),
    ("explain", &[], "Say on standard error what this scene needs and what is left out"),
    ("quiet", &[], "No progress bar and no warnings"),
    ("compare", &["A", "B"], "Compare two pictures instead: exit code 0 if alike, 1 if not"),
    ("diff", &["FILE"], "With -compare: write the differences as a picture (PNG)"),
    (
        "tolerance",
        &["LEVELS", "PERCENT"],
        "With -compare: alike means at most LEVELS apart on all but PERCENT of the pixels [default: 1 0.01]",
    ),
    ("help", &[], "Print this help"),
    ("version", &[], "Print the version"),
];

/// Understands a command line, program name not included.
///
/// # Errors
/// [`Error::Usage`] for a command line that makes no sense.
pub fn parse(argv: impl IntoIterator<Item = OsString>) -> Result<Request, Error> {
    let argv: Vec<OsString> = argv.into_iter().map(with_two_dashes).collect();
    if argv.is_empty() {
        return Ok(Request::PrintUsage(usage()));
    }
    let matches = command().try_get_matches_from(argv).map_err(|error| Error::Usage(explained(&error)))?;
    let typed = Typed(&matches);
    if typed.has("help") {
        return Ok(Request::Print(usage()));
    }
    if typed.has("version") {
        return Ok(Request::Print(format!("a2 {}\n", env!("CARGO_PKG_VERSION"))));
    }
    if typed.has("compare") {
        return compare_args(&typed).map(Request::Compare);
    }
    for only_with_compare in ["diff", "tolerance"] {
        if typed.has(only_with_compare) {
            return Err(usage_error(only_with_compare, "goes with -compare only"));
        }
    }
    render_args(&typed).map(|args| Request::Render(Box::new(args)))
}

/// `-input` as clap knows it: `--input`. Values (numbers, single letters, a lone dash) stay as they are.
fn with_two_dashes(typed: OsString) -> OsString {
    let Some(text) = typed.to_str() else {
        return typed;
    };
    match text.strip_prefix('-') {
        Some(name) if name.starts_with(|c: char| c.is_ascii_alphabetic()) => format!("--{name}").into(),
        _ => typed,
    }
}

fn command() -> clap::Command {
    let flag = |&(name, values, _): &Flag| {
        let arg = Arg::new(name).long(name);
        if values.is_empty() {
            // A repeated switch is no error: counting swallows it.
            arg.action(ArgAction::Count)
        } else {
            arg.action(ArgAction::Set)
                .num_args(values.len())
                .value_names(values)
                .value_parser(clap::value_parser!(OsString))
                .allow_negative_numbers(true)
                .overrides_with(name)
        }
    };
    clap::Command::new("a2")
        .no_binary_name(true)
        .disable_help_flag(true)
        .disable_version_flag(true)
        .args(FLAGS.iter().map(flag))
}

/// The text of `-help`.
fn usage() -> String {
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

/// clap's refusal in this program's words.
fn explained(error: &clap::Error) -> String {
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

fn usage_error(flag: &str, message: impl std::fmt::Display) -> Error {
    Error::Usage(format!("-{flag}: {message}"))
}

/// The flags and values as typed.
struct Typed<'a>(&'a ArgMatches);

impl Typed<'_> {
    fn has(&self, flag: &str) -> bool {
        self.0.value_source(flag) == Some(clap::parser::ValueSource::CommandLine)
    }

    fn values(&self, flag: &str) -> Vec<&OsString> {
        self.0.get_many(flag).map(Iterator::collect).unwrap_or_default()
    }

    fn path(&self, flag: &str) -> Option<PathBuf> {
        self.values(flag).first().map(PathBuf::from)
    }

    /// A picture to be written, which must be a PNG by its name.
    fn png_path(&self, flag: &str) -> Result<Option<PathBuf>, Error> {
        self.path(flag).map(|path| must_be_png(flag, path)).transpose()
    }

    /// The `index`th value of a flag as a `T` that `accepts` likes.
    fn number<T: FromStr>(
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

fn must_be_png(flag: &str, path: PathBuf) -> Result<PathBuf, Error> {
    if has_extension(&path, "png") {
        return Ok(path);
    }
    let message = format!("expected a file name that ends in .png, found '{}'", path.display());
    Err(usage_error(flag, message))
}

/// The colour picture may also hold numbers instead of bytes.
fn must_be_a_picture(path: PathBuf) -> Result<PathBuf, Error> {
    if ["pfm", "exr"].iter().any(|extension| has_extension(&path, extension)) {
        return Ok(path);
    }
    must_be_png("output", path)
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

fn render_args(typed: &Typed) -> Result<RenderArgs, Error> {
    let input = typed.path("input").ok_or_else(|| Error::Usage("-input is missing: which scene?".into()))?;
    if !has_extension(&input, "txt") {
        let message = format!("expected a file name that ends in .txt, found '{}'", input.display());
        return Err(usage_error("input", message));
    }
    let side = |index| {
        let expected = format!("two whole numbers from 1 to {MAX_SIDE}");
        typed.number("size", index, &expected, |n: &u32| (1..=MAX_SIDE).contains(n))
    };
    let bounces = format!("a whole number from 0 to {MAX_BOUNCES}");
    let threads = format!("a whole number from 1 to {MAX_THREADS}");
    let args = RenderArgs {
        input,
        color: typed.path("output").map(must_be_a_picture).transpose()?,
        depth: depth_picture(typed)?,
        normals: typed.png_path("normals")?,
        width: side(0)?.unwrap_or(100),
        height: side(1)?.unwrap_or(100),
        bounces: typed.number("bounces", 0, &bounces, |n| *n <= MAX_BOUNCES)?.unwrap_or(0),
        shadows: typed.has("shadows"),
        jitter: measuring::jitter(typed),
        filter: typed.has("filter"),
        epsilon: epsilon(typed)?,
        robust: typed.has("robust"),
        threads: typed.number("threads", 0, &threads, |n| (1..=MAX_THREADS).contains(n))?,
        seed: typed.number("seed", 0, "a whole number from 0 to 2^64 - 1", |_| true)?.unwrap_or(0),
        quiet: typed.has("quiet"),
        simd: simd_level(typed)?,
        explain: typed.has("explain"),
        measure: MeasureArgs::new(typed)?,
    };
    let pixels = u64::from(args.width) * u64::from(args.height);
    if pixels > MAX_PIXELS {
        return Err(usage_error("size", format!("expected at most {MAX_PIXELS} pixels in all, found {pixels}")));
    }
    if let (Some(flag), None) = (args.measure.needs_color(), &args.color) {
        return Err(usage_error(flag, "is about colours: give -output too"));
    }
    let pictures = [args.color.as_ref(), args.depth.as_ref().map(|depth| &depth.path), args.normals.as_ref()];
    let pictures: Vec<_> = pictures.into_iter().flatten().collect();
    if pictures.is_empty() {
        let message = "no picture is asked for: give -output, -depth or -normals";
        return Err(Error::Usage(message.into()));
    }
    let files: Vec<_> = pictures.into_iter().chain(args.measure.outputs().into_iter().flatten()).collect();
    if (1..files.len()).any(|i| files[..i].contains(&files[i])) {
        return Err(Error::Usage("two pictures have the same file name".into()));
    }
    Ok(args)
}

fn simd_level(typed: &Typed) -> Result<Level, Error> {
    let Some(name) = typed.values("simd").first().copied() else {
        return Ok(Level::detected());
    };
    let name = name.to_string_lossy();
    if !Level::NAMES.contains(&&*name) {
        return Err(usage_error("simd", format!("expected {}, found '{name}'", Level::NAMES.join(" or "))));
    }
    Level::named(&name).ok_or_else(|| usage_error("simd", format!("this processor has no {name}")))
}

fn depth_picture(typed: &Typed) -> Result<Option<DepthPicture>, Error> {
    let expected = "two finite numbers and a file name";
    let (min, max) = (
        typed.number("depth", 0, expected, |n: &f64| n.is_finite())?,
        typed.number("depth", 1, expected, |n: &f64| n.is_finite())?,
    );
    let (Some(min), Some(max), Some(path)) = (min, max, typed.values("depth").get(2).map(PathBuf::from)) else {
        return Ok(None);
    };
    let path = must_be_png("depth", path)?;
    Ok(Some(DepthPicture { min, max, path }))
}

/// `-epsilon E|auto`; `-robust` means `auto` unless a number is given.
fn epsilon(typed: &Typed) -> Result<Epsilon, Error> {
    if typed.values("epsilon").first().is_some_and(|value| *value == "auto") {
        return Ok(Epsilon::Auto);
    }
    let number =
        typed.number("epsilon", 0, "'auto' or a distance from 0 to 1e30", |e| (0.0..=1e30).contains(e))?;
    let unless_given = if typed.has("robust") { Epsilon::Auto } else { Epsilon::default() };
    Ok(number.map_or(unless_given, Epsilon::Along))
}

fn compare_args(typed: &Typed) -> Result<CompareArgs, Error> {
    const ALLOWED: [&str; 4] = ["compare", "diff", "tolerance", "quiet"];
    if let Some((other, ..)) = FLAGS.iter().find(|flag| typed.has(flag.0) && !ALLOWED.contains(&flag.0)) {
        return Err(usage_error(other, "does not go with -compare"));
    }
    let pictures = typed.values("compare");
    let (levels, percent) = ("a whole number of levels from 0 to 255", "a percentage from 0 to 100");
    Ok(CompareArgs {
        a: PathBuf::from(pictures[0]),
        b: PathBuf::from(pictures[1]),
        diff: typed.png_path("diff")?,
        levels: typed.number("tolerance", 0, levels, |_| true)?.unwrap_or(1),
        percent: typed.number("tolerance", 1, percent, |n| (0.0..=100.0).contains(n))?.unwrap_or(0.01),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(line: &str) -> Result<Request, Error> {
        parse(line.split_whitespace().map(OsString::from))
    }

    fn render(line: &str) -> RenderArgs {
        match parsed(line) {
            Ok(Request::Render(args)) => *args,
            other => panic!("{line}: {other:?}"),
        }
    }

    fn refusal(line: &str) -> String {
        match parsed(line) {
            Err(Error::Usage(message)) => message,
            other => panic!("{line}: {other:?}"),
        }
    }

    #[test]
    fn one_dash_and_two_mean_the_same_in_any_order() {
        for line in [
            "-input s.txt -output o.png -size 30 20 -bounces 4 -shadows",
            "--shadows --bounces 4 --size 30 20 --output o.png --input s.txt",
        ] {
            let args = render(line);
            assert_eq!((args.width, args.height, args.bounces, args.shadows), (30, 20, 4, true));
            assert!(!args.jitter && !args.filter && args.depth.is_none());
        }
    }

    #[test]
    fn the_last_one_of_a_repeated_flag_counts() {
        let args = render("-input s.txt -input t.txt -output o.png -size 1 2 -size 3 4 -jitter -jitter");
        assert_eq!((args.input, args.width, args.height), (PathBuf::from("t.txt"), 3, 4));
    }

    #[test]
    fn depth_may_be_negative_and_inverted() {
        let args = render("-input s.txt -depth 1 -1.5e3 d.png");
        assert_eq!(args.depth.unwrap(), DepthPicture { min: 1.0, max: -1500.0, path: "d.png".into() });
    }

    #[test]
    fn robust_rays_start_just_off_the_surface_unless_a_distance_is_given() {
        let epsilon = |flags: &str| render(&format!("-input s.txt -output o.png {flags}")).epsilon;
        assert_eq!(epsilon(""), Epsilon::Along(0.01));
        assert_eq!(epsilon("-robust"), Epsilon::Auto);
        assert_eq!(epsilon("-epsilon auto"), Epsilon::Auto);
        assert_eq!(epsilon("-epsilon 1e-4 -robust"), Epsilon::Along(1e-4));
        assert!(render("-input s.txt -output o.png -robust").robust);
    }

    #[test]
    fn nonsense_names_flag_value_and_expectation() {
        for (line, parts) in [
            ("-input s.txt", &["-output", "-depth"] as &[_]),
            ("-output o.png", &["-input"]),
            ("-input s.txt -output o.jpg", &["-output", ".png", "o.jpg"]),
            ("-input s.obj -output o.png", &["-input", ".txt", "s.obj"]),
            ("-input s.txt -output o.png -size 0 5", &["-size", "'0'", "from 1 to 65536"]),
            ("-input s.txt -output o.png -size 65536 65536", &["-size", "at most 268435456 pixels"]),
            ("-input s.txt -output o.png -size 5", &["-size", "W H"]),
            ("-input s.txt -output o.png -size 5 -shadows", &["-size", "W H"]),
            ("-input s.txt -output o.png -bounces -1", &["-bounces", "'-1'"]),
            ("-input s.txt -output o.png -bounces 2.5", &["-bounces", "'2.5'"]),
            ("-input s.txt -output o.png -bouncse 2", &["-bouncse", "did you mean -bounces"]),
            ("-input s.txt -output o.png stray", &["'stray'"]),
            ("-input s.txt -depth nan 1 d.png", &["-depth", "'nan'"]),
            ("-input s.txt -output o.png -depth 0 1 o.png", &["same file name"]),
            ("-input s.txt -output o.png -threads 0", &["-threads", "'0'"]),
            ("-input s.txt -output o.png -epsilon -1", &["-epsilon", "'-1'", "auto"]),
            ("-input s.txt -output o.png -epsilon nan", &["-epsilon", "'nan'"]),
            ("-input s.txt -output o.png -simd mmx", &["-simd", "scalar or avx2", "'mmx'"]),
            ("-input s.txt -output o.png -seed -3", &["-seed", "'-3'"]),
            ("-input s.txt -output o.png -diff d.png", &["-diff", "-compare"]),
            ("-compare a.png b.png -size 3 3", &["-size", "-compare"]),
            ("-compare a.png", &["-compare", "A B"]),
            ("-compare a.png b.png -tolerance 300 1", &["-tolerance", "'300'"]),
        ] {
            let message = refusal(line);
            for part in parts {
                assert!(message.contains(part), "{line}: '{part}' is not in: {message}");
            }
        }
    }

    #[test]
    fn help_names_every_flag() {
        let Ok(Request::Print(help)) = parsed("-help") else { panic!() };
        for (name, ..) in FLAGS {
            assert!(help.contains(&format!("-{name} ")), "{name}");
        }
    }
}
