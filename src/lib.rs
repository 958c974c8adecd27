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
//! [`mod@compare`] stands beside: it measures how much two pictures differ.
#![deny(unsafe_code)]
// Read with --document-private-items: this is a program first.
#![allow(rustdoc::private_intra_doc_links, rustdoc::redundant_explicit_links)]

pub mod accel;
pub mod args;
pub mod camera;
pub mod compare;
pub mod cube_map;
pub mod error;
pub mod film;
pub mod light;
pub mod material;
pub mod objects;
pub mod plan;
mod progress;
pub mod render;
pub mod report;
pub mod scene;

use args::{CompareArgs, RenderArgs, Request};
use compare::Comparison;
use error::Error;
use film::Film;
use plan::Plan;
use rayon::prelude::*;
use report::RayCounts;
use scene::compile::{Compiled, compile};
use std::ffi::OsString;
use std::io::Write as _;
use std::path::Path;

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

fn compare(args: &CompareArgs) -> Result<Outcome, Error> {
    let comparison: Comparison = compare::compare_files(args)?;
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
}

/// Renders the pictures that `args` asks for, in memory. `report` is told about every finished part.
///
/// # Errors
/// Whatever is wrong with the scene or a file that it names.
pub fn render_scene(args: &RenderArgs) -> Result<Rendered, Error> {
    let description = scene::parser::parse_file(&args.input)?;
    let plan = Plan::new(args, &description);
    if args.explain {
        say(&plan.explain(args));
    }
    let Compiled { scene, warnings } = compile(&description, &plan)?;
    drop(description);
    let progress = progress::Bar::new(args.quiet);
    let (film, counts) = render::render(&scene, &plan, args, &progress);
    let cube_map = scene.background.cube_map.as_ref();
    cube_map.map_or(Ok(()), cube_map::CubeMap::check_decoded_faces)?;
    let decoded_faces = cube_map.map_or(0, cube_map::CubeMap::decoded_faces);
    Ok(Rendered { film, counts, decoded_faces, warnings })
}

/// Writes to standard error. That nobody reads it is no reason to fail.
fn say(text: &str) {
    let _ = std::io::stderr().write_all(text.as_bytes());
}

fn render_to_files(args: &RenderArgs) -> Result<(), Error> {
    let depth_path = args.depth.as_ref().map(|depth| depth.path.as_path());
    for path in [args.color.as_deref(), args.normals.as_deref(), depth_path].into_iter().flatten() {
        film::check_writable(path)?;
    }
    let threads = args.threads.unwrap_or(0);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Error::Refused(format!("cannot start the worker threads: {error}")))?;
    pool.install(|| {
        let rendered = render_scene(args)?;
        if !args.quiet {
            for warning in &rendered.warnings {
                say(&format!("warning: {warning}\n"));
            }
        }
        if args.explain {
            say(&format!("{}cube map faces decoded: {}\n", rendered.counts, rendered.decoded_faces));
        }
        let film = &rendered.film;
        let planes: [(Option<&Path>, &Option<Vec<u8>>); 3] = [
            (args.color.as_deref(), &film.color),
            (args.normals.as_deref(), &film.normals),
            (depth_path, &film.depth),
        ];
        planes.into_par_iter().try_for_each(|(path, plane)| match (path, plane) {
            (Some(path), Some(bytes)) => film::write_png(path, film.width, film.height, bytes),
            _ => Ok(()),
        })
    })
}
