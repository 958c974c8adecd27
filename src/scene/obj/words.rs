//! Words of OBJ lines to numbers: the one place that says what a coordinate and what a corner is.

use std::num::IntErrorKind;

/// Parses a coordinate: a decimal number, `nan` or `inf`.
pub(super) fn coordinate(word: &[u8]) -> Option<f32> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// The first part of a corner `i`, `i/j`, `i//k` or `i/j/k`, the number of its vertex. The others, texture coordinate
/// and normal, show in no picture, so they may be anything.
pub(super) fn vertex_part(corner: &[u8]) -> &[u8] {
    let end = corner.iter().position(|&byte| byte == b'/').unwrap_or(corner.len());
    &corner[..end]
}

/// Parses the number of a vertex as written: from 1, or from -1 backwards. What is too large for an `i64` becomes the
/// largest: no file has so many vertices.
pub(super) fn vertex_number(part: &[u8]) -> Option<i64> {
    match std::str::from_utf8(part).ok()?.parse() {
        Ok(number) => Some(number),
        Err(error) => match error.kind() {
            IntErrorKind::PosOverflow => Some(i64::MAX),
            IntErrorKind::NegOverflow => Some(i64::MIN),
            _ => None,
        },
    }
}

/// Parses a vertex number from 1 to 999,999,999 and nothing else, for speed.
#[inline]
pub(super) fn plain_vertex_number(digits: &[u8]) -> Option<u32> {
    if digits.is_empty() || digits.len() > 9 {
        return None;
    }
    let mut value = 0;
    for &digit in digits {
        value = 10 * value + u32::from(digit.is_ascii_digit().then(|| digit - b'0')?);
    }
    (value > 0).then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_read_as_far_as_they_matter() {
        for corner in ["7", "7/", "7/1", "7//-nan(ind)", "7/1/2/3"] {
            assert_eq!(vertex_number(vertex_part(corner.as_bytes())), Some(7), "{corner}");
            assert_eq!(plain_vertex_number(vertex_part(corner.as_bytes())), Some(7), "{corner}");
        }
        for corner in ["", "/7", "a", "1.0", "1e2", "\u{663}", "--1"] {
            assert_eq!(vertex_number(vertex_part(corner.as_bytes())), None, "{corner}");
        }
    }

    #[test]
    fn numbers_that_are_not_plain_are_left_to_the_other_parser() {
        for (part, number) in [("0", 0), ("-2", -2), ("+3", 3), ("1234567890", 1_234_567_890)] {
            assert_eq!(
                (plain_vertex_number(part.as_bytes()), vertex_number(part.as_bytes())),
                (None, Some(number))
            );
        }
        assert_eq!(vertex_number(b"99999999999999999999"), Some(i64::MAX));
        assert_eq!(vertex_number(b"-99999999999999999999"), Some(i64::MIN));
    }

    #[test]
    fn what_other_programs_print_for_no_number_is_no_coordinate() {
        for word in ["3.1+e2", "1.#QNAN", "-nan(ind)", "0,5", "1.0f", ""] {
            assert_eq!(coordinate(word.as_bytes()), None, "{word}");
        }
        assert_eq!(coordinate(b"-.5e-1"), Some(-0.05));
    }
}
