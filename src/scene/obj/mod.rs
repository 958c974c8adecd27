//! Parses OBJ files into [`Mesh`]es: plain files by [`plain`], all others by `tobj`.
//!
//! Only positions are used: normals are always computed from them, and texture coordinates are not needed.

mod plain;

use crate::error::{Error, SourceText, Span};
use crate::objects::Mesh;
use std::path::Path;
use std::sync::Arc;

/// Parses the bytes of the OBJ file at `path`.
///
/// # Errors
/// [`Error::Source`] for a mistake at a known line, [`Error::File`] for anything else.
pub fn parse_mesh(path: &Path, bytes: &[u8]) -> Result<Mesh, Error> {
    match plain::read(bytes) {
        Some((positions, triangles)) => Ok(Mesh::new(positions, triangles)),
        None => parse_any_mesh(path, bytes),
    }
}

fn parse_any_mesh(path: &Path, bytes: &[u8]) -> Result<Mesh, Error> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    let geometry = geometry_lines(bytes);
    let no_materials = |_: &Path| Err(tobj::LoadError::GenericFailure);
    let loaded = tobj::load_obj_buf(&mut &geometry[..], &options, no_materials);
    let (models, _) = loaded.map_err(|error| {
        diagnosed(path, bytes).unwrap_or_else(|| Error::file(path, format!("cannot read this mesh: {error}")))
    })?;
    let Some(model) = models.into_iter().next() else {
        // tobj drops a model without faces, and does not report its mistakes.
        return diagnosed(path, bytes).map_or_else(|| Ok(Mesh::new(Vec::new(), Vec::new())), Err);
    };
    let positions: Vec<[f32; 3]> = model.mesh.positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
    let triangles = model.mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    if positions.as_flattened().iter().all(|coordinate| coordinate.is_finite()) {
        return Ok(Mesh::new(positions, triangles));
    }
    Err(diagnosed(path, bytes).unwrap_or_else(|| Error::file(path, "a coordinate is not a finite number")))
}

/// Returns the lines of vertices and faces. At a group, object or material tobj would begin a new model with vertices
/// of its own, and smooth surfaces would get a visible seam.
fn geometry_lines(bytes: &[u8]) -> Vec<u8> {
    let mut kept = Vec::with_capacity(bytes.len());
    for line in bytes.split_inclusive(|&byte| byte == b'\n') {
        let word = line.trim_ascii_start();
        if matches!(word.first(), Some(b'v' | b'f')) {
            kept.extend_from_slice(word);
        }
    }
    kept
}

/// Finds the first line with a mistake, because tobj does not name it.
fn diagnosed(path: &Path, bytes: &[u8]) -> Option<Error> {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let source = Arc::new(SourceText { path: path.to_owned(), text });
    let vertex_count = source.text.lines().filter(|line| line.split_whitespace().next() == Some("v")).count();
    let mut vertices_so_far = 0;
    let mut line_start = 0;
    for line in source.text.split_inclusive('\n') {
        let mut words = Words { line, start: line_start, at: 0 };
        line_start += line.len();
        let keyword = words.next();
        let mistake = match keyword {
            Some(("v", span)) => {
                vertices_so_far += 1;
                vertex_mistake(span, words)
            }
            Some(("f", _)) => words.find_map(|(word, span)| {
                face_mistake(word, vertices_so_far, vertex_count).map(|message| (span, message))
            }),
            _ => None,
        };
        if let Some((span, message)) = mistake {
            return Some(source.error(span, message));
        }
    }
    None
}

fn vertex_mistake(keyword: Span, words: Words) -> Option<(Span, String)> {
    let mut count = 0;
    for (word, span) in words.take(3) {
        count += 1;
        if !word.parse::<f32>().is_ok_and(f32::is_finite) {
            return Some((span, format!("expected a finite coordinate, found '{word}'")));
        }
    }
    (count < 3).then(|| (keyword, format!("a vertex needs three coordinates, this one has {count}")))
}

fn face_mistake(corner: &str, vertices_so_far: usize, vertex_count: usize) -> Option<String> {
    let index = corner.split('/').next().unwrap_or_default();
    let Ok(index) = index.parse::<i64>() else {
        return Some(format!("expected a vertex number, found '{corner}'"));
    };
    let in_range = match index {
        0 => false,
        1.. => index as u64 <= vertex_count as u64,
        _ => index.unsigned_abs() <= vertices_so_far as u64,
    };
    (!in_range).then(|| format!("there is no vertex {index}: the file has {vertex_count}, numbered from 1"))
}

/// The words of a line with their places in the file.
struct Words<'a> {
    line: &'a str,
    start: usize,
    at: usize,
}

