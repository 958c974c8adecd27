//! A command-line ray tracer: a text scene in; PNG pictures of colour, depth and normals out.
//!
//! The modules in the order in which data flows through them:
//!
//! 1. [`args`]: the command line becomes [`options`];
//! 2. [`scene_file`]: the text of a scene, as written;
//! 3. [`plan`]: what the wanted pictures need of the scene;
//! 4. [`objects`], [`camera`], [`light`], [`material`], [`cube_map`]: what a scene is made of, one ray at a time;
//! 5. [`scene`]: what rays meet, with the trees of [`bvh`];
//! 6. [`mod@trace`]: what one ray sees, which is the definition of the picture. **Begin reading there.**
//! 7. [`wide`]: the same, 64 rays at a time, in the lanes of [`simd`];
//! 8. [`render`]: which rays, and what becomes of what they see;
//! 9. [`film`]: bytes and files.
//!
//! [`mod@inspect`] shows how single pixels get their colours. [`measure`] computes errors and costs of pictures.
#![forbid(unsafe_code)]
// Read with --document-private-items: this is a program first.
#![allow(rustdoc::private_intra_doc_links, rustdoc::redundant_explicit_links)]

pub mod args;
pub mod bvh;
pub mod camera;
mod check;
pub mod cost;
pub mod cube_map;
pub mod error;
mod file_kind;
pub mod file_path;
pub mod film;
pub mod hints;
pub mod input;
pub mod inspect;
pub mod interrupt;
pub mod light;
pub mod material;
pub mod measure;
pub mod memory;
pub mod merge;
pub mod objects;
pub mod options;
pub mod output;
pub mod part;
pub mod picture_file;
pub mod plan;
mod progress;
pub mod ray_counts;
pub mod ray_offset;
pub mod render;
pub mod scene;
pub mod scene_file;
pub mod simd;
mod threads;
pub mod timing;
pub mod trace;
pub mod wide;
mod write;

use args::Request;
use cost::Cost;
use error::{Error, counted};
use film::{BandWriter, PictureWriter};
use inspect::inspect;
use measure::{Convergence, Phases, Reference, Report};
use memory::Budget;
use options::{CompareOptions, Options};
use output::{OutputFile, say};
use plan::Plan;
use progress::Shown;
use render::Frame;
use scene::{Compiled, MeshFile, Scene, compile, without_mistakes};
use scene_file::Description;
use std::ffi::OsString;
use std::io::{IsTerminal, stderr};
use std::path::PathBuf;
use timing::{Deadline, Stopwatch, Times, timed};

/// The output and the exit code of a run.
#[derive(Debug)]
pub struct Outcome {
    /// For standard output.
    pub text: String,
    pub exit_code: u8,
    /// The exit code where the text cannot be printed.
    pub if_not_printed: u8,
}

impl Outcome {
    fn new(text: String, exit_code: u8) -> Self {
        Self { text, exit_code, if_not_printed: 1 }
    }
}

/// The exit code of a run whose pictures are written, but whose target error or some of whose pixels were not reached.
pub const INCOMPLETE: u8 = 3;

/// Runs a command line, without the program's name.
///
/// # Errors
/// [`Error`], to be shown to the user, with its exit code.
pub fn run(argv: impl IntoIterator<Item = OsString>) -> Result<Outcome, (Error, u8)> {
    let with_code = |error: Error| {
        let code = error.exit_code();
        (error, code)
    };
    let request = args::parse(argv).map_err(with_code)?;
    threads::with_a_large_stack(|| match request {
        Request::Print(text) => Ok(Outcome::new(text, 0)),
        Request::PrintUsage(text) => {
            say(&text);
            Ok(Outcome::new(String::new(), 2))
        }
        Request::Compare(options) => compare(&options),
        Request::Merge(options) => {
            merge::merge(&options).map_err(with_code)?;
            Ok(Outcome::new(String::new(), 0))
        }
        Request::Render(options) if options.check => {
            let (description, plan) = parse(&options).map_err(with_code)?;
            let text = check::check(&description, &plan, &options).map_err(with_code)?;
            Ok(Outcome::new(text, 0))
        }
        Request::Render(options) => render_to_files(&options).map_err(with_code),
    })
}

