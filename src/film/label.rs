//! The label of a picture file: a text by which parts of a picture find together, and finished work is recognised. It
//! stands in a text chunk of a PNG, and beside a `.pfm` or `.exr` in a file of the same name with `.part` behind it, which
//! holds the picture's checksum, too.

use crate::options::format_of_numbers;
use crate::picture_file::{checksum, has_right_checksums};
use png::Decoder;
use std::fs::File;
use std::io::{self, BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};

/// The keyword of the text chunk.
pub(super) const KEYWORD: &str = "a2 part";

/// Returns the file beside a picture of numbers that holds its label; `None` for a PNG, which holds it itself.
pub fn file_beside(picture: &Path) -> Option<PathBuf> {
    let mut name = picture.as_os_str().to_owned();
    name.push(".part");
    format_of_numbers(picture).map(|_| name.into())
}

/// Stands in a file beside a picture between its label and the picture's checksum.
const CHECKSUM: &str = "\nchecksum ";

/// Returns the text of the file beside a picture of numbers.
pub(super) fn text_beside(label: &str, picture: &Path) -> io::Result<String> {
    Ok(format!("{label}{CHECKSUM}{:08x}\n", checksum(BufReader::new(File::open(picture)?))?))
}

/// Reads the label of a picture file; `None` if there is no such file, or it has no label.
pub fn read_label(picture: &Path) -> Option<String> {
    if file_beside(picture).is_some() {
        return read_beside(picture).map(|(label, _)| label);
    }
    let reader = Decoder::new(BufReader::new(File::open(picture).ok()?)).read_info().ok()?;
    let texts = &reader.info().uncompressed_latin1_text;
    texts.iter().find(|chunk| chunk.keyword == KEYWORD).map(|chunk| chunk.text.clone())
}

/// Reads the label and the checksum of a picture of numbers.
fn read_beside(picture: &Path) -> Option<(String, u32)> {
    /// More is no label.
    const LONGEST: u64 = 1 << 16;
    let mut text = String::new();
    let file = File::open(file_beside(picture)?).ok().filter(|_| picture.is_file())?;
    file.take(LONGEST).read_to_string(&mut text).ok()?;
    let (label, checksum) = text.rsplit_once(CHECKSUM)?;
    Some((label.to_owned(), u32::from_str_radix(checksum.trim_end(), 16).ok()?))
}

/// Returns whether a picture file with a label is as it was written: no byte is missing or has changed, and
/// none stands behind its end.
pub fn is_whole(picture: &Path) -> bool {
    let Ok(mut file) = File::open(picture).map(BufReader::new) else { return false };
    let is_whole = match file_beside(picture) {
        Some(_) => checksum(file).map(|found| read_beside(picture).is_some_and(|(_, written)| written == found)),
        None => has_right_checksums(&mut file).and_then(|right| Ok(right && file.fill_buf()?.is_empty())),
    };
    is_whole.is_ok_and(|is_whole| is_whole)
}
