//! [`PictureWriter`]: writes a plane of a film into a file, band by band.

use super::label::{file_beside, text_beside};
use super::numbers::NumberEncoder;
use super::png::PngEncoder;
use super::{BandWriter, Film};
use crate::error::Error;
use crate::output::{OutputFile, write_whole};
use std::io::{self, Write};
use std::path::PathBuf;

/// What of a film a file shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    /// Bytes or numbers, as the file's name says.
    Color,
    Normals,
    /// One byte a pixel.
    Depth,
    /// Three bytes a pixel.
    ColoredDepth,
}

/// A picture file that is being written. It appears under its name when it is finished.
pub struct PictureWriter {
    file: OutputFile,
    plane: Plane,
    format: Format,
    /// A file beside the picture, and the label that it will hold.
    label: Option<(PathBuf, String)>,
}

enum Format {
    Png(Box<PngEncoder>),
    Numbers(NumberEncoder),
}

impl PictureWriter {
    /// Begins a picture of this size in a file, whose name says the format, with a label.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written.
    pub fn new(file: OutputFile, plane: Plane, size: (u32, u32), label: Option<&str>) -> Result<Self, Error> {
        let label_file = file_beside(file.name());
        let format = if label_file.is_some() {
            NumberEncoder::new(file.name(), size).map(Format::Numbers)
        } else {
            PngEncoder::new(size, plane == Plane::Depth, label).map(|encoder| Format::Png(Box::new(encoder)))
        };
        let format = format.map_err(|error| file.refused(&error))?;
        let label = label.and_then(|label| Some((label_file?, label.to_owned())));
        Ok(Self { file, plane, format, label })
    }

    /// Writes what is left, and gives the file its name. All rows must have been written.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written.
    pub fn finish(mut self) -> Result<(), Error> {
        let ended = match self.format {
            Format::Png(encoder) => encoder.finish().and_then(|bytes| self.file.write_all(&bytes)),
            Format::Numbers(encoder) => encoder.finish(&mut self.file),
        };
        ended.map_err(|error| self.file.refused(&error))?;
        let Some((path, label)) = self.label else { return self.file.finish() };
        let picture = self.file.name().to_owned();
        // At no time does it belong to another picture.
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(Error::io(&path, "replace the label", &error));
            }
            _ => self.file.finish()?,
        }
        let text = text_beside(&label, &picture).map_err(|error| Error::io(&picture, "read", &error))?;
        write_whole(&path, "the label", |writer| writer.write_all(text.as_bytes()))
    }

    fn write_band(&mut self, band: &Film) -> io::Result<()> {
        let file = &mut self.file;
        let bytes = match self.plane {
            Plane::Color => &band.color,
            Plane::Normals => &band.normals,
            Plane::Depth | Plane::ColoredDepth => &band.depth,
        };
        match (&mut self.format, bytes, &band.linear) {
            (Format::Png(encoder), Some(bytes), _) => encoder.write_rows(bytes, file),
            (Format::Numbers(encoder), _, Some(numbers)) => encoder.write_rows(numbers, file),
            _ => Err(io::Error::other("the film has no such plane")),
        }
    }
}

impl BandWriter for PictureWriter {
    fn write(&mut self, band: &Film) -> Result<(), Error> {
        self.write_band(band).map_err(|error| self.file.refused(&error))
    }
}
