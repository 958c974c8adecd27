//! Pictures of `f32` numbers instead of bytes, for errors to be measured before clamping and truncation: PFM, written
//! here, and OpenEXR (cargo feature `exr`).
//!
//! PFM (Debevec's portable float map): `PF`, width and height, `-1.0` for little-endian, then three `f32` a pixel, rows
//! from the bottom.

#[cfg(feature = "exr")]
use super::exr::ExrEncoder;
use crate::error::Error;
use crate::options::has_extension;
use crate::picture_file::{PictureFile, of_another_kind, read_bytes};
use std::io::{self, Cursor, Seek, SeekFrom, Write};
use std::path::Path;

/// Three numbers a pixel, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct NumberPicture {
    pub width: u32,
    pub height: u32,
    pub numbers: Vec<f32>,
}

fn is_pfm(path: &Path) -> bool {
    has_extension(path, "pfm")
}

/// Encodes a picture in memory, as PFM if the name ends in `.pfm`, otherwise as EXR. `numbers` has three numbers a pixel.
///
/// # Errors
/// As the library that encodes; without the feature `exr`, for every name that does not end in `.pfm`.
pub fn encode_numbers(path: &Path, width: u32, height: u32, numbers: &[f32]) -> io::Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = NumberEncoder::new(path, (width, height))?;
    encoder.write_rows(numbers, &mut bytes)?;
    encoder.finish(&mut bytes)?;
    Ok(bytes.into_inner())
}

/// Encodes a picture of three numbers a pixel, row by row.
pub(super) enum NumberEncoder {
    Pfm {
        size: (u32, u32),
        /// Rows that are written.
        rows: u32,
    },
    #[cfg(feature = "exr")]
    Exr(Box<ExrEncoder>),
}

impl NumberEncoder {
    /// Begins a picture of this size.
    ///
    /// # Errors
    /// As [`encode_numbers`].
    pub fn new(path: &Path, size: (u32, u32)) -> io::Result<Self> {
        if is_pfm(path) {
            return Ok(Self::Pfm { size, rows: 0 });
        }
        #[cfg(feature = "exr")]
        return Ok(Self::Exr(Box::new(ExrEncoder::new(size)?)));
        #[cfg(not(feature = "exr"))]
        Err(io::ErrorKind::Unsupported.into())
    }

    /// Writes the next rows.
    ///
    /// # Errors
    /// Those of the file.
    pub fn write_rows(&mut self, numbers: &[f32], file: &mut (impl Write + Seek)) -> io::Result<()> {
        match self {
            Self::Pfm { size, rows } => {
                let first_row = *rows;
                *rows += (numbers.len() / (3 * size.0 as usize)) as u32;
                write_pfm_rows(file, *size, first_row, numbers)
            }
            #[cfg(feature = "exr")]
            Self::Exr(encoder) => encoder.write_rows(numbers, file),
        }
    }

    /// Writes what is left. All rows must have been written.
    ///
    /// # Errors
    /// Those of the file.
    pub fn finish(self, file: &mut (impl Write + Seek)) -> io::Result<()> {
        match self {
            Self::Pfm { size, .. } => {
                file.seek(SeekFrom::Start(0))?;
                file.write_all(pfm_header(size).as_bytes())
            }
            #[cfg(feature = "exr")]
            Self::Exr(encoder) => encoder.finish(file),
        }
    }
}

/// Returns what comes before the numbers of a PFM file.
fn pfm_header((width, height): (u32, u32)) -> String {
    format!("PF\n{width} {height}\n-1.0\n")
}

