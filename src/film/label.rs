//! The label of a picture file: a text by which parts of a picture find together, and finished work is recognised. It
//! stands in a text chunk of a PNG, and beside a `.pfm` or `.exr` in a file of the same name with `.part` behind it.

use crate::options::has_extension;
use png::Decoder;
use std::fs::File;
use std::io::{BufReader, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

/// The keyword of the text chunk.
pub(super) const KEYWORD: &str = "a2 part";

/// Returns the file beside a picture of numbers that holds its label; `None` for a PNG, which holds it itself.
pub(super) fn file_beside(picture: &Path) -> Option<PathBuf> {
    let mut name = picture.as_os_str().to_owned();
    name.push(".part");
    ["pfm", "exr"].iter().any(|extension| has_extension(picture, extension)).then(|| name.into())
}

/// Reads the label of a picture file; `None` if there is no such file, or it has no label.
pub fn read_label(picture: &Path) -> Option<String> {
    if let Some(path) = file_beside(picture) {
        /// More is no label.
        const LONGEST: u64 = 1 << 16;
        let mut text = String::new();
        let file = File::open(path).ok().filter(|_| picture.is_file())?;
        return file.take(LONGEST).read_to_string(&mut text).ok().map(|_| text);
    }
    let reader = Decoder::new(BufReader::new(File::open(picture).ok()?)).read_info().ok()?;
    let texts = &reader.info().uncompressed_latin1_text;
    texts.iter().find(|chunk| chunk.keyword == KEYWORD).map(|chunk| chunk.text.clone())
}

/// Returns whether a PNG or PFM file of a picture of this size is as long as it should be: one that was copied in part is
/// not.
pub fn is_whole(picture: &Path, (width, height): (u32, u32)) -> bool {
    let Ok(mut file) = File::open(picture) else { return false };
    if has_extension(picture, "pfm") {
        let numbers = 12 * u64::from(width) * u64::from(height);
        let header = super::numbers::pfm_header((width, height)).len() as u64;
        return file.metadata().is_ok_and(|metadata| metadata.len() == header + numbers);
    }
    /// The last chunk of every PNG.
    const END: &[u8; 12] = b"\0\0\0\0IEND\xae\x42\x60\x82";
    let mut end = [0; END.len()];
    let read = file.seek(SeekFrom::End(-(END.len() as i64))).and_then(|_| file.read_exact(&mut end));
    !has_extension(picture, "png") || (read.is_ok() && end == *END)
}
