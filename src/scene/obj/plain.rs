//! Parses plain OBJ files by all threads in parallel.
//!
//! A plain file consists of `v x y z`, `vt`, `vn` and `f` with positive indices, as nearly all files do. At anything
//! else, mistakes included, this parser gives up. Then [`obj`](super) parses the file with `tobj`,
//! about ten times slower. Both give the same mesh.

use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Positions and triangles of a mesh.
pub type Geometry = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// Size of a piece of a file in bytes, about.
const PIECE: usize = 1 << 18;

/// The content of a piece of a file.
#[derive(Default)]
struct Piece {
    positions: Vec<[f32; 3]>,
    /// Indices of positions, from 0.
    triangles: Vec<[u32; 3]>,
    /// For texture coordinates and for normals: their number, and the largest index (from 1) in a face.
    others: [(usize, usize); 2],
}

/// Parses an OBJ file. Positions that no triangle uses are dropped. `None` if the file is not plain.
pub fn read(bytes: &[u8]) -> Option<Geometry> {
    let pieces: Option<Vec<Piece>> = pieces(bytes).into_par_iter().map(Piece::read).collect();
    let pieces = pieces?;
    let positions = joined(&pieces, |piece| &piece.positions);
    for kind in 0..2 {
        let count: usize = pieces.iter().map(|piece| piece.others[kind].0).sum();
        if pieces.iter().any(|piece| piece.others[kind].1 > count) {
            return None;
        }
    }
    let triangles = joined(&pieces, |piece| &piece.triangles);
    drop(pieces);
    let is_used: Vec<AtomicBool> = positions.iter().map(|_| AtomicBool::new(false)).collect();
    let use_position =
        |&corner: &u32| is_used.get(corner as usize).map(|used| used.store(true, Ordering::Relaxed));
    let use_corners = |corners: &[u32; 3]| corners.iter().all(|corner| use_position(corner).is_some());
    if !triangles.par_iter().all(use_corners) {
        return None;
    }
    let is_used: Vec<bool> = is_used.into_iter().map(AtomicBool::into_inner).collect();
    let (positions, triangles) = without_unused(positions, triangles, &is_used);
    let is_finite = |position: &[f32; 3]| position.iter().all(|coordinate| coordinate.is_finite());
    positions.par_iter().all(is_finite).then_some((positions, triangles))
}

/// Joins one part of all pieces.
fn joined<T: Copy + Default + Send + Sync>(pieces: &[Piece], part: impl Fn(&Piece) -> &Vec<T> + Sync) -> Vec<T> {
    let mut all = vec![T::default(); pieces.iter().map(|piece| part(piece).len()).sum()];
    let mut rest = all.as_mut_slice();
    let mut places = Vec::with_capacity(pieces.len());
    for piece in pieces {
        let (place, after) = rest.split_at_mut(part(piece).len());
        places.push((place, part(piece)));
        rest = after;
    }
    places.into_par_iter().for_each(|(place, part)| place.copy_from_slice(part));
    all
}

/// Cuts a text into pieces at ends of lines.
fn pieces(mut rest: &[u8]) -> Vec<&[u8]> {
    let mut pieces = Vec::new();
    while rest.len() > PIECE {
        let line_end = rest[PIECE..].iter().position(|&byte| byte == b'\n');
        let (piece, after) = rest.split_at(line_end.map_or(rest.len(), |end| PIECE + end + 1));
        pieces.push(piece);
        rest = after;
    }
    pieces.push(rest);
    pieces
}

fn without_unused(positions: Vec<[f32; 3]>, mut triangles: Vec<[u32; 3]>, is_used: &[bool]) -> Geometry {
    if is_used.iter().all(|&used| used) {
        return (positions, triangles);
    }
    let mut kept = 0;
    let new_number: Vec<u32> = is_used
        .iter()
        .map(|&used| {
            kept += u32::from(used);
            kept.wrapping_sub(1)
        })
        .collect();
    for corner in triangles.as_flattened_mut() {
        *corner = new_number[*corner as usize];
    }
    let used = positions.into_iter().zip(is_used).filter(|(_, used)| **used);
    (used.map(|(position, _)| position).collect(), triangles)
}

