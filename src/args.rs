//! The command line: what was typed in, what is meant out.
//!
//! The flags are the course's single-dash long flags (`-input`); the double-dash spelling works too. `clap` splits the
//! line into flags and values; the values are judged here, so that every message names flag, value and expectation.

mod measuring;
mod typed;

pub use measuring::{DEFAULT_SAMPLES, MAX_SAMPLES, MeasureArgs};

use crate::accel::simd::Level;
use crate::error::Error;
use crate::film::ExtraPlanes;
use crate::render::robust::Epsilon;
use std::ffi::OsString;
use std::path::PathBuf;
use typed::{
    FLAGS, Typed, command, explained, has_extension, must_be_a_picture, must_be_png, usage, usage_error,
    with_two_dashes,
};

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
        return Err(Error::Usage("two files have the same name".into()));
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
            ("-input s.txt -output o.png -depth 0 1 o.png", &["same name"]),
            ("-input s.txt -output o.png -threads 0", &["-threads", "'0'"]),
            ("-input s.txt -output o.png -epsilon -1", &["-epsilon", "'-1'", "auto"]),
            ("-input s.txt -output o.png -epsilon nan", &["-epsilon", "'nan'"]),
            ("-input s.txt -output o.png -simd mmx", &["-simd", "scalar or avx2", "'mmx'"]),
            ("-input s.txt -output o.png -seed -3", &["-seed", "'-3'"]),
            ("-input s.txt -output o.png -diff d.png", &["-diff", "-compare"]),
            ("-input s.txt -output o.png -samples 0", &["-samples", "'0'", "from 1 to 65536"]),
            (
                "-input s.txt -output o.png -sampler halton",
                &["-sampler", "independent, stratified, sobol", "'halton'"],
            ),
            ("-input s.txt -output o.png -target-error 0", &["-target-error", "above 0", "'0'"]),
            ("-input s.txt -output o.png -time-limit nan", &["-time-limit", "above 0", "'nan'"]),
            ("-input s.txt -output o.png -report r.txt", &["-report", ".json", "r.txt"]),
            ("-input s.txt -output o.png -reference r.jpg", &["-reference", ".png, .pfm, .exr", "r.jpg"]),
            ("-input s.txt -normals o.png -target-error 1", &["-target-error", "-output"]),
            ("-input s.txt -output o.png -error-map o.png", &["same name"]),
            ("-input s.txt -output o.png -convergence c.csv -time-limit 1", &["-convergence", "-time-limit"]),
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
    fn flags_about_random_samples_imply_jitter() {
        for flags in ["-samples 4", "-sampler sobol", "-target-error 1", "-time-limit 2", "-error-map e.png"] {
            assert!(render(&format!("-input s.txt -output o.png {flags}")).jitter, "{flags}");
        }
        for flags in ["-stats", "-report r.json", "-reference r.pfm", "-seed 3"] {
            assert!(!render(&format!("-input s.txt -output o.png {flags}")).jitter, "{flags}");
        }
        let sampler = |flags: &str| render(&format!("-input s.txt -output o.png {flags}")).measure.sampler;
        assert_eq!(sampler("-jitter"), crate::render::SamplerKind::Stratified);
        assert_eq!(sampler("-target-error 1"), crate::render::SamplerKind::Sobol);
    }

    #[test]
    fn help_names_every_flag() {
        let Ok(Request::Print(help)) = parsed("-help") else { panic!() };
        for (name, ..) in FLAGS {
            assert!(help.contains(&format!("-{name} ")), "{name}");
        }
    }
}
