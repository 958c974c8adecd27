//! [`PictureFile`]: a PNG or EXR file to read. What it claims is checked before memory is taken for it, so that a small
//! file cannot take much.

use crate::file_kind;
use crate::input::read_whole;
use crate::options::has_extension;
use crc32fast::Hasher;
#[cfg(feature = "exr")]
use exr::meta::attribute::ChannelDescription;
use image::codecs::png::PngDecoder;
use image::{ColorType, DynamicImage, ImageDecoder, ImageError, Limits};
use std::error::Error as _;
use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read as _, Result as IoResult};
use std::path::Path;

/// Largest number of pixels: a picture of three bytes a pixel fits into the memory of every machine.
pub const MAX_PIXELS: u64 = 1 << 28;
/// Largest number of bytes of a picture file: 16 for each pixel of the largest picture.
const MAX_FILE_BYTES: u64 = 16 * MAX_PIXELS;
/// Memory for pixels that a file of any size may take.
const BASE_BYTES: u64 = 64 << 20;
/// Further memory for each byte of the file. Deflate packs at most 1,032 bytes into one, and half of an EXR's numbers have
/// 16 bits, which take 32 in memory, twice while they are decoded.
const BYTES_PER_FILE_BYTE: u64 = 4096;
/// Place of the colour type in a PNG file, and the type of pictures with a palette.
const COLOR_TYPE: usize = 25;
const WITH_PALETTE: u8 = 3;
/// Memory for what a PNG of any size holds beside its pixels. A larger colour profile is skipped; none is ever used.
const MAX_EXTRA_BYTES: u64 = 16 << 20;
/// Further memory for each byte of the file: texts are read into a buffer that grows to twice their size, and copied.
const EXTRA_FOR_FILE_BYTE: u64 = 4;
/// How PNG files begin: with their mark, then the first chunk, whose length is always the same. Then the size follows.
const PNG_HEAD: &[u8] = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR";

/// A picture file whose size is known and allowed, and whose pixels are not decoded yet.
pub struct PictureFile {
    decoder: Box<dyn ImageDecoder>,
    pub width: u32,
    pub height: u32,
}

impl PictureFile {
    /// Opens a picture: an EXR if its name ends in `.exr`, otherwise a PNG.
    ///
    /// # Errors
    /// The message, without the file's name.
    pub fn open(path: &Path) -> Result<Self, String> {
        let (decoder, file_bytes) = match has_extension(path, "exr") {
            #[cfg(feature = "exr")]
            true => exr_decoder(read_bytes(path)?)?,
            _ => png_decoder(path)?,
        };
        let (width, height) = decoder.dimensions();
        check_size(width, height, bytes_a_pixel(decoder.color_type()), file_bytes)?;
        Ok(Self { decoder, width, height })
    }

    /// Returns the bytes of memory that the pixels take while they are decoded.
    pub fn decoded_bytes(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height) * bytes_a_pixel(self.decoder.color_type())
    }

    /// Decodes the pixels.
    ///
    /// # Errors
    /// The message, without the file's name.
    pub fn decode(self) -> Result<DynamicImage, String> {
        DynamicImage::from_decoder(self.decoder).map_err(|error| unreadable(&error, None))
    }
}

/// Decodes the first rows of a PNG picture of this size, three bytes a pixel. Returns `None` if the picture is of another kind
/// or not as it should be: then all of it is to be decoded.
///
/// The checksums of the whole file are checked, so that damage is seen wherever it is.
pub fn first_rows(path: &Path, size: (u32, u32), rows: u32) -> Option<Vec<u8>> {
    let file =
        read_bytes(path).ok().filter(|file| has_right_checksums(file.as_slice()).is_ok_and(|right| right))?;
    let mut reader = png::Decoder::new(Cursor::new(file)).read_info().ok()?;
    let info = reader.info();
    let is_plain = info.color_type == png::ColorType::Rgb
        && info.bit_depth == png::BitDepth::Eight
        && !info.interlaced
        && info.animation_control.is_none();
    if !is_plain || info.size() != size || rows > size.1 {
        return None;
    }
    let mut pixels = Vec::with_capacity(3 * size.0 as usize * rows as usize);
    for _ in 0..rows {
        pixels.extend_from_slice(reader.next_row().ok()??.data());
    }
    Some(pixels)
}