impl Piece {
    fn read(text: &[u8]) -> Option<Self> {
        let mut piece = Self::default();
        for line in text.split(|&byte| byte == b'\n') {
            let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
            match words.next() {
                Some(b"v") => piece.positions.push(numbers(&mut words)?),
                Some(b"vt") => {
                    numbers::<2>(&mut words)?;
                    piece.others[0].0 += 1;
                    // A third coordinate is ignored.
                    continue;
                }
                Some(b"vn") => {
                    numbers::<3>(&mut words)?;
                    piece.others[1].0 += 1;
                }
                Some(b"f") => piece.face(&mut words)?,
                Some(word) if matches!(word[0], b'v' | b'f') => return None,
                _ => continue,
            }
            if words.next().is_some() {
                return None;
            }
        }
        Some(piece)
    }

    /// Parses a face. A polygon becomes a fan of triangles around its first corner.
    fn face<'a>(&mut self, words: &mut impl Iterator<Item = &'a [u8]>) -> Option<()> {
        let first = self.corner(words.next()?)?;
        let mut second = self.corner(words.next()?)?;
        let mut third = self.corner(words.next()?)?;
        loop {
            self.triangles.push([first, second, third]);
            let Some(word) = words.next() else { return Some(()) };
            (second, third) = (third, self.corner(word)?);
        }
    }

    /// Parses a corner, `i`, `i/j`, `i//k` or `i/j/k`, and returns the index of its position, from 0.
    fn corner(&mut self, word: &[u8]) -> Option<u32> {
        let mut parts = word.split(|&byte| byte == b'/');
        let position = index(parts.next()?)?;
        for other in &mut self.others {
            match parts.next() {
                None => break,
                Some(b"") => {}
                Some(part) => other.1 = other.1.max(index(part)? as usize),
            }
        }
        parts.next().is_none().then(|| position - 1)
    }
}

/// Parses the next `N` words as numbers.
fn numbers<'a, const N: usize>(words: &mut impl Iterator<Item = &'a [u8]>) -> Option<[f32; N]> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = std::str::from_utf8(words.next()?).ok()?.parse().ok()?;
    }
    Some(numbers)
}

/// Parses a number from 1 to 999,999,999.
fn index(digits: &[u8]) -> Option<u32> {
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
    fn plain_files_are_parsed() {
        let text = b"# c\n v 0 0 0\r\nv 9 9 9\nv 1 0 0\nvt 0 1\nv 1 1 .5e0\nv 0 1 0\ng a\nf 1/1 3 4 5//\n";
        let (positions, triangles) = read(text).unwrap();
        assert_eq!(positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, 0.0]]);
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn faces_may_use_positions_of_other_pieces() {
        let vertices: String = (0..30_000).map(|i| format!("v {i} 0.5 -1\n")).collect();
        let faces: String = (1..29_999).map(|i| format!("f {i} {} {}\n", i + 1, i + 2)).collect();
        let (positions, triangles) = read(format!("{vertices}{faces}").as_bytes()).unwrap();
        assert_eq!((positions.len(), positions[29_999][0]), (30_000, 29_999.0));
        assert_eq!((triangles.len(), triangles[29_997]), (29_998, [29_997, 29_998, 29_999]));
    }

    #[test]
    fn files_that_are_not_plain_are_refused() {
        const THREE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        for rest in [
            "f 1 2",
            "f 1 2 4",
            "f -1 -2 -3",
            "f 1 2 0",
            "f 1 2 x",
            "f 1/1 2 3",
            "f 1//1 2 3",
            "f 1/1/1/1 2 3",
            "v 1 2",
            "v 1 2 3 4",
            "v 1 2 nan\nf 1 2 4",
            "vt 1",
            "vn 1 2",
            "vp 1 2 3",
            "fo 1 2 3",
            "f 1 2 \u{663}",
        ] {
            assert!(read(format!("{THREE}{rest}\n").as_bytes()).is_none(), "{rest}");
        }
    }
}
