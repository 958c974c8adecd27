//! [`PartReader`]: reads a part of a picture row by row.

use crate::error::Error;
use crate::film::{Film, NumberPicture, read_numbers};
use crate::options::has_extension;
use png::{BitDepth, ColorType, Decoder, Reader};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// A part that is open.
pub enum PartReader {
    Png(Box<Reader<BufReader<File>>>),
    /// The whole part, and the number of rows that are read.
    Numbers(NumberPicture, u32),
}

impl PartReader {
    /// Opens a part that must have this size.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be read or is another picture.
    pub fn open(path: &Path, size: (u32, u32)) -> Result<Self, Error> {
        let refused = |message: &str| Error::file(path, message);
        let (reader, found) = if has_extension(path, "png") {
            let file = File::open(path).map_err(|error| Error::io(path, "read this part", &error))?;
            let reader = Decoder::new(BufReader::new(file)).read_info();
            let reader = reader.map_err(|error| refused(&format!("cannot read this part: {error}")))?;
            let info = reader.info();
            let found = (info.width, info.height);
            if (info.color_type, info.bit_depth, info.interlaced) != (ColorType::Rgb, BitDepth::Eight, false) {
                return Err(refused("this is no picture of three bytes a pixel"));
            }
            (Self::Png(Box::new(reader)), found)
        } else {
            let picture = read_numbers(path)?;
            let found = (picture.width, picture.height);
            (Self::Numbers(picture, 0), found)
        };
        if found != size {
            return Err(refused("this part has another size than its label says"));
        }
        Ok(reader)
    }

    /// Reads the next rows into a band, from column `x` on.
    ///
    /// # Errors
    /// The message, if the file is broken.
    pub fn read_rows(&mut self, x: u32, rows: u32, band: &mut Film) -> Result<(), String> {
        let (x, band_width) = (x as usize, band.width as usize);
        for row in 0..rows as usize {
            let first = 3 * (row * band_width + x);
            match (&mut *self, &mut band.color, &mut band.linear) {
                (Self::Png(reader), Some(bytes), _) => {
                    let read = reader.next_row().map_err(|error| format!("cannot read this part: {error}"))?;
                    let read = read.ok_or("this part ends too early")?;
                    bytes[first..first + read.data().len()].copy_from_slice(read.data());
                }
                (Self::Numbers(picture, next), _, Some(numbers)) => {
                    let width = 3 * picture.width as usize;
                    let start = width * *next as usize;
                    numbers[first..first + width].copy_from_slice(&picture.numbers[start..start + width]);
                    *next += 1;
                }
                _ => return Err("this is another kind of picture".to_owned()),
            }
        }
        Ok(())
    }
}
