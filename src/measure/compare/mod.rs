//! `-compare A B`: how much two pictures differ, and where. [`Comparison`] has the figures, [`panel`] draws them.

mod comparison;
mod panel;
mod picture;
mod regions;
mod report;

pub use comparison::Comparison;
pub use picture::read_rgb;
pub use regions::Region;

use crate::error::Error;
use crate::film::write_png;
use crate::memory::Budget;
use crate::options::CompareOptions;
use crate::output;
use crate::picture_file::MAX_PIXELS;
use panel::Panel;
use picture::Picture;
use std::io::Write as _;

/// The exit code where a picture cannot be read or a file cannot be written.
pub const CANNOT_COMPARE: u8 = 2;
/// The exit code where the pictures have different sizes.
const SIZES_DIFFER: u8 = 3;

/// Compares two picture files. Writes a picture of both and of their differences with `-diff`, and the figures with
/// `-report`. A `.pfm` or `.exr` is compared as numbers.
///
/// # Errors
/// [`Error::File`] with the exit code: 2 where a picture cannot be read or a file cannot be written, 3 where the sizes
/// differ.
pub fn compare_files(options: &CompareOptions) -> Result<Comparison, (Error, u8)> {
    let cannot = |error| (error, CANNOT_COMPARE);
    let (a, b) = read_both(options).map_err(cannot)?;
    if a.size != b.size {
        write_report(options, &report::of_sizes(options, a.size, b.size)).map_err(cannot)?;
        let ((a_width, a_height), (b_width, b_height)) = (a.size, b.size);
        let message = format!("is {b_width} x {b_height} pixels, the other picture {a_width} x {a_height}");
        return Err((Error::file(&options.b, message), SIZES_DIFFER));
    }
    let differences = a.differences(&b);
    let comparison = Comparison::of(&a, &b, &differences, options.levels);
    if options.diff.is_some() {
        write_panel(options, &Panel::of(&a, &b, &differences, &comparison)).map_err(cannot)?;
    }
    write_report(options, &report::of_pixels(options, &comparison)).map_err(cannot)?;
    Ok(comparison)
}

/// Reads both pictures, after a check that what will be written is neither of them.
fn read_both(options: &CompareOptions) -> Result<(Picture, Picture), Error> {
    let files = [("diff", options.diff.as_deref()), ("report", options.report.as_deref())];
    let files = files.into_iter().filter_map(|(flag, path)| Some((flag, path?)));
    output::check_inputs(&output::begin(files)?, [options.a.as_path(), &options.b])?;
    let (a, b) = (picture::bytes_needed(&options.a), picture::bytes_needed(&options.b));
    // The differences, and with -diff both pictures and these beside each other.
    let of_panel = if options.diff.is_some() { 4 * a.max(b) } else { 0 };
    Budget::new(None).add_pictures(a + b + a.max(b) / 3 + of_panel)?;
    Ok((Picture::read(&options.a)?, Picture::read(&options.b)?))
}

fn write_panel(options: &CompareOptions, panel: &Panel) -> Result<(), Error> {
    let Some(path) = &options.diff else { return Ok(()) };
    let (width, height) = panel.size();
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        let message = format!("would be {width} x {height} pixels; the limit is {MAX_PIXELS} in all");
        return Err(Error::file(path, message));
    }
    write_png(path, width, height, &panel.drawn())
}

fn write_report(options: &CompareOptions, json: &str) -> Result<(), Error> {
    let Some(path) = &options.report else { return Ok(()) };
    output::write_whole(path, "the file", |writer| writer.write_all(json.as_bytes()))
}
