//! Encodes pictures as PNG by all threads in parallel.
//!
//! The rows are divided into strips. Each strip is filtered and deflated by itself, and written as one `IDAT` chunk.
//! The strips are joined into one zlib stream: each ends on a whole byte (RFC 1951), and the last one has the
//! checksum of all (RFC 1950). The strips depend only on the size of the picture, so the file is the same for any
//! number of threads.

use crate::error::Error;
use crate::output::write_whole;
use fdeflate::Compressor;
use png::EncodingError;
use rayon::prelude::*;
use std::io::{self, Write};
use std::ops::Range;
use std::path::Path;

/// Approximate size of a strip in bytes of pixels: so large that the 75 bytes of overhead are nothing, and so small
/// that even a small picture keeps several threads busy.
const STRIP_BYTES: usize = 1 << 18;
/// Number of strips in memory: enough for all threads, and little memory compared to a large picture.
const STRIPS_AT_ONCE: usize = 32;
/// Modulus of the two sums in Adler-32 (RFC 1950).
const ADLER_MODULUS: u64 = 65_521;

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

fn write(writer: impl Write, width: u32, height: u32, bytes: &[u8]) -> io::Result<()> {
    let mut encoder = png::Encoder::new(writer, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut file = encoder.write_header().map_err(into_io)?;
    let (width, height) = (width as usize, height as usize);
    let picture = Picture { bytes, row_bytes: bytes.len() / height, is_grey: bytes.len() == width * height };
    let strip_rows = (STRIP_BYTES / (3 * width)).max(1);
    let strips: Vec<_> = (0..height).step_by(strip_rows).map(|row| row..(row + strip_rows).min(height)).collect();
    let mut checksum = 1;
    for some in strips.chunks(STRIPS_AT_ONCE) {
        let deflated: Vec<_> = some.par_iter().map(|rows| picture.deflated(rows)).collect();
        for (rows, stream) in some.iter().zip(deflated) {
            let (mut chunk, strip_checksum) = without_checksum(stream?)?;
            checksum = joined(checksum, strip_checksum, (rows.len() * (3 * width + 1)) as u64);
            if rows.end < height {
                continue_after(&mut chunk);
            } else {
                chunk.extend(checksum.to_be_bytes());
            }
            // Only the first strip begins with the two bytes of the zlib header.
            let start = if rows.start == 0 { 0 } else { 2 };
            file.write_chunk(png::chunk::IDAT, &chunk[start..]).map_err(into_io)?;
        }
    }
    file.finish().map_err(into_io)
}

struct Picture<'a> {
    bytes: &'a [u8],
    row_bytes: usize,
    /// One byte a pixel stands for three equal ones.
    is_grey: bool,
}

impl Picture<'_> {
    /// Compresses some rows to a zlib stream of their own.
    fn deflated(&self, rows: &Range<usize>) -> io::Result<Vec<u8>> {
        let channels = if self.is_grey { 1 } else { 3 };
        let black = vec![0; self.row_bytes];
        let (mut left, mut up, mut rgb) =
            (black.clone(), black.clone(), vec![0; 1 + 3 * self.row_bytes / channels]);
        let mut compressor = Compressor::new(Vec::new())?;
        for row in rows.clone() {
            let start = row * self.row_bytes;
            let bytes = &self.bytes[start..start + self.row_bytes];
            let above = if row == 0 { &black } else { &self.bytes[start - self.row_bytes..start] };
            let (first, rest) = bytes.split_at(channels);
            left[..channels].copy_from_slice(first);
            subtract(rest, bytes, &mut left[channels..]);
            subtract(bytes, above, &mut up);
            // Filters 1 (left) and 2 (up) are the fastest to undo. Bytes that are 0 compress to almost nothing.
            let (filter, filtered) = if nonzero(&left) < nonzero(&up) { (1, &left) } else { (2, &up) };
            rgb[0] = filter;
            if self.is_grey {
                rgb[1..].as_chunks_mut().0.iter_mut().zip(filtered).for_each(|(rgb, &grey)| *rgb = [grey; 3]);
            } else {
                rgb[1..].copy_from_slice(filtered);
            }
            compressor.write_data(&rgb)?;
        }
        compressor.finish()
    }
}

