//! Parses plain OBJ files by all threads in parallel.
//!
//! A plain file consists of `v x y z` and `f` with positive indices, as nearly all files do; other lines are skipped. At
//! anything else, mistakes included, this parser gives up. Then [`clean`](super::clean) parses the file, about ten times
//! slower. Both give the same mesh.

use super::statements::Kind;
use super::words::{coordinate, plain_vertex_number, vertex_part};
use super::{Faces, Polygon};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Size of a piece of a file in bytes, about.
const PIECE: usize = 1 << 18;

/// The content of a piece of a file.
#[derive(Default)]
struct Piece {
    positions: Vec<[f32; 3]>,
    /// Indices of positions, from 0.
    triangles: Vec<[u32; 3]>,
    /// Triangles and faces are numbered within the piece.
    polygons: Vec<Polygon>,
    faces: usize,
    points: usize,
    lines: usize,
}

/// Parses an OBJ file. `None` if the file is not plain, or has no face.
pub(super) fn read(bytes: &[u8]) -> Option<Faces> {
    let pieces: Option<Vec<Piece>> = pieces(bytes).into_par_iter().map(Piece::read).collect();
    let pieces = pieces?;
    let positions = joined(&pieces, |piece| &piece.positions);
    let triangles = joined(&pieces, |piece| &piece.triangles);
    let polygons = joined_polygons(&pieces);
    let sum = |count: fn(&Piece) -> usize| pieces.iter().map(count).sum();
    let (faces, points, lines) = (sum(|piece| piece.faces), sum(|piece| piece.points), sum(|piece| piece.lines));
    let vertices = positions.len();
    let is_used: Vec<AtomicBool> = positions.iter().map(|_| AtomicBool::new(false)).collect();
    let use_position =
        |&corner: &u32| is_used.get(corner as usize).map(|used| used.store(true, Ordering::Relaxed));
    let use_corners = |corners: &[u32; 3]| corners.iter().all(|corner| use_position(corner).is_some());
    // To give memory back takes a while, too.
    let (are_in_range, ()) = rayon::join(|| triangles.par_iter().all(use_corners), || drop(pieces));
    if triangles.is_empty() || !are_in_range {
        return None;
    }
    let is_used: Vec<bool> = is_used.into_iter().map(AtomicBool::into_inner).collect();
    let (positions, triangles) = without_unused(positions, triangles, &is_used);
    let is_finite = |position: &[f32; 3]| position.iter().all(|coordinate| coordinate.is_finite());
    let all_finite = positions.par_iter().all(is_finite);
    all_finite.then_some(Faces { positions, triangles, polygons, vertices, faces, points, lines })
}

/// The polygons of all pieces, numbered in the file.
fn joined_polygons(pieces: &[Piece]) -> Vec<Polygon> {
    let (mut first_triangle, mut first_face) = (0, 0);
    let mut all = Vec::new();
    for piece in pieces {
        all.extend(piece.polygons.iter().map(|polygon| Polygon {
            first_triangle: first_triangle + polygon.first_triangle,
            face: first_face + polygon.face,
            ..*polygon
        }));
        first_triangle += piece.triangles.len();
        first_face += piece.faces;
    }
    all
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

fn without_unused(
    positions: Vec<[f32; 3]>,
    mut triangles: Vec<[u32; 3]>,
    is_used: &[bool],
) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
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
            // A CR within the line ends a line. It becomes part of a word here, and no such word is read.
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            let mut words = line.split(|byte| matches!(byte, b' ' | b'\t')).filter(|word| !word.is_empty());
            let is_whole = match words.next() {
                None => true,
                Some(b"v") => {
                    piece.positions.push(position(&mut words)?);
                    words.next().is_none()
                }
                Some(b"f" | b"fo") => piece.face(&mut words)?,
                // Not a keyword in ASCII: there may be white space that is not looked for here.
                Some(word) if !word[0].is_ascii_graphic() => return None,
                Some(b"vt" | b"vn" | b"vp") => false,
                Some(keyword) => {
                    piece.other(keyword, &mut words)?;
                    false
                }
            };
            if !is_whole && hides_more(line) {
                return None;
            }
        }
        Some(piece)
    }

    /// Counts points and lines. Gives up at what is in no picture and must be reported.
    fn other<'a>(&mut self, keyword: &[u8], words: &mut impl Iterator<Item = &'a [u8]>) -> Option<()> {
        if matches!(keyword, [b'#', ..] | b"g" | b"o" | b"s" | b"usemtl" | b"mtllib") {
            return Some(());
        }
        if matches!(keyword[0], b'v' | b'f') || !keyword.iter().all(is_plain) {
            return None;
        }
        match Kind::of(keyword) {
            Kind::Line => self.lines += 1,
            Kind::Points => {
                for word in words {
                    self.points += word.iter().all(is_plain).then_some(1)?;
                }
            }
            Kind::Other => {}
            _ => return None,
        }
        Some(())
    }

    /// Parses a face. A polygon becomes a fan of triangles around its first corner. Returns whether it ends with the line, and not with a comment.
    fn face<'a>(&mut self, words: &mut impl Iterator<Item = &'a [u8]>) -> Option<bool> {
        let first = corner(words.next()?)?;
        let mut second = corner(words.next()?)?;
        let mut third = corner(words.next()?)?;
        let (first_triangle, face) = (self.triangles.len(), self.faces);
        self.faces += 1;
        let ends_with_line = loop {
            self.triangles.push([first, second, third]);
            match words.next() {
                None => break true,
                Some(word) if word[0] == b'#' => break false,
                Some(word) => (second, third) = (third, corner(word)?),
            }
        };
        let triangles = self.triangles.len() - first_triangle;
        if triangles > 1 {
            self.polygons.push(Polygon { first_triangle, triangles, face });
        }
        Some(ends_with_line)
    }
}

