//! Bytes of an OBJ file in, text out: UTF-8 or UTF-16, with LF or CRLF at the ends of lines.
//!
//! Refuses nothing. Bytes that are no text become U+FFFD: in names and comments they do no harm, and in numbers they are
//! reported with their line.

use crate::file_kind::utf16_is_big_endian;

/// The mark that editors put before UTF-8.
pub(super) const UTF8_MARK: &[u8] = b"\xef\xbb\xbf";

/// Decodes the bytes of a text file. A CR without LF ends a line, as on old machines, and becomes LF.
pub(super) fn decode(bytes: &[u8]) -> String {
    let mut text = match utf16_units(bytes) {
        Some(units) => {
            let chars = char::decode_utf16(units).map(|unit| unit.unwrap_or(char::REPLACEMENT_CHARACTER));
            chars.collect::<String>().into_bytes()
        }
        None => bytes.strip_prefix(UTF8_MARK).unwrap_or(bytes).to_vec(),
    };
    for at in 0..text.len() {
        if text[at] == b'\r' && text.get(at + 1) != Some(&b'\n') {
            text[at] = b'\n';
        }
    }
    String::from_utf8(text).unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned())
}

/// The code units of a UTF-16 text without its mark; `None` if the bytes are something else.
fn utf16_units(bytes: &[u8]) -> Option<impl Iterator<Item = u16>> {
    let (big_endian, body) = match bytes {
        [0xff, 0xfe, body @ ..] => (false, body),
        [0xfe, 0xff, body @ ..] => (true, body),
        _ => (utf16_is_big_endian(bytes)?, bytes),
    };
    let unit = move |pair: &[u8]| {
        let pair = [pair[0], pair[1]];
        if big_endian { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) }
    };
    Some(body.chunks_exact(2).map(unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "v 1 2 3 # é\nf 1";

    fn utf16(text: &str, mark: &[u8], bytes_of: impl Fn(u16) -> [u8; 2]) -> Vec<u8> {
        mark.iter().copied().chain(text.encode_utf16().flat_map(bytes_of)).collect()
    }

    #[test]
    fn every_encoding_gives_the_same_text() {
        assert_eq!(decode(TEXT.as_bytes()), TEXT);
        assert_eq!(decode(&[UTF8_MARK, TEXT.as_bytes()].concat()), TEXT);
        for mark in [true, false] {
            for text in [TEXT, "g 中文\nv 1", "# 一丁丂模型文件\n# by hand\nv 1 2 3\n", "f\n"] {
                assert_eq!(decode(&utf16(text, if mark { b"\xff\xfe" } else { b"" }, u16::to_le_bytes)), text);
                assert_eq!(decode(&utf16(text, if mark { b"\xfe\xff" } else { b"" }, u16::to_be_bytes)), text);
            }
        }
    }

    #[test]
    fn a_text_cut_in_the_middle_is_still_text() {
        assert_eq!(decode(b"\xff\xfev\0 \0\xd8"), "v ");
        assert_eq!(decode(b"\xff\xfev\0\0\xd8"), "v\u{fffd}");
        assert_eq!(decode(b"v 1 \xff"), "v 1 \u{fffd}");
        assert_eq!(decode(b"\0\0"), "\0\0");
    }

    #[test]
    fn all_ends_of_lines_are_seen() {
        assert_eq!(decode(b"a\rb\r\nc\n\rd\r"), "a\nb\r\nc\n\nd\n");
    }
}