fn subtract(bytes: &[u8], others: &[u8], differences: &mut [u8]) {
    for ((difference, byte), other) in differences.iter_mut().zip(bytes).zip(others) {
        *difference = byte.wrapping_sub(*other);
    }
}

fn nonzero(bytes: &[u8]) -> usize {
    /// So few that their count fits into a byte, which lets the compiler count sixteen at once.
    const AT_ONCE: usize = 240;
    let count = |bytes: &[u8]| bytes.iter().map(|&byte| u8::from(byte != 0)).sum::<u8>();
    bytes.chunks(AT_ONCE).map(|bytes| usize::from(count(bytes))).sum()
}

/// Removes the Adler-32 checksum from the end of a zlib stream, and returns both.
fn without_checksum(mut stream: Vec<u8>) -> io::Result<(Vec<u8>, u32)> {
    let checksum = stream.last_chunk().map(|bytes| u32::from_be_bytes(*bytes));
    stream.truncate(stream.len().saturating_sub(4));
    Ok((stream, checksum.ok_or(io::ErrorKind::UnexpectedEof)?))
}

/// Changes a zlib stream of one final block so that other blocks can follow it, beginning on a whole byte.
fn continue_after(stream: &mut Vec<u8>) {
    stream[2] &= !1;
    // `fdeflate` ends a block with a code whose last bit is 1, and fills the byte with zeros. Three zeros begin an
    // empty stored block. It goes on with the next whole byte: its length 0, and the complement of the length.
    if stream.last().is_none_or(|byte| byte.leading_zeros() < 3) {
        stream.push(0);
    }
    stream.extend([0, 0, 0xff, 0xff]);
}

/// Returns the Adler-32 checksum of two pieces of data one after the other, from the checksum of each. The second
/// piece has `length` bytes.
fn joined(first: u32, second: u32, length: u64) -> u32 {
    let sums = |checksum: u32| (u64::from(checksum & 0xffff), u64::from(checksum >> 16));
    let ((a1, b1), (a2, b2)) = (sums(first), sums(second));
    // The sums of the second piece began with (1, 0) instead of (a1, b1).
    let a = (a1 + a2 + ADLER_MODULUS - 1) % ADLER_MODULUS;
    let b = (b1 + b2 + (length % ADLER_MODULUS) * (a1 + ADLER_MODULUS - 1)) % ADLER_MODULUS;
    (b << 16 | a) as u32
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

    /// Makes bytes that are smooth in some places and noise in others, for all kinds of rows and ends of strips.
    fn sample(length: usize) -> Vec<u8> {
        let noise = |i: usize| (i as u32).wrapping_mul(0x9e37_79b9) >> 24;
        (0..length).map(|i| if i % 7000 < 4000 { (i / 900) as u8 } else { noise(i) as u8 }).collect()
    }

    fn decoded(file: &[u8]) -> image::RgbImage {
        image::load_from_memory_with_format(file, image::ImageFormat::Png).unwrap().into_rgb8()
    }

    #[test]
    fn pictures_of_any_number_of_strips_are_decoded_as_they_were() {
        for (width, height) in [(1, 1), (1, 70_000), (300, 291), (300, 292), (300, 1000), (70_000, 5), (87_382, 3)]
        {
            let bytes = sample(3 * width * height);
            let mut file = Vec::new();
            write(&mut file, width as u32, height as u32, &bytes).unwrap();
            assert!(decoded(&file).into_raw() == bytes, "{width} x {height}");
        }
    }

    #[test]
    fn grey_pictures_have_three_equal_channels() {
        let bytes = sample(900 * 700);
        let mut file = Vec::new();
        write(&mut file, 900, 700, &bytes).unwrap();
        assert!(decoded(&file).pixels().map(|pixel| pixel.0).eq(bytes.iter().map(|&grey| [grey; 3])));
    }

    #[test]
    fn checksums_of_parts_join() {
        let bytes = sample(300_000);
        let checksum = |bytes: &[u8]| without_checksum(fdeflate::compress_to_vec(bytes)).unwrap().1;
        for cut in [0, 1, 65_521, 299_999, 300_000] {
            let (first, second) = bytes.split_at(cut);
            assert_eq!(joined(checksum(first), checksum(second), second.len() as u64), checksum(&bytes), "{cut}");
        }
    }
}
