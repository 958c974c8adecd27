//! Encodes pictures as PNG, row by row, by the crate `png`.
//!
//! Rows are filtered by that one of two filters that leaves fewer bytes which are not 0, because the fast compressor makes
//! next to nothing of zeros. One row in four chooses, which takes a quarter of the time.

use super::label::KEYWORD;
use crate::error::Error;
use crate::output::write_whole;
use png::{BitDepth, ColorType, DeflateCompression, Encoder, EncodingError, Filter, StreamWriter};
use std::io::{self, Write};
use std::mem::take;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// Largest size of an `IDAT` chunk in bytes, and that of the smallest picture.
const CHUNK: usize = 1 << 15;
const SMALLEST_CHUNK: usize = 1 << 8;
/// So many rows have the filter of the first of them.
const ROWS_OF_A_FILTER: u32 = 4;
/// Bytes of rows after which what is encoded is written.
const WRITTEN_AT_ONCE: usize = 1 << 18;

/// Writes a picture as an 8 bit RGB PNG. `bytes` has three bytes a pixel, or one for a grey picture, rows from the
/// top.
///
/// # Errors
/// As [`write_whole`].
pub fn write_png(path: &Path, width: u32, height: u32, bytes: &[u8]) -> Result<(), Error> {
    write_whole(path, "the picture", |writer| write(writer, width, height, bytes))
}

/// Encodes a picture in memory; the same bytes as in the file that [`write_png`] writes.
///
/// # Errors
/// As the library that encodes.
pub fn encode_png(width: u32, height: u32, bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut file = Vec::new();
    write(&mut file, width, height, bytes)?;
    Ok(file)
}

fn write(writer: &mut impl Write, width: u32, height: u32, bytes: &[u8]) -> io::Result<()> {
    let is_grey = bytes.len() == width as usize * height as usize;
    let mut encoder = PngEncoder::new((width, height), is_grey, None)?;
    encoder.write_rows(bytes, writer)?;
    writer.write_all(&encoder.finish()?)
}

/// Encodes an 8 bit RGB PNG.
pub struct PngEncoder {
    stream: StreamWriter<'static, Encoded>,
    encoded: Encoded,
    /// Bytes of a row, and of a pixel: one stands for three equal ones.
    row_bytes: usize,
    channels: usize,
    /// Rows that are encoded.
    rows: u32,
    /// The row above the next one that chooses a filter.
    above: Vec<u8>,
    /// Scratch for grey pictures: a row of three bytes a pixel.
    rgb: Vec<u8>,
}

/// What is encoded and not yet written. Writing into it never fails: at some errors the library panics.
#[derive(Clone)]
struct Encoded(Arc<Mutex<Vec<u8>>>);