/// Returns whether a PNG file is whole and no byte of it has changed: every chunk (length, name, data, checksum of name and
/// data) up to the last one is as it was written.
pub fn has_right_checksums(mut file: impl BufRead) -> IoResult<bool> {
    const SIGNATURE: usize = 8;
    file.read_exact(&mut [0; SIGNATURE])?;
    loop {
        let (mut length, mut name, mut written) = ([0; 4], [0; 4], [0; 4]);
        file.read_exact(&mut length)?;
        file.read_exact(&mut name)?;
        let mut checksum = Hasher::new();
        checksum.update(&name);
        add(&mut checksum, file.by_ref().take(u32::from_be_bytes(length).into()))?;
        file.read_exact(&mut written)?;
        if checksum.finalize() != u32::from_be_bytes(written) {
            return Ok(false);
        }
        if &name == b"IEND" {
            return Ok(true);
        }
    }
}

/// Returns the checksum of a whole file.
pub fn checksum(file: impl BufRead) -> IoResult<u32> {
    let mut checksum = Hasher::new();
    add(&mut checksum, file)?;
    Ok(checksum.finalize())
}

fn add(checksum: &mut Hasher, mut bytes: impl BufRead) -> IoResult<()> {
    loop {
        let some = bytes.fill_buf()?;
        if some.is_empty() {
            return Ok(());
        }
        checksum.update(some);
        let count = some.len();
        bytes.consume(count);
    }
}

/// Reads a whole picture file into memory.
///
/// # Errors
/// The message, without the file's name.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, String> {
    accessed(read_whole(path, MAX_FILE_BYTES))
}

/// Checks the size that a picture file claims, in pixels and in bytes of memory while it is decoded.
fn check_size(width: u32, height: u32, bytes_a_pixel: u64, file_bytes: u64) -> Result<(), String> {
    let pixels = check_pixels(width, height)?;
    let (claimed, allowed) =
        (pixels * bytes_a_pixel, BASE_BYTES.saturating_add(file_bytes.saturating_mul(BYTES_PER_FILE_BYTE)));
    if claimed > allowed {
        return Err(format!(
            "this picture claims {width} x {height} pixels, which take {claimed} bytes of memory; the limit for a file \
             of {file_bytes} bytes is {allowed}"
        ));
    }
    Ok(())
}

/// Checks the number of pixels that a picture file claims, and returns it.
fn check_pixels(width: u32, height: u32) -> Result<u64, String> {
    match u64::from(width) * u64::from(height) {
        pixels @ ..=MAX_PIXELS => Ok(pixels),
        _ => Err(format!("this picture claims {width} x {height} pixels; the limit is {MAX_PIXELS} in all")),
    }
}

/// Returns the bytes that a pixel takes while it is decoded and then turned into three bytes or numbers.
fn bytes_a_pixel(color_type: ColorType) -> u64 {
    match color_type {
        ColorType::Rgb8 => 3,
        // EXR is decoded into a buffer of the library, and then copied.
        ColorType::Rgb32F | ColorType::Rgba32F => 2 * u64::from(color_type.bytes_per_pixel()),
        other => u64::from(other.bytes_per_pixel()) + 3,
    }
}

/// Returns a decoder of a PNG file, and the file's size in bytes.
fn png_decoder(path: &Path) -> Result<(Box<dyn ImageDecoder>, u64), String> {
    let file = accessed(File::open(path))?;
    let file_bytes = accessed(file.metadata())?.len();
    let mut reader = BufReader::new(file);
    let head = accessed(reader.fill_buf())?;
    if !head.starts_with(file_kind::PNG_MARK) {
        return Err(of_another_kind("PNG", head));
    }
    if let Some([a, b, c, d, e, f, g, h, ..]) = head.strip_prefix(PNG_HEAD) {
        check_pixels(u32::from_be_bytes([*a, *b, *c, *d]), u32::from_be_bytes([*e, *f, *g, *h]))?;
    }
    let extra = MAX_EXTRA_BYTES.saturating_add(file_bytes.saturating_mul(EXTRA_FOR_FILE_BYTE));
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(extra);
    let opened = if head.get(COLOR_TYPE) == Some(&WITH_PALETTE) {
        let mut bytes = Vec::new();
        accessed(reader.take(MAX_FILE_BYTES).read_to_end(&mut bytes))?;
        check_palette(&bytes)?;
        PngDecoder::with_limits(Cursor::new(bytes), limits)
            .map(|decoder| Box::new(decoder) as Box<dyn ImageDecoder>)
    } else {
        PngDecoder::with_limits(reader, limits).map(|decoder| Box::new(decoder) as Box<dyn ImageDecoder>)
    };
    Ok((opened.map_err(|error| unreadable(&error, Some(extra)))?, file_bytes))
}

/// Says that a file is no picture of this kind, and what it seems to be.
pub fn of_another_kind(kind: &str, bytes: &[u8]) -> String {
    match file_kind::kind_of_picture(bytes) {
        Some(what) => format!("this is no {kind} picture: the file is {what}"),
        None => format!("this is no {kind} picture: it does not begin like one"),
    }
}

