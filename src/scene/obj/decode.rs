//! Bytes of an OBJ file in, text out: UTF-8 or UTF-16, with LF or CRLF at the ends of lines.
//!
//! Refuses nothing. Bytes that are no text become U+FFFD: in names and comments they do no harm, and in numbers they are
//! reported with their line.

/// The mark that editors put before UTF-8.
pub(super) const UTF8_MARK: &[u8] = b"\xef\xbb\xbf";

/// How many bytes are looked at to recognise UTF-16 without a mark.
const LOOKED_AT: usize = 64;

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
        _ => (is_big_endian(bytes)?, bytes),
    };
    let unit = move |pair: &[u8]| {
        let pair = [pair[0], pair[1]];
        if big_endian { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) }
    };
    Some(body.chunks_exact(2).map(unit))
}

/// Recognises UTF-16 without a mark: what OBJ files consist of is ASCII, so every other byte is 0.
fn is_big_endian(bytes: &[u8]) -> Option<bool> {
    let start = &bytes[..bytes.len().min(LOOKED_AT) & !1];
    if start.len() < 4 {
        return None;
    }
    let all =
        |first: bool, second: bool| start.chunks(2).all(|pair| (pair[0] == 0, pair[1] == 0) == (first, second));
    if all(true, false) {
        return Some(true);
    }
    all(false, true).then_some(false)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "v 1 2 3 # é\nf 1";

    fn utf16(mark: &[u8], bytes_of: impl Fn(u16) -> [u8; 2]) -> Vec<u8> {
        mark.iter().copied().chain(TEXT.encode_utf16().flat_map(bytes_of)).collect()
    }

    #[test]
    fn every_encoding_gives_the_same_text() {
        assert_eq!(decode(TEXT.as_bytes()), TEXT);
        assert_eq!(decode(&[UTF8_MARK, TEXT.as_bytes()].concat()), TEXT);
        for mark in [true, false] {
            assert_eq!(decode(&utf16(if mark { b"\xff\xfe" } else { b"" }, u16::to_le_bytes)), TEXT);
            assert_eq!(decode(&utf16(if mark { b"\xfe\xff" } else { b"" }, u16::to_be_bytes)), TEXT);
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