fn compare(options: &CompareOptions) -> Result<Outcome, (Error, u8)> {
    let comparison = measure::compare_files(options)?;
    let alike = options.are_alike(comparison.percent_over(options.levels));
    let verdict = if alike { "alike" } else { "different" };
    let (levels, percent) = (options.levels, options.percent);
    let levels = counted(usize::from(levels), "level");
    let text = format!("{comparison}{verdict}: at most {levels} on all but {percent}%\n");
    // 1 would mean that the pictures are unlike.
    Ok(Outcome { if_not_printed: measure::CANNOT_COMPARE, ..Outcome::new(text, u8::from(!alike)) })
}

/// Renders a scene and writes its files.
fn render_to_files(options: &Options) -> Result<Outcome, Error> {
    let total = Stopwatch::start();
    let files = write::begin_files(options)?;
    if options.measure.is_adaptive() || options.measure.convergence.is_some() {
        interrupt::let_rendering_end();
    }
    threads::start(options)?.install(|| {
        let Some((mut report, pictures)) = render_since(options, &total, files)? else {
            if !options.quiet {
                say("nothing is rendered: the pictures are done\n");
            }
            return Ok(Outcome::new(String::new(), 0));
        };
        report.remarks.lines(options.quiet).for_each(|line| say(&line));
        if options.explain {
            say(&format!("{}cube map faces decoded: {}\n", report.frame.counts, report.decoded_faces));
            report.mesh_files.iter().for_each(|file| say(&format!("mesh {file}\n")));
        }
        let (written, writing) = timed(|| write::finish_pictures(options, pictures, &report.frame.film));
        written?;
        report.phases.encode += writing;
        report.total = total.times();
        write::write_findings(options, &report)?;
        write::say_what_is_written(options, &report);
        let text = report.pixels.iter().map(|pixel| pixel.text(options)).collect();
        Ok(Outcome::new(text, if report.is_complete(options) { 0 } else { INCOMPLETE }))
    })
}

/// Renders the pictures that `options` ask for, in memory. A time limit counts from here.
///
/// # Errors
/// [`Error`] for a mistake in the scene or in a file that it names.
pub fn render_scene(options: &Options) -> Result<Report, Error> {
    let options = &Options { skip_done: false, ..options.clone() };
    let rendered = render_since(options, &Stopwatch::start(), Vec::new())?;
    Ok(rendered.expect("nothing is skipped").0)
}

/// Renders the same. A time limit counts from `start`. Pictures whose files are begun are written while they are rendered,
/// and are still to be finished; then the report has no film. `None`: all pictures are done already, and may be skipped.
fn render_since(
    options: &Options,
    start: &Stopwatch,
    files: Vec<OutputFile>,
) -> Result<Option<(Report, Vec<PictureWriter>)>, Error> {
    let limit = write::time_limit(options, start);
    let mut budget = Budget::new(options.max_memory);
    budget.add_pictures(render::bytes_needed(options))?;
    let reference = Reference::wanted_by(options)?;
    let Some(Loaded { compiled, plan, hash, parse, loading }) = load(options, &mut budget, &files)? else {
        return Ok(None);
    };
    let Compiled { scene, places, mesh_files, left_out, mut remarks, build } = compiled;
    let mut pictures = write::begin_pictures(options, files, hash)?;
    let (rendered, rendering) = timed(|| {
        let options = render::with_depth_range(&scene, options);
        let rendered = render_pictures(&scene, &plan, &options, limit, reference.as_ref(), &mut pictures);
        (options, rendered)
    });
    let (options, (frame, convergence)) = (rendered.0.as_ref(), rendered.1?);
    if wants_hints(options) {
        remarks.hints.extend(hints::about_pictures(options, &scene, &frame.counts));
    }
    let inspect = |places| inspect(&scene, places, &mesh_files, &plan, options);
    let pixels = places.as_ref().map(inspect).unwrap_or_default();
    let cost = options.cost.is_some().then(|| Cost::of(&scene, &plan, options));
    let left_out = with_unmet_meshes(left_out, &scene, &mesh_files);
    if options.explain {
        left_out.iter().for_each(|reason| say(&format!("left out: {reason}\n")));
    }
    let threads = rayon::current_num_threads();
    let report = Report {
        decoded_faces: scene.background.decoded_faces()?,
        true_error: reference.and_then(|reference| reference.error_of(&frame.film)),
        phases: Phases::new(parse, loading, build, rendering, [frame.filter, frame.writing], threads),
        total: Times::default(),
        left_out: plan.left_out.into_iter().chain(left_out).collect(),
        frame,
        pixels,
        cost,
        mesh_files,
        remarks,
        depth_range: options.depth.as_ref().map(|depth| (depth.min, depth.max)),
        threads,
        convergence,
    };
    Ok(Some((report, pictures)))
}

