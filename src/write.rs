//! Writes the results of a run: pictures and tables to files, messages to standard error.

use crate::error::Error;
use crate::film::{self, Film};
use crate::measure::{self, Report};
use crate::options::Options;
use crate::timing::Deadline;
use rayon::prelude::*;
use std::io::Write as _;
use std::path::Path;

/// Writes to standard error. Errors of writing are ignored, because a closed pipe is no reason to fail.
pub fn say(text: &str) {
    let _ = std::io::stderr().write_all(text.as_bytes());
}

/// Checks before a long computation that all files can be written.
///
/// # Errors
/// [`Error::File`] for the first file that cannot be written.
pub fn check_files(options: &Options) -> Result<(), Error> {
    options.files().try_for_each(film::check_writable)
}

/// Returns when to stop tracing rays, so that there is time left to write the pictures.
pub fn deadline(options: &Options) -> Deadline {
    /// Of a slow disk, for a PNG that does not compress.
    const BYTES_A_SECOND: f64 = 60e6;
    /// Seconds for what cannot be interrupted: a generation of mirror rays, starting and ending threads.
    const MARGIN: f64 = 0.01;
    let Some(limit) = options.measure.time_limit else { return Deadline::NEVER };
    let bytes = options.pictures().count() as f64
        * 3.0
        * f64::from(options.width)
        * f64::from(options.height)
        * if options.color_is_numbers() { 4.0 } else { 1.0 };
    Deadline::in_seconds(limit - bytes / BYTES_A_SECOND - MARGIN)
}

/// Writes the pictures.
///
/// # Errors
/// [`Error::File`] for a file that cannot be written.
pub fn write_pictures(options: &Options, film: &Film) -> Result<(), Error> {
    if let (Some(path), Some(numbers), true) = (&options.color, &film.linear, options.color_is_numbers()) {
        film::write_numbers(path, film.width, film.height, numbers)?;
    }
    let planes: [(Option<&Path>, &Option<Vec<u8>>); 4] = [
        (options.color.as_deref().filter(|_| !options.color_is_numbers()), &film.color),
        (options.normals.as_deref(), &film.normals),
        (options.depth.as_ref().map(|depth| depth.path.as_path()), &film.depth),
        (options.measure.error_map.as_deref(), &film.error_map),
    ];
    planes.into_par_iter().try_for_each(|(path, plane)| match (path, plane) {
        (Some(path), Some(bytes)) => film::write_png(path, film.width, film.height, bytes),
        _ => Ok(()),
    })
}

/// Writes the tables that `options` ask for, and the messages at the end of a run.
///
/// # Errors
/// [`Error::File`] for a file that cannot be written.
pub fn write_findings(options: &Options, report: &Report) -> Result<(), Error> {
    let measure = &options.measure;
    if let Some(path) = &measure.convergence {
        write_text(path, &measure::csv(options, &report.convergence))?;
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
    let missed = measure.target_error.filter(|&target| !report.is_below(target));
    if let (Some(target), false) = (missed, options.quiet) {
        say(&format!("warning: the target error of {target} levels was not reached\n"));
    }
    Ok(())
}

fn write_text(path: &Path, text: &str) -> Result<(), Error> {
    film::write_whole(path, "the file", |file| file.write_all(text.as_bytes()))
}
