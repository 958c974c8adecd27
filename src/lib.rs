//! A command-line ray tracer: a text scene in; PNG pictures of colour, depth and normals out.
//!
//! The modules in the order in which data flows through them:
//!
//! 1. [`args`]: the command line;
//! 2. [`scene`]: the text of a scene file, as written and then as rays meet it;
//! 3. [`plan`]: what the pictures that were asked for need of the scene;
//! 4. [`objects`], [`accel`], [`camera`], [`light`], [`material`], [`cube_map`]: what a scene is made of;
//! 5. [`render`]: the pictures' pixels, ray by ray ([`render::trace`] is the heart of it);
//! 6. [`film`]: bytes and files.
//!
//! [`measure`] stands beside: how much pictures differ, and what the work cost.
#![deny(unsafe_code)]
// Read with --document-private-items: this is a program first.
#![allow(rustdoc::private_intra_doc_links, rustdoc::redundant_explicit_links)]

pub mod accel;
pub mod args;
pub mod camera;
pub mod cube_map;
pub mod error;
pub mod film;
pub mod light;
pub mod material;
pub mod measure;
pub mod objects;
pub mod options;
pub mod plan;
mod progress;
pub mod ray_counts;
pub mod render;
pub mod scene;
pub mod scene_file;
pub mod timing;

use args::Request;
use error::Error;
use film::Film;
use measure::{Phases, Point, Reference, Report, TrueError};
use options::{CompareOptions, Options};
use plan::Plan;
use ray_counts::RayCounts;
use rayon::prelude::*;
use render::error_estimate::ErrorEstimate;
use render::{Frame, SampleCounts};

use scene::{Compiled, compile};
use std::ffi::OsString;
use std::io::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};
use timing::{Stopwatch, Times};

/// What a run has to say, and how it ended.
#[derive(Debug)]
pub struct Outcome {
    /// For standard output.
    pub text: String,
    pub exit_code: u8,
}

/// Does what a command line (without the program's name) asks for.
///
/// # Errors
/// [`Error`], to be shown to the user; its exit code goes with it. Comparing pictures has its own: 2.
pub fn run(argv: impl IntoIterator<Item = OsString>) -> Result<Outcome, (Error, u8)> {
    let with_code = |error: Error| {
        let code = error.exit_code();
        (error, code)
    };
    match args::parse(argv).map_err(with_code)? {
        Request::Print(text) => Ok(Outcome { text, exit_code: 0 }),
        Request::PrintUsage(text) => Ok(Outcome { text, exit_code: 1 }),
        Request::Compare(args) => compare(&args).map_err(|error| (error, 2)),
        Request::Render(args) => {
            render_to_files(&args).map_err(with_code)?;
            Ok(Outcome { text: String::new(), exit_code: 0 })
        }
    }
}

fn compare(args: &CompareOptions) -> Result<Outcome, Error> {
    let comparison = measure::compare_files(args)?;
    let alike = comparison.percent_over(args.levels) <= args.percent;
    let verdict = if alike { "alike" } else { "different" };
    let text = format!("{comparison}{verdict}: at most {} level(s) on all but {}%\n", args.levels, args.percent);
    Ok(Outcome { text, exit_code: u8::from(!alike) })
}

/// The pictures of a scene, and what they cost.
#[derive(Debug)]
pub struct Rendered {
    /// The pictures.
    pub film: Film,
    /// The rays traced for them.
    pub counts: RayCounts,
    /// Cube map faces that had to be decoded.
    pub decoded_faces: usize,
    /// What the scene's author should know.
    pub warnings: Vec<String>,
    /// What was not done, a sentence each.
    pub left_out: Vec<String>,
    pub phases: Phases,
    pub sampling: SampleCounts,
    /// How wrong the colours are, where the samples tell it.
    pub estimate: Option<ErrorEstimate>,
    pub true_error: Option<TrueError>,
    /// With `-convergence`.
    pub convergence: Vec<Point>,
}

/// Renders the pictures that `args` asks for, in memory. A time limit counts from here.
///
/// # Errors
/// Whatever is wrong with the scene or a file that it names.
pub fn render_scene(args: &Options) -> Result<Rendered, Error> {
    let deadline = deadline(args);
    let mut phases = Phases::default();
    let reference = args.measure.reference.as_ref().map(|path| Reference::read(path, args.width, args.height));
    let reference = reference.transpose()?;
    let watch = Stopwatch::start();
    let description = scene_file::parse_file(&args.input)?;
    let plan = Plan::new(args, &description);
    phases.parse = watch.times();
    if args.explain {
        say(&plan.explain(args));
    }
    let watch = Stopwatch::start();
    let Compiled { scene, warnings, build } = compile(&description, &plan)?;
    drop(description);
    phases.build = build;
    phases.load = watch.times().without(build);
    let progress = progress::Bar::new(args.quiet);
    let watch = Stopwatch::start();
    let mut points = Vec::new();
    let frame: Frame;
    if args.measure.is_adaptive() {
        frame = render::render_adaptive(&scene, &plan, args, deadline, &progress);
    } else if args.measure.convergence.is_some() {
        (frame, points) = measure::render_doubling(&scene, &plan, args, reference.as_ref(), &progress);
    } else {
        frame = render::render_uniform(&scene, &plan, args, &progress);
    }
    let filter = frame.filter;
    phases.filter = Times { wall: filter / rayon::current_num_threads() as u32, cpu: filter };
    phases.render = watch.times().without(phases.filter);
    let cube_map = scene.background.cube_map.as_ref();
    cube_map.map_or(Ok(()), cube_map::CubeMap::check_decoded_faces)?;
    let decoded_faces = cube_map.map_or(0, cube_map::CubeMap::decoded_faces);
    let true_error = reference.and_then(|reference| reference.error_of(&frame.film));
    Ok(Rendered {
        estimate: frame.estimate,
        film: frame.film,
        counts: frame.counts,
        decoded_faces,
        warnings,
        left_out: plan.left_out,
        phases,
        sampling: frame.samples,
        true_error,
        convergence: points,
    })
}