/// A scene that is ready to be rendered, and how long that took.
struct Loaded {
    compiled: Compiled,
    plan: Plan,
    /// Of the scene and its files, if pictures are labelled with it.
    hash: Option<u128>,
    parse: Times,
    loading: Times,
}

/// Reads a scene and the files that it names, none of which may be one of `outputs`. `None`: all pictures are done already, and
/// may be skipped.
fn load(options: &Options, budget: &mut Budget, outputs: &[OutputFile]) -> Result<Option<Loaded>, Error> {
    let (parsed, parse) = timed(|| parse(options));
    let (description, plan) = parsed?;
    // Also files that these pictures do not need, and so are not loaded.
    let wants_files = !outputs.is_empty() || options.wants_labels();
    let named = if wants_files { scene::named_files(&description) } else { Vec::new() };
    output::check_inputs(outputs, named.iter().map(PathBuf::as_path))?;
    let hash = options.wants_labels().then(|| scene::hash_of_files(&description, &named));
    if options.skip_done && hash.is_some_and(|hash| write::are_done(options, hash)) {
        return Ok(None);
    }
    if options.explain {
        say(&plan.explain(options));
    }
    let hints = if wants_hints(options) { hints::about_scene(&description, &plan, options) } else { Vec::new() };
    let (compiled, loading) = timed(|| {
        let compiled = compile(&description, &plan, budget);
        drop(description);
        compiled
    });
    let mut compiled = compiled?;
    compiled.remarks.hints.extend(hints);
    compiled.remarks.warnings.extend(hints::about_depths(options));
    Ok(Some(Loaded { compiled, plan, hash, parse, loading }))
}

/// Returns whether somebody reads hints: they are for people at a terminal.
fn wants_hints(options: &Options) -> bool {
    !options.quiet && stderr().is_terminal()
}

fn parse(options: &Options) -> Result<(Description, Plan), Error> {
    let description = without_mistakes(scene_file::parse_file(&options.input)?)?;
    let plan = Plan::new(options, &description);
    Ok((description, plan))
}

/// Renders the pictures: writes them at the same time, if there are some and that can be, or else into memory. With
/// `-convergence` it also returns the curves.
fn render_pictures(
    scene: &Scene,
    plan: &Plan,
    options: &Options,
    limit: Deadline,
    reference: Option<&Reference>,
    pictures: &mut [PictureWriter],
) -> Result<(Frame, Option<Convergence>), Error> {
    let progress = Shown::new(options);
    let is_written = !options.keeps_film() && !pictures.is_empty();
    let writers = pictures.iter_mut().map(|picture| picture as &mut dyn BandWriter);
    let mut curves = None;
    let mut frame = if options.pictures().next().is_none() && !options.renders_colors() {
        Frame::empty()
    } else if options.measure.is_adaptive() && is_written {
        render::render_adaptive_bands(scene, plan, options, limit, writers.collect(), &progress)?
    } else if options.measure.is_adaptive() {
        render::render_adaptive(scene, plan, options, limit, &progress)
    } else if options.measure.convergence.is_some() {
        let (frame, found) = measure::render_convergence(scene, plan, options, reference, &progress);
        curves = Some(found);
        frame
    } else if is_written {
        render::render_bands(scene, plan, options, writers.collect(), &progress)?
    } else {
        render::render_uniform(scene, plan, options, &progress)
    };
    let background = options.depth.as_ref().and_then(|depth| depth.background);
    if let (Some(background), Some(depths)) = (background, &mut frame.film.depth) {
        *depths = render::depths_with_background(depths, background, scene, plan, options, &progress);
    }
    Ok((frame, curves))
}

/// Adds the meshes whose trees were not built.
fn with_unmet_meshes(mut left_out: Vec<String>, scene: &Scene, mesh_files: &[MeshFile]) -> Vec<String> {
    let unmet = mesh_files.iter().filter(|file| scene.geometry.is_unmet(file.mesh));
    left_out.extend(unmet.map(|file| format!("the tree of {}: no ray meets its box", file.path.display())));
    left_out
}