impl<'a> Iterator for Words<'a> {
    type Item = (&'a str, Span);

    fn next(&mut self) -> Option<Self::Item> {
        let rest = &self.line[self.at..];
        let word = rest.split_whitespace().next()?;
        self.at += rest.find(word)? + word.len();
        let end = self.start + self.at;
        Some((word, Span { start: end - word.len(), end }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vecmath::Vector3;

    fn mesh(text: &str) -> Mesh {
        parse_mesh(Path::new("m.obj"), text.as_bytes()).unwrap()
    }

    fn refusal(text: &str) -> String {
        parse_mesh(Path::new("m.obj"), text.as_bytes()).unwrap_err().to_string()
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn every_way_to_write_a_face_is_read() {
        for (faces, count) in [
            ("f 1 2 3\n", 1),
            ("f 1 2 3", 1),
            ("f 1 2 3\r\nf 1 3 4\r\n", 2),
            ("f 1 2 3 4\n", 2),
            ("f -4 -3 -2 -1\n", 2),
            ("vt 0 0\nvt 1 0\nf 1/1 2/2 3/1\n", 1),
            ("vn 0 0 1\nf 1//1 2//1 3//1\n", 1),
            ("vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\n", 1),
            ("g a\nf 1 2 3\ng b\no c\nusemtl d\ns 1\nf 1 3 4\n", 2),
            ("l 1 2\np 1\n  f 1 2 3\n# f 9 9 9\n", 1),
            ("", 0),
        ] {
            assert_eq!(mesh(&format!("{SQUARE}{faces}")).triangle_count(), count, "{faces:?}");
        }
    }

    #[test]
    fn surfaces_are_smooth_across_groups_and_texture_seams() {
        let roof = "v 0 0 0\nv 0 0 1\nv 1 0 0\nv 0 -1 0\nvt 0 0\nvt 1 1\n";
        let mesh = mesh(&format!("{roof}g one\nf 1/1 2/1 3/1\ng two\nf 1/2 4/2 2/2\n"));
        let normal = mesh.normal(0, [1.0, 0.0, 0.0]);
        let half = (0.5 as vecmath::Real).sqrt();
        assert!((normal - Vector3::new(-half, half, 0.0)).max_abs() < 1e-6, "{normal:?}");
    }

    #[test]
    fn both_readers_give_the_same_mesh() {
        let texts =
            ["", "v 0 0 0\n", "f 1 2 3\nv 7 7 7\nv 0 0 1\nv 1 0 0\nv 5 5 5\nvn 0 0 1\nf 3//1 2//1 1//1 2\n"];
        for text in texts {
            let any = parse_any_mesh(Path::new("m.obj"), text.as_bytes()).unwrap();
            let plain = mesh(text);
            assert_eq!(plain.triangle_count(), any.triangle_count());
            assert_eq!(plain.bounds(), any.bounds(), "{text}");
            for triangle in 0..any.triangle_count() as u32 {
                assert_eq!(plain.corners(triangle), any.corners(triangle));
                let weights = [0.5, 0.25, 0.25];
                assert_eq!(plain.normal(triangle, weights), any.normal(triangle, weights));
            }
        }
    }

    #[test]
    fn coinciding_vertices_stay_apart() {
        let mesh = mesh("v 0 0 0\nv 0 0 1\nv 1 0 0\nv 0 0 0\nv 0 -1 0\nv 0 0 1\nf 1 2 3\nf 4 5 6\n");
        assert_eq!(mesh.normal(0, [1.0, 0.0, 0.0]), Vector3::new(0.0, 1.0, 0.0));
    }

    #[test]
    fn mistakes_are_found_with_line_and_column() {
        for (text, start) in [
            ("v 0 0 0\nv 1 x 0\n", "m.obj:2:5: expected a finite coordinate, found 'x'"),
            ("v 0 0\n", "m.obj:1:1: a vertex needs three coordinates, this one has 2"),
            ("v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", "m.obj:2:5: expected a finite coordinate"),
            ("v 0 0 0\nf 1 1 7\n", "m.obj:2:7: there is no vertex 7: the file has 1"),
            ("v 0 0 0\nf 1 1 0\n", "m.obj:2:7: there is no vertex 0"),
            ("v 0 0 0\nf -2 1 1\n", "m.obj:2:3: there is no vertex -2"),
            ("v 0 0 0\nf 1 b 1\n", "m.obj:2:5: expected a vertex number, found 'b'"),
        ] {
            let message = refusal(text);
            assert!(message.starts_with(start), "{text:?}: {message}");
        }
    }
}