/// When to stop tracing rays, so that there is time left to write the pictures.
fn deadline(args: &Options) -> Option<Instant> {
    /// A slow disk, and a PNG that does not compress.
    const BYTES_A_SECOND: f64 = 60e6;
    /// What cannot be interrupted: the rays under way, starting and ending threads.
    const MARGIN: f64 = 0.01;
    let limit = args.measure.time_limit?;
    let planes = [args.color.is_some(), args.normals.is_some(), args.depth.is_some()];
    let bytes = planes.iter().filter(|wanted| **wanted).count() as f64
        * 3.0
        * f64::from(args.width)
        * f64::from(args.height)
        * if args.color_is_numbers() { 4.0 } else { 1.0 };
    let seconds = (limit - bytes / BYTES_A_SECOND - MARGIN).max(0.0);
    // A limit beyond the clock's range is none.
    Instant::now().checked_add(Duration::try_from_secs_f64(seconds).ok()?)
}

/// Writes to standard error. That nobody reads it is no reason to fail.
fn say(text: &str) {
    let _ = std::io::stderr().write_all(text.as_bytes());
}

fn render_to_files(args: &Options) -> Result<(), Error> {
    let total = Stopwatch::start();
    let depth_path = args.depth.as_ref().map(|depth| depth.path.as_path());
    let pictures = [args.color.as_deref(), args.normals.as_deref(), depth_path];
    let measure = &args.measure;
    let others = [measure.error_map.as_deref(), measure.report.as_deref(), measure.convergence.as_deref()];
    for path in pictures.into_iter().chain(others).flatten() {
        film::check_writable(path)?;
    }
    let threads = args.threads.unwrap_or(0);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Error::Refused(format!("cannot start the worker threads: {error}")))?;
    pool.install(|| {
        let mut rendered = render_scene(args)?;
        if !args.quiet {
            for warning in &rendered.warnings {
                say(&format!("warning: {warning}\n"));
            }
        }
        if args.explain {
            say(&format!("{}cube map faces decoded: {}\n", rendered.counts, rendered.decoded_faces));
        }
        let watch = Stopwatch::start();
        write_pictures(args, &rendered.film)?;
        rendered.phases.encode = watch.times();
        write_findings(args, rendered, &total)
    })
}

fn write_pictures(args: &Options, film: &Film) -> Result<(), Error> {
    if let (Some(path), Some(numbers), true) = (&args.color, &film.linear, args.color_is_numbers()) {
        film::write_numbers(path, film.width, film.height, numbers)?;
    }
    let planes: [(Option<&Path>, &Option<Vec<u8>>); 4] = [
        (args.color.as_deref().filter(|_| !args.color_is_numbers()), &film.color),
        (args.normals.as_deref(), &film.normals),
        (args.depth.as_ref().map(|depth| depth.path.as_path()), &film.depth),
        (args.measure.error_map.as_deref(), &film.error_map),
    ];
    planes.into_par_iter().try_for_each(|(path, plane)| match (path, plane) {
        (Some(path), Some(bytes)) => film::write_png(path, film.width, film.height, bytes),
        _ => Ok(()),
    })
}

/// What was measured, where it was asked for.
fn write_findings(args: &Options, rendered: Rendered, total: &Stopwatch) -> Result<(), Error> {
    let measure = &args.measure;
    let write_text =
        |path: &Path, text: &str| film::write_whole(path, "the file", |file| file.write_all(text.as_bytes()));
    if let Some(path) = &measure.convergence {
        write_text(path, &measure::csv(args, &rendered.convergence))?;
    }
    let report = Report {
        args,
        threads: rayon::current_num_threads(),
        phases: rendered.phases,
        total: total.times(),
        counts: rendered.counts,
        decoded_faces: rendered.decoded_faces,
        left_out: &rendered.left_out,
        sampling: rendered.sampling,
        estimate: rendered.estimate,
        true_error: rendered.true_error,
    };
    if let Some(path) = &measure.report {
        write_text(path, &report.json())?;
    }
    if measure.stats {
        say(&report.table());
    } else if !args.quiet {
        if measure.is_adaptive() {
            say(&report.verdict());
        }
        if let (Some(error), None) = (&report.true_error, &measure.report) {
            say(&error.to_string());
        }
    }
    let missed = measure.target_error.filter(|&target| !report.is_below(target));
    if let (Some(target), false) = (missed, args.quiet) {
        say(&format!("warning: the target error of {target} levels was not reached\n"));
    }
    Ok(())
}