/// Whether the part of a line that is not looked at may hold other lines, or go on in the next one.
fn hides_more(line: &[u8]) -> bool {
    line.contains(&b'\r')
        || (line.trim_ascii_end().ends_with(b"\\") && matches!(line.trim_ascii_start()[0], b'v' | b'f'))
}

/// Parses a corner, and returns the index of its position, from 0. Anything may stand behind the first `/`.
fn corner(word: &[u8]) -> Option<u32> {
    let part = vertex_part(word);
    let number = plain_vertex_number(part)?;
    word[part.len()..].iter().all(is_plain).then_some(number - 1)
}

/// Whether a byte is part of a word only: it begins no comment, ends no line that goes on, and is no white space that is not
/// looked for here.
fn is_plain(byte: &u8) -> bool {
    byte.is_ascii_graphic() && !matches!(byte, b'#' | b'\\')
}

/// Parses the next three words as coordinates.
fn position<'a>(words: &mut impl Iterator<Item = &'a [u8]>) -> Option<[f32; 3]> {
    let mut next = || coordinate(words.next()?);
    Some([next()?, next()?, next()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_files_are_parsed() {
        let text = b"# c\n v 0 0 0\r\nv 9 9 9\nv 1 0 0 1 1 1 # red\nvt\nv 1 1 .5e0\nv 0 1 0\ng \xe9\nl 1 2 \xe9\np 1 2\tx\n#l\nKd 1 2\nfo 1/x 3 4/-9 5// #\n";
        let faces = read(text).unwrap();
        assert_eq!(faces.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, 0.0]]);
        assert_eq!(faces.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!((faces.vertices, faces.faces, faces.points, faces.lines), (5, 1, 3, 1));
        assert_eq!(faces.polygons, [Polygon { first_triangle: 0, triangles: 2, face: 0 }]);
    }

    #[test]
    fn faces_may_use_positions_of_other_pieces() {
        let vertices: String = (0..30_000).map(|i| format!("v {i} 0.5 -1\n")).collect();
        let faces: String = (1..29_998).map(|i| format!("f {i} {} {} {}\n", i + 1, i + 2, i + 3)).collect();
        let read = read(format!("{vertices}{faces}").as_bytes()).unwrap();
        assert_eq!((read.positions.len(), read.positions[29_999][0]), (30_000, 29_999.0));
        assert_eq!((read.triangles.len(), read.triangles[59_993]), (59_994, [29_996, 29_998, 29_999]));
        assert_eq!(read.polygons[29_996], Polygon { first_triangle: 59_992, triangles: 2, face: 29_996 });
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
            "f 1 2 /1",
            "v 1 2",
            "v 1 2 nan\nf 1 2 4",
            "v 1 2 3#4",
            "v 1 2 3 4 \\\n5",
            "v 1 2 3\\\n4",
            "f 1 2 3 \\\n1",
            "f 1 2 3 # \\\n1",
            "v 1 2 3\rv 4 5 6",
            "# a\rf 1 2 3",
            "f 1 2 3 #\rf 1 2 3",
            "\u{feff}v 1 2 3",
            "\u{b}v 1 2 3",
            "fa 1 2 3",
            "F 1 2 3",
            "F",
            "f1 2 3",
            "surf 0 1 0 1 1 2 3",
            "bzp 1 2 3",
            "call m.obj",
            "<<<<<<< HEAD",
            "l#",
            "l\u{a0}1 2",
            "p 1 2 # c",
            "p 1\u{a0}2",
            "p 1 \\",
            "f 1 2 \u{663}",
            "f 1 2 3/\u{b}4",
            "f 1 2 3/1\u{a0}4/1",
            "f 1 2 3/1#4 2",
            "f 1 2 3/\\\n4",
            "f 1 2 3\r1",
            "f 1/1 2/2 3/\r1 2",
            "v 1\r2 3",
            "v 1\u{c}2 3",
        ] {
            assert!(read(format!("{THREE}f 1 2 3\n{rest}\n").as_bytes()).is_none(), "{rest}");
        }
        assert!(read(THREE.as_bytes()).is_none());
    }
}
