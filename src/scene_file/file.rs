//! Reads a scene file and decodes its text.

use super::lexer::Lexer;
use super::parser::{Parsed, parse};
use crate::error::{Error, SourceText};
use crate::file_kind::utf16_is_big_endian;
use crate::file_path::{self, Kind};
use crate::input::{is_standard, read_standard_input, read_whole};
use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;

/// Largest scene file that is read.
const MAX_FILE_BYTES: u64 = 1 << 30;
/// What messages call standard input.
const STANDARD_INPUT: &str = "standard input";

/// Reads and parses the scene file at `path`; `-` is standard input.
///
/// # Errors
/// [`Error::File`] when the file cannot be read, [`Error::Source`] when it is not UTF-8.
pub fn parse_file(path: &Path) -> Result<Parsed, Error> {
    let (path, bytes) = if is_standard(path) {
        (Path::new(STANDARD_INPUT), read_standard_input(MAX_FILE_BYTES))
    } else if path.is_dir() {
        return Err(Error::file(path, "this is a folder, not a scene file"));
    } else {
        (path, read_whole(path, MAX_FILE_BYTES))
    };
    let bytes = bytes.map_err(|error| match error.kind() {
        ErrorKind::NotFound => {
            let there = file_path::what_is_there(Path::new(""), &path.to_string_lossy(), Kind::File);
            Error::file(path, format!("cannot read the scene: {error}\nhelp: {there}"))
        }
        _ => Error::io(path, "read the scene", &error),
    })?;
    Ok(parse(SourceText { path: path.to_owned(), text: decoded(path, bytes)? }))
}

/// Returns the text of a file. Bytes that are not UTF-8 do not matter in comments.
///
/// # Errors
/// [`Error::Source`] for the first word with such bytes, [`Error::File`] for UTF-16.
fn decoded(path: &Path, mut bytes: Vec<u8>) -> Result<String, Error> {
    if is_utf16(&bytes) {
        return Err(Error::file(path, "this is UTF-16 text: save the file as UTF-8"));
    }
    // Some old programs end a text with these.
    let is_end = |byte: &u8| matches!(byte, 0 | 0x1a) || byte.is_ascii_whitespace();
    if let Some(0 | 0x1a) = bytes.iter().rev().find(|byte| !byte.is_ascii_whitespace()) {
        bytes.truncate(bytes.iter().rposition(|byte| !is_end(byte)).map_or(0, |last| last + 1));
    }
    let error = match String::from_utf8(bytes) {
        Ok(text) => return Ok(text),
        Err(error) => error,
    };
    let bytes = error.as_bytes();
    let text = String::from_utf8_lossy(bytes).into_owned();
    let broken = Lexer::new(&text).find(|word| word.text.contains(char::REPLACEMENT_CHARACTER));
    let Some(span) = broken.map(|word| word.span) else { return Ok(text) };
    let found = if is_gbk(bytes) { "not UTF-8 text, but probably GBK" } else { "not UTF-8 text" };
    let source = Arc::new(SourceText { path: path.to_owned(), text });
    let error = source.error(span, format!("this is {found}: save the file as UTF-8"));
    Err(error.with_note("only comments may have such characters"))
}

/// Returns whether bytes are UTF-16 text, also without the mark.
fn is_utf16(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") || utf16_is_big_endian(bytes).is_some()
}

/// Returns whether all bytes outside of ASCII are pairs as GBK has them.
fn is_gbk(bytes: &[u8]) -> bool {
    let mut rest = bytes.iter();
    while let Some(first) = rest.next() {
        let is_pair = || matches!((first, rest.clone().next()), (0x81..=0xfe, Some(0x40..=0x7e | 0x80..=0xfe)));
        if !first.is_ascii() {
            if !is_pair() {
                return false;
            }
            rest.next();
        }
    }
    true
}
