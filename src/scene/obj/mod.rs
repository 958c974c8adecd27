//! OBJ files to [`Mesh`]es.
//!
//! Only corners' positions are used: normals are always computed from them, and texture coordinates have no use. Plain
//! files are read by all threads ([`plain`]). Others are decoded ([`decode`]), taken apart into [`statements`] with their
//! places, and read by `tobj` from a clean text ([`clean`]).

mod clean;
mod decode;
mod plain;
mod statements;
#[cfg(test)]
mod tests;
mod words;

use crate::error::{Error, SourceText};
use crate::objects::Mesh;
use clean::Clean;
use std::path::Path;
use std::sync::Arc;

/// A mesh, and what its author should know about the file.
#[derive(Debug)]
pub struct ObjFile {
    pub mesh: Mesh,
    pub counts: MeshCounts,
    pub warnings: Vec<String>,
}

/// What a mesh file holds, and what became of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshCounts {
    pub vertices: usize,
    /// All faces, degenerate ones too.
    pub faces: usize,
    pub triangles: usize,
    /// Faces with fewer than three corners, which are left out.
    pub degenerate: usize,
    /// Faces with more than three corners, which are cut into triangles.
    pub polygons: usize,
}

/// The faces that a reader found in a file.
#[derive(Debug, Default)]
struct Faces {
    /// Those that faces use.
    positions: Vec<[f32; 3]>,
    /// A face with more than three corners is a fan around its first one.
    triangles: Vec<[u32; 3]>,
    polygons: Vec<Polygon>,
    /// Vertices in the file.
    vertices: usize,
    /// Faces with three corners or more.
    faces: usize,
}

/// A face with more than three corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Polygon {
    /// Where its fan begins among the triangles.
    first_triangle: usize,
    triangles: usize,
    /// The number of the face, from 0.
    face: usize,
}

impl Faces {
    fn add_fan(&mut self, face: usize, corners: &[u32]) {
        let first_triangle = self.triangles.len();
        self.triangles.extend(corners[1..].windows(2).map(|edge| [corners[0], edge[0], edge[1]]));
        if corners.len() > 3 {
            self.polygons.push(Polygon { first_triangle, triangles: corners.len() - 2, face });
        }
    }
}

/// Reads the OBJ file at `path`, whose bytes are given.
///
/// # Errors
/// [`Error::Source`] for a mistake, at its place; [`Error::File`] for a file that is no OBJ file.
pub fn parse_mesh(path: &Path, bytes: &[u8]) -> Result<ObjFile, Error> {
    let plain = bytes.strip_prefix(decode::UTF8_MARK).unwrap_or(bytes);
    match plain::read(plain) {
        Some(faces) => Ok(finish(faces, MeshCounts::default(), Vec::new())),
        None => parse_any_mesh(path, bytes),
    }
}

fn source_text(path: &Path, bytes: &[u8]) -> Arc<SourceText> {
    Arc::new(SourceText { path: path.to_owned(), text: decode::decode(bytes) })
}

/// Reads an OBJ file that need not be plain.
fn parse_any_mesh(path: &Path, bytes: &[u8]) -> Result<ObjFile, Error> {
    let source = source_text(path, bytes);
    let clean = Clean::new(&source)?;
    let warnings = clean.warnings(&source);
    let counts = MeshCounts { degenerate: clean.degenerate, ..MeshCounts::default() };
    let faces = clean.read(&source)?;
    Ok(finish(faces, counts, warnings))
}

/// Makes the mesh.
fn finish(faces: Faces, mut counts: MeshCounts, warnings: Vec<String>) -> ObjFile {
    counts.vertices = faces.vertices;
    counts.faces = faces.faces + counts.degenerate;
    counts.triangles = faces.triangles.len();
    counts.polygons = faces.polygons.len();
    ObjFile { mesh: Mesh::new(faces.positions, faces.triangles), counts, warnings }
}

/// How many there are besides the one that a sentence is about.
fn others(count: usize) -> String {
    match count {
        0 | 1 => String::new(),
        2 => " (and one more like it)".to_owned(),
        n => format!(" (and {} more like it)", n - 1),
    }
}