/// Writes some rows of a PFM file of this size, from `first_row` on, counted from the top.
fn write_pfm_rows(
    file: &mut (impl Write + Seek),
    size: (u32, u32),
    first_row: u32,
    numbers: &[f32],
) -> io::Result<()> {
    /// Bytes of rows that are made together.
    const AT_ONCE: usize = 1 << 20;
    let (row_numbers, mut rest) = (3 * size.0 as usize, size.1 - first_row);
    let rows_at_once = (AT_ONCE / (4 * row_numbers)).max(1);
    let mut bytes = Vec::new();
    for rows in numbers.chunks(rows_at_once * row_numbers) {
        bytes.resize(4 * rows.len(), 0);
        let upwards = bytes.chunks_exact_mut(4 * row_numbers).rev();
        for (bytes, numbers) in upwards.zip(rows.chunks_exact(row_numbers)) {
            bytes
                .as_chunks_mut()
                .0
                .iter_mut()
                .zip(numbers)
                .for_each(|(bytes, number)| *bytes = number.to_le_bytes());
        }
        rest -= (rows.len() / row_numbers) as u32;
        let place = pfm_header(size).len() as u64 + u64::from(rest) * 4 * row_numbers as u64;
        file.seek(SeekFrom::Start(place))?;
        file.write_all(&bytes)?;
    }
    Ok(())
}

/// Reads a PFM or EXR file.
///
/// # Errors
/// [`Error::File`] when it cannot be read or holds no colours.
pub fn read_numbers(path: &Path) -> Result<NumberPicture, Error> {
    let picture = if is_pfm(path) {
        read_bytes(path).and_then(|bytes| parse_pfm(&bytes))
    } else {
        PictureFile::open(path).and_then(PictureFile::decode).map(|picture| {
            let picture = picture.into_rgb32f();
            NumberPicture { width: picture.width(), height: picture.height(), numbers: picture.into_raw() }
        })
    };
    picture.map_err(|message| Error::file(path, message))
}

fn parse_pfm(bytes: &[u8]) -> Result<NumberPicture, String> {
    let (head, data) = pfm_head(bytes)?;
    let PfmHead { width, height, scale } = head;
    let row_bytes = 12 * width as usize;
    if row_bytes.checked_mul(height as usize) != Some(data.len()) {
        return Err(format!(
            "this PFM picture has {} bytes of numbers, and {width} x {height} pixels take {}",
            data.len(),
            12 * u128::from(width) * u128::from(height)
        ));
    }
    let number = if scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
    let numbers =
        data.chunks_exact(row_bytes).rev().flat_map(|row| row.as_chunks().0).map(|&n| number(n)).collect();
    Ok(NumberPicture { width, height, numbers })
}

struct PfmHead {
    width: u32,
    height: u32,
    /// Below 0 for numbers whose lowest byte comes first.
    scale: f32,
}