/// Checks that a palette ends with a whole colour: the library panics in the middle of one.
fn check_palette(bytes: &[u8]) -> Result<(), String> {
    let reader = png::Decoder::new(Cursor::new(bytes)).read_info();
    let reader = reader
        .map_err(|error| format!("cannot read this picture: {}", with_names_of_chunks(&error.to_string())))?;
    match &reader.info().palette {
        Some(palette) if palette.len() % 3 != 0 => {
            Err("this PNG is broken: its palette ends in the middle of a colour".to_owned())
        }
        _ => Ok(()),
    }
}

/// Returns a decoder of an EXR file, and the file's size in bytes.
#[cfg(feature = "exr")]
fn exr_decoder(bytes: Vec<u8>) -> Result<(Box<dyn ImageDecoder>, u64), String> {
    if !bytes.starts_with(file_kind::EXR_MARK) {
        return Err(of_another_kind("EXR", &bytes));
    }
    check_channels(&bytes)?;
    let file_bytes = bytes.len() as u64;
    let decoder = image::codecs::openexr::OpenExrDecoder::new(Cursor::new(bytes));
    Ok((Box::new(decoder.map_err(|error| unreadable(&error, None))?), file_bytes))
}

/// Checks that some part of an EXR file has the channels of a colour. What is wrong with its head, the decoder says.
#[cfg(feature = "exr")]
fn check_channels(bytes: &[u8]) -> Result<(), String> {
    /// Channels that a message names.
    const MOST: usize = 8;
    let Ok(meta) = exr::meta::MetaData::read_from_buffered(bytes, false) else { return Ok(()) };
    let parts = meta.headers.iter().map(|header| &header.channels.list);
    let is_color = |part: &[ChannelDescription]| {
        ["R", "G", "B"].into_iter().all(|needed| part.iter().any(|channel| channel.name.eq(needed)))
    };
    let mut names = parts.clone().flatten().map(|channel| channel.name.to_string()).peekable();
    if parts.clone().any(|part| is_color(part)) || names.peek().is_none() {
        return Ok(());
    }
    let shown = names.by_ref().take(MOST).collect::<Vec<_>>().join(", ");
    let more = if names.next().is_some() { ", ..." } else { "" };
    Err(format!("this EXR picture has the channels {shown}{more}: those named R, G and B are needed"))
}

fn accessed<T>(result: IoResult<T>) -> Result<T, String> {
    result.map_err(|error| format!("cannot read the picture: {error}"))
}

/// Says why a picture cannot be read. `extra`: the most bytes that were allowed for what it holds beside its pixels.
fn unreadable(error: &ImageError, extra: Option<u64>) -> String {
    match (error, extra) {
        (ImageError::Limits(_), Some(extra)) => {
            format!(
                "this picture needs more than {extra} bytes of memory, the limit, for what it holds beside its pixels"
            )
        }
        _ => {
            // The source says what is wrong, the error itself only where the library found it.
            let said = error.source().map_or_else(|| error.to_string(), ToString::to_string);
            format!("cannot read this picture: {}", with_names_of_chunks(&said))
        }
    }
}

/// Returns what the library says with the name of a PNG's chunk, which it shows as `ChunkType { type: IHDR, critical: true, ... }`.
fn with_names_of_chunks(said: &str) -> String {
    let parts = || {
        let (before, rest) = said.split_once("ChunkType { type: ")?;
        let (name, rest) = rest.split_once(", ")?;
        let (_, after) = rest.split_once(" }")?;
        Some(format!("{before}{name}{after}"))
    };
    parts().unwrap_or_else(|| said.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_rows_are_those_of_the_picture_unless_it_is_damaged_anywhere() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/tex/courtyard/right.png");
        let whole = PictureFile::open(&path).unwrap();
        let size = (whole.width, whole.height);
        let pixels = whole.decode().unwrap().into_rgb8().into_raw();
        let rows = first_rows(&path, size, 10).unwrap();
        assert!(!rows.is_empty() && rows == pixels[..rows.len()] && rows.len() == 3 * 10 * size.0 as usize);
        assert_eq!(first_rows(&path, (size.0, 5), 5), None);
        let file = std::fs::read(&path).unwrap();
        let damaged = tempfile::NamedTempFile::new().unwrap();
        let rows_of = |file: &[u8]| {
            std::fs::write(damaged.path(), file).unwrap();
            first_rows(damaged.path(), size, 10)
        };
        assert_eq!(rows_of(&file), Some(rows));
        assert_eq!(rows_of(&file[..file.len() - 5]), None);
        let mut changed = file.clone();
        changed[file.len() - 100] ^= 1;
        assert_eq!(rows_of(&changed), None);
    }
}