impl Encoded {
    fn take(&self) -> Vec<u8> {
        take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Write for Encoded {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl PngEncoder {
    /// Begins a picture of this size. Rows of a grey one have one byte a pixel. A label is put into a text chunk.
    ///
    /// # Errors
    /// As the library.
    pub fn new((width, height): (u32, u32), is_grey: bool, label: Option<&str>) -> io::Result<Self> {
        let encoded = Encoded(Arc::new(Mutex::new(Vec::with_capacity(SMALLEST_CHUNK))));
        let mut encoder = Encoder::new(encoded.clone(), width, height);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_deflate_compression(DeflateCompression::FdeflateUltraFast);
        if let Some(label) = label {
            encoder.add_text_chunk(KEYWORD.to_owned(), label.to_owned()).map_err(into_io)?;
        }
        let writer = encoder.write_header().map_err(into_io)?;
        let (width, rgb_bytes) = (width as usize, 3 * width as usize);
        // The library clears the memory for a chunk, which would be most of the work for a small picture.
        let chunk = rgb_bytes.saturating_mul(height as usize).clamp(SMALLEST_CHUNK, CHUNK);
        let stream = writer.into_stream_writer_with_size(chunk).map_err(into_io)?;
        let (channels, rgb) = if is_grey { (1, vec![0; rgb_bytes]) } else { (3, Vec::new()) };
        let row_bytes = channels * width;
        Ok(Self { stream, encoded, row_bytes, channels, rows: 0, above: vec![0; row_bytes], rgb })
    }

    /// Encodes the next rows, and writes what is ready.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_rows(&mut self, bytes: &[u8], writer: &mut impl Write) -> io::Result<()> {
        let rows_at_once = (WRITTEN_AT_ONCE / self.row_bytes).max(1);
        for rows in bytes.chunks(rows_at_once * self.row_bytes) {
            rows.chunks_exact(self.row_bytes).try_for_each(|row| self.encode(row))?;
            writer.write_all(&self.encoded.take())?;
        }
        Ok(())
    }

    fn encode(&mut self, row: &[u8]) -> io::Result<()> {
        let channels = self.channels;
        if self.rows.is_multiple_of(ROWS_OF_A_FILTER) {
            let left = channels + differing(&row[channels..], &row[..row.len() - channels]);
            let up = differing(row, &self.above);
            self.stream.set_filter(if left < up { Filter::Sub } else { Filter::Up });
        }
        self.rows += 1;
        if self.rows.is_multiple_of(ROWS_OF_A_FILTER) {
            self.above.copy_from_slice(row);
        }
        if channels == 3 {
            return self.stream.write_all(row);
        }
        self.rgb.as_chunks_mut().0.iter_mut().zip(row).for_each(|(rgb, &grey)| *rgb = [grey; 3]);
        self.stream.write_all(&self.rgb)
    }

    /// Returns what is not written yet.
    ///
    /// # Errors
    /// As the library, if rows are missing.
    pub fn finish(self) -> io::Result<Vec<u8>> {
        self.stream.finish().map_err(into_io)?;
        Ok(self.encoded.take())
    }
}

/// Returns the number of bytes that are not equal to those at the same place.
fn differing(bytes: &[u8], others: &[u8]) -> usize {
    /// So few that their count fits into a byte, which lets the compiler count sixteen at once.
    const AT_ONCE: usize = 240;
    let count = |(bytes, others): (&[u8], &[u8])| {
        usize::from(bytes.iter().zip(others).map(|(byte, other)| u8::from(byte != other)).sum::<u8>())
    };
    bytes.chunks(AT_ONCE).zip(others.chunks(AT_ONCE)).map(count).sum()
}

/// Returns the error of the operating system if there is one.
fn into_io(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes bytes that are smooth in some places and noise in others, for all kinds of rows.
    fn sample(length: usize) -> Vec<u8> {
        let noise = |i: usize| (i as u32).wrapping_mul(0x9e37_79b9) >> 24;
        (0..length).map(|i| if i % 7000 < 4000 { (i / 900) as u8 } else { noise(i) as u8 }).collect()
    }

    fn decoded(file: &[u8]) -> image::RgbImage {
        image::load_from_memory_with_format(file, image::ImageFormat::Png).unwrap().into_rgb8()
    }

    #[test]
    fn pictures_of_any_shape_are_decoded_as_they_were() {
        for (width, height) in [(1, 1), (1, 70_000), (300, 291), (300, 1000), (70_000, 5), (87_382, 3)] {
            let bytes = sample(3 * width * height);
            let file = encode_png(width as u32, height as u32, &bytes).unwrap();
            assert!(decoded(&file).into_raw() == bytes, "{width} x {height}");
        }
    }

    #[test]
    fn grey_pictures_have_three_equal_channels() {
        let bytes = sample(900 * 700);
        let file = encode_png(900, 700, &bytes).unwrap();
        assert!(decoded(&file).pixels().map(|pixel| pixel.0).eq(bytes.iter().map(|&grey| [grey; 3])));
    }

    #[test]
    fn missing_rows_are_an_error() {
        let mut encoder = PngEncoder::new((4, 3), false, None).unwrap();
        encoder.write_rows(&[7; 24], &mut Vec::new()).unwrap();
        assert!(encoder.finish().is_err());
    }

    #[test]
    fn different_bytes_are_counted() {
        let (mut bytes, others) = (sample(1000), sample(1000));
        assert_eq!(differing(&bytes, &others), 0);
        bytes.iter_mut().step_by(3).for_each(|byte| *byte ^= 1);
        assert_eq!(differing(&bytes, &others), 334);
        assert_eq!(differing(&[1; 999], &[2; 999]), 999);
    }
}