/// Parses the head of a PFM file: four words, each ended by one white space character, or all by CR and LF.
/// Returns it and the data behind it, which may contain such bytes, too.
fn pfm_head(bytes: &[u8]) -> Result<(PfmHead, &[u8]), String> {
    if !bytes.starts_with(b"PF") || !bytes.get(2).is_some_and(u8::is_ascii_whitespace) {
        let grey =
            bytes.starts_with(b"Pf").then(|| "this PFM picture has one channel: three are needed".to_owned());
        return Err(grey.unwrap_or_else(|| of_another_kind("PFM", bytes)));
    }
    let mut rest = &bytes[2..];
    let mut word = || {
        rest = rest.trim_ascii_start();
        let end = rest.iter().position(u8::is_ascii_whitespace)?;
        let (word, behind) = rest.split_at(end);
        rest = behind;
        std::str::from_utf8(word).ok()
    };
    let size = |word: Option<&str>| word.and_then(|word| word.parse::<u32>().ok());
    let (width, height) = (size(word()), size(word()));
    let scale = word().and_then(|word| word.parse::<f32>().ok());
    let (Some(width), Some(height), Some(scale)) = (width, height, scale) else {
        return Err("this PFM picture has no width, height and scale".to_owned());
    };
    if width == 0 || height == 0 {
        return Err(format!("this PFM picture has no pixels: its size is {width} x {height}"));
    }
    if scale == 0.0 || !scale.is_finite() {
        return Err(format!(
            "this PFM picture has a scale of {scale}: expected a number below 0 (the lowest byte comes first) or above 0"
        ));
    }
    let ends_lines_with_crlf = bytes.starts_with(b"PF\r\n") && rest.starts_with(b"\r\n");
    let data = rest.get(if ends_lines_with_crlf { 2 } else { 1 }..).unwrap_or_default();
    Ok((PfmHead { width, height, scale }, data))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_numbers_are_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let names = if cfg!(feature = "exr") { ["a.pfm", "a.exr"].as_slice() } else { &["a.pfm"] };
        // The rows of the second are written in two parts.
        for (name, (width, height)) in names.iter().flat_map(|name| [(name, (2, 3)), (name, (300, 400))]) {
            let numbers: Vec<f32> = (0..3 * width * height).map(|n| n as f32 * 1.7 - 3.0).collect();
            let path = folder.path().join(name);
            std::fs::write(&path, encode_numbers(&path, width, height, &numbers).unwrap()).unwrap();
            let read = read_numbers(&path).unwrap();
            assert_eq!((read.width, read.height), (width, height));
            assert!(read.numbers == numbers, "{name}");
        }
    }

    #[test]
    fn the_first_row_of_a_pfm_is_at_the_bottom() {
        let mut bytes = b"PF\n1 2\n1.0\n".to_vec();
        (0..6).for_each(|n| bytes.extend((n as f32).to_be_bytes()));
        assert_eq!(parse_pfm(&bytes).unwrap().numbers, [3.0, 4.0, 5.0, 0.0, 1.0, 2.0]);
    }

    #[test]
    fn broken_pfm_files_are_refused() {
        for bytes in [
            b"" as &[u8],
            b"Pf\n1 1\n-1.0\n",
            b"PF\n1 1\n-1.0\n123",
            b"PF\n0 0\n-1.0\n",
            b"PF\n4294967295 4294967295\n-1.0\nx",
            b"PF\n1 1\n-1.0",
        ] {
            assert!(parse_pfm(bytes).is_err());
        }
    }

    #[test]
    fn what_is_wrong_with_a_pfm_is_said() {
        let said = |head: &str| parse_pfm(&[head.as_bytes(), &[0; 12]].concat()).map(|_| ()).unwrap_err();
        for (head, message) in [
            ("PF\n1 1\n0\n", "has a scale of 0: expected a number below 0"),
            ("PF\n1 1\n-0.0\n", "has a scale of -0: "),
            ("PF\n1 1\nnan\n", "has a scale of NaN: "),
            ("PF\n1 1\ninf\n", "has a scale of inf: "),
            ("PF\n0 5\n-1\n", "has no pixels: its size is 0 x 5"),
            ("PF\n-1 5\n-1\n", "has no width, height and scale"),
            ("PF\n1 2\n-1\n", "has 12 bytes of numbers, and 1 x 2 pixels take 24"),
            ("Pf\n1 3\n-1\n", "has one channel: three are needed"),
            ("\u{89}PNG", "this is no PFM picture: the file is a PNG picture"),
        ] {
            assert!(said(head).contains(message), "{head}: {}", said(head));
        }
    }

    /// The first byte of the numbers is that of a space.
    #[test]
    fn a_pfm_with_other_ends_of_lines_is_read() {
        let data: Vec<u8> = [10.0_f32, f32::from_le_bytes(*b"\r\n\r\n"), 3.0].map(f32::to_le_bytes).concat();
        for head in ["PF\n1 1\n-1.0\n", "PF\r\n1 1\r\n-1.0\r\n", "PF 1\n1 -1.0\r", "PF\n1  1\n-1\n"] {
            let read = parse_pfm(&[head.as_bytes(), &data].concat()).unwrap();
            assert_eq!(read.numbers[0], 10.0, "{head:?}");
        }
    }
}
