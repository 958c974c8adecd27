//! Writes the results of a run: pictures and tables to files, messages to standard error.

use crate::error::{Error, shown_number};
use crate::film::{self, BandWriter as _, Film, PictureWriter, Plane};
use crate::input::is_standard;
use crate::measure::{self, Report};
use crate::options::{Options, Region};
use crate::output::{self, OutputFile, say};
use crate::part::Label;
use crate::timing::{Deadline, Stopwatch};
use rayon::prelude::*;
use std::io::{IsTerminal as _, Write as _, stderr};
use std::path::Path;

/// Begins all files before a long computation: checks that they can be written, and that none of them is read. Pictures come
/// first.
///
/// # Errors
/// [`Error::File`] for the first file that cannot be written.
pub fn begin_files(options: &Options) -> Result<Vec<OutputFile>, Error> {
    let files = output::begin(options.files_by_flag())?;
    let inputs = [Some(options.input.as_path()), options.measure.reference.as_deref()];
    output::check_inputs(&files, inputs.into_iter().flatten())?;
    Ok(files)
}

/// Returns when the pictures must be written.
pub fn time_limit(options: &Options, start: &Stopwatch) -> Deadline {
    /// Seconds for what comes before `start` and after writing, and for what cannot be interrupted: starting a
    /// process and ending its threads, a generation of mirror rays.
    const MARGIN: f64 = 0.01;
    options.measure.time_limit.map_or(Deadline::ON_INTERRUPT, |limit| start.deadline(limit - MARGIN))
}

/// Returns the planes that are shown, with the names of their files, in the order of [`Options::pictures`].
fn planes(options: &Options) -> impl Iterator<Item = (Plane, &Path)> {
    let depth = options.depth.as_ref();
    let is_colored = depth.is_some_and(|depth| depth.background.is_some());
    let planes = [
        (Plane::Color, options.color.as_deref()),
        (Plane::Normals, options.normals.as_deref()),
        (if is_colored { Plane::ColoredDepth } else { Plane::Depth }, depth.map(|depth| depth.path.as_path())),
    ];
    planes.into_iter().filter_map(|(plane, path)| Some((plane, path?)))
}

/// Returns whether all files are there already, and the pictures among them are whole and by the same scene, arguments and
/// version. `hash` is that of the scene and its files.
pub fn are_done(options: &Options, hash: u128) -> bool {
    let is_done = |(plane, path)| {
        let label = Label::new(options, plane, hash).to_string();
        film::read_label(path) == Some(label) && film::is_whole(path)
    };
    options.files().all(Path::exists) && planes(options).all(is_done)
}

/// Begins the pictures, in the files that were begun for them. They get labels if there is a `hash`, that of the scene and
/// its files.
///
/// # Errors
/// [`Error::File`] for a file that cannot be written.
pub fn begin_pictures(
    options: &Options,
    files: Vec<OutputFile>,
    hash: Option<u128>,
) -> Result<Vec<PictureWriter>, Error> {
    let shown = options.shown();
    let begin = |((plane, _), file)| {
        let label = hash.map(|hash| Label::new(options, plane, hash).to_string());
        PictureWriter::new(file, plane, (shown.width, shown.height), label.as_deref())
    };
    planes(options).zip(files).map(begin).collect()
}

/// Finishes the pictures. Those of a film are written only now.
///
/// # Errors
/// [`Error::File`] for a file that cannot be written.
pub fn finish_pictures(options: &Options, mut pictures: Vec<PictureWriter>, film: &Film) -> Result<(), Error> {
    if options.keeps_film() {
        pictures.par_iter_mut().try_for_each(|picture| picture.write(film))?;
    }
    pictures.into_iter().try_for_each(PictureWriter::finish)?;
    match (&options.measure.error_map, film.error_map()) {
        (Some(path), Some(bytes)) => film::write_png(path, film.width, film.height, &bytes),
        _ => Ok(()),
    }
}

/// Writes the tables that `options` ask for, and the messages at the end of a run.
///
/// # Errors
/// [`Error::File`] for a file that cannot be written.
pub fn write_findings(options: &Options, report: &Report) -> Result<(), Error> {
    let measure = &options.measure;
    if let (Some(path), Some(curves)) = (&measure.convergence, &report.convergence) {
        let file = measure::convergence_file(path, options, &report.frame, curves);
        write_text(path, &file.map_err(|error| Error::io(path, "make the page", &error))?)?;
        if !options.quiet {
            say(&format!("{}\n", measure::sentences(options, curves)));
        }
    }
    if let (Some(path), Some(cost)) = (&options.cost, &report.cost) {
        cost.write_picture(path)?;
    }
    if let Some(path) = &measure.report {
        write_text(path, &report.json(options))?;
    }
    if measure.stats {
        say(&report.table(options));
    } else if !options.quiet {
        if measure.is_adaptive() {
            say(&report.verdict(options));
        }
        if let (Some(error), None) = (&report.true_error, &measure.report) {
            say(&error.to_string());
        }
    }
    let is_auto = options.depth.as_ref().is_some_and(|depth| depth.is_auto);
    if let (Some((min, max)), true) = (report.depth_range, is_auto && !options.quiet) {
        say(&match report.frame.counts.camera_hits {
            0 => "depths: nothing is hit\n".to_owned(),
            _ => format!("depths: {min} to {max} (-depth {min} {max} gives the same picture)\n"),
        });
    }
    let read = report.phases.before_rendering().as_secs_f64();
    if let Some(limit) = measure.time_limit.filter(|limit| read > *limit) {
        say(&format!(
            "warning: reading the scene and its files took {read:.2} s, which is more than -time-limit {}\n",
            shown_number(limit)
        ));
    }
    let missed = measure.target_error.filter(|&target| !report.is_below(target));
    if let Some(target) = missed {
        say(&format!("warning: the target error of {} levels was not reached\n", shown_number(target)));
    }
    Ok(())
}

/// Says on a terminal which pictures are written.
pub fn say_what_is_written(options: &Options, report: &Report) {
    if options.quiet || !stderr().is_terminal() {
        return;
    }
    let names: Vec<String> =
        options.pictures().filter(|path| !is_standard(path)).map(|path| path.display().to_string()).collect();
    if !names.is_empty() {
        let (Region { width, height, .. }, seconds) = (options.shown(), report.total.wall.as_secs_f64());
        say(&format!("wrote {}, {width} x {height}, {seconds:.2} s\n", names.join(", ")));
    }
}

fn write_text(path: &Path, text: &str) -> Result<(), Error> {
    output::write_whole(path, "the file", |writer| writer.write_all(text.as_bytes()))
}
