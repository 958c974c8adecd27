//! `-merge`: joins parts of a picture, row by row, so that memory holds a few rows, however high the picture is. The file
//! is the same, byte for byte, as if the picture had been rendered at once.

mod cover;
mod part_reader;

use crate::error::Error;
use crate::film::{BandWriter as _, Film, PictureWriter, Plane, Planes, file_beside, is_whole, read_label};
use crate::options::{MergeOptions, Region, format_of_numbers};
use crate::output::{self, OutputFile};
use crate::part::Label;
use cover::{Problem, Span, spans};
use part_reader::PartReader;
use std::path::{Path, PathBuf};
use std::slice;

/// Rows that are joined before they are written.
const ROWS_AT_ONCE: u32 = 16;

/// Joins the parts of a picture to a file.
///
/// # Errors
/// [`Error::File`] for a file that is no part, is part of another picture or cannot be read, and for the file that cannot be
/// written; [`Error::Refused`] for parts that overlap or do not cover the picture.
pub fn merge(options: &MergeOptions) -> Result<(), Error> {
    let (output, parts) = (options.output.as_path(), &options.parts);
    let file = OutputFile::checked(output, "the picture")?;
    output::check_inputs(slice::from_ref(&file), parts.iter().map(PathBuf::as_path))?;
    let labels = labels(output, parts)?;
    let size = labels[0].size;
    let places: Vec<_> = labels.iter().map(|label| label.place).collect();
    let spans = spans(&places, size).map_err(|problem| refusal(&problem, parts, &places))?;
    let mut writer = PictureWriter::new(file, Plane::Color, size, None)?;
    let is_png = format_of_numbers(output).is_none();
    let planes = Planes { color: is_png, linear: !is_png, ..Planes::default() };
    let mut readers: Vec<Option<PartReader>> = parts.iter().map(|_| None).collect();
    for Span { rows, parts: active } in spans {
        for first in rows.clone().step_by(ROWS_AT_ONCE as usize) {
            let height = ROWS_AT_ONCE.min(rows.end - first);
            let mut band = Film::new(size.0, height, planes);
            for &part in &active {
                let (path, place) = (&parts[part], places[part]);
                if readers[part].is_none() {
                    readers[part] = Some(PartReader::open(path, (place.width, place.height))?);
                }
                let Some(reader) = &mut readers[part] else { continue };
                reader.read_rows(place.x, height, &mut band).map_err(|message| Error::file(path, message))?;
            }
            writer.write(&band)?;
        }
        active.iter().filter(|&&part| places[part].end_row() == rows.end).for_each(|&part| readers[part] = None);
    }
    writer.finish()
}

/// Reads the labels of all parts, which must be of one picture.
fn labels(output: &Path, parts: &[PathBuf]) -> Result<Vec<Label>, Error> {
    let mut labels: Vec<Label> = Vec::with_capacity(parts.len());
    for path in parts {
        if format_of_numbers(output) != format_of_numbers(path) {
            return Err(Error::file(path, format!("its name must end as that of '{}'", output.display())));
        }
        let label = read_label(path).as_deref().and_then(Label::parse);
        let label = label.ok_or_else(|| Error::file(path, without_label(path)))?;
        if let Some(difference) = labels.first().and_then(|first| label.difference(first)) {
            let message = format!("this is no part of the picture of '{}': {difference}", parts[0].display());
            return Err(Error::file(path, message));
        }
        if !is_whole(path) {
            return Err(Error::file(path, "this part is damaged, or was copied in part: make it again"));
        }
        labels.push(label);
    }
    Ok(labels)
}

/// Says why no label of a part can be read.
fn without_label(path: &Path) -> String {
    // Whether it is there at all comes first.
    if let Err(error) = std::fs::metadata(path) {
        return format!("cannot read this part: {error}");
    }
    let or_else = match file_beside(path) {
        Some(label) if label.exists() => format!(", or its label in '{}' is damaged", label.display()),
        Some(label) => format!(", or was copied without its label, the file '{}'", label.display()),
        None if !is_whole(path) => ", or it is damaged or was copied in part".to_owned(),
        None => String::new(),
    };
    format!("this is no part of a picture{or_else}: -region, -tile or -skip-done make parts")
}

fn refusal(problem: &Problem, parts: &[PathBuf], places: &[Region]) -> Error {
    Error::Refused(match *problem {
        Problem::Gap { pixel: (x, row) } => {
            let start = |part: &usize| (places[*part].row, places[*part].x);
            let others = 0..parts.len();
            let before = others.clone().filter(|part| start(part) < (row, x)).max_by_key(start);
            let after = others.filter(|part| start(part) > (row, x)).min_by_key(start);
            let named = |word: &str, part: Option<usize>| {
                part.map_or(String::new(), |part| format!(", {word} '{}'", parts[part].display()))
            };
            let (before, after) = (named("after", before), named("before", after));
            format!("no part has the pixel in column {x}, row {row}{before}{after}")
        }
        Problem::Overlap { parts: [a, b], pixel: (x, row) } => {
            let (a, b) = (parts[a].display(), parts[b].display());
            format!("'{a}' and '{b}' overlap: both have the pixel in column {x}, row {row}")
        }
    })
}
