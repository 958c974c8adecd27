//! Pictures of `f32` numbers instead of bytes, for errors to be measured before clamping and truncation: PFM, written
//! here, and OpenEXR (cargo feature `exr`).
//!
//! PFM (Debevec's portable float map): `PF`, width and height, `-1.0` for little-endian, then three `f32` a pixel, rows
//! from the bottom.

#[cfg(feature = "exr")]
use super::exr::ExrEncoder;
use crate::error::Error;
use crate::options::has_extension;
use crate::picture_file::{PictureFile, read_bytes};
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
        read_bytes(path).and_then(|bytes| parse_pfm(&bytes).map_err(str::to_owned))
    } else {
        PictureFile::open(path).and_then(PictureFile::decode).map(|picture| {
            let picture = picture.into_rgb32f();
            NumberPicture { width: picture.width(), height: picture.height(), numbers: picture.into_raw() }
        })
    };
    picture.map_err(|message| Error::file(path, message))
}

fn parse_pfm(bytes: &[u8]) -> Result<NumberPicture, &'static str> {
    // Four words, each ended by one white space character. The rest is data, which may contain such bytes too.
    let mut words = bytes.splitn(5, |byte| byte.is_ascii_whitespace());
    let mut text = || words.next().and_then(|word| std::str::from_utf8(word).ok());
    if text() != Some("PF") {
        return Err("this is no PFM picture of three channels: it does not begin with PF");
    }
    let (width, height) = (text().and_then(|w| w.parse::<u32>().ok()), text().and_then(|h| h.parse::<u32>().ok()));
    let scale = text().and_then(|scale| scale.parse::<f32>().ok());
    let (Some(width @ 1..), Some(height @ 1..), Some(scale)) = (width, height, scale) else {
        return Err("this PFM picture has no width, height and scale");
    };
    let data = words.next().unwrap_or_default();
    let row_bytes = 12 * width as usize;
    if row_bytes.checked_mul(height as usize) != Some(data.len()) {
        return Err("this PFM picture is shorter or longer than its width and height say");
    }
    let number = if scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
    let numbers =
        data.chunks_exact(row_bytes).rev().flat_map(|row| row.as_chunks().0).map(|&n| number(n)).collect();
    Ok(NumberPicture { width, height, numbers })
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
        ] {
            assert!(parse_pfm(bytes).is_err());
        }
    }
}
