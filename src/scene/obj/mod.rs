//! OBJ files to [`Mesh`]es.
//!
//! Only corners' positions are used: normals are always computed from them, and texture coordinates have no use. Plain
//! files are read by all threads ([`plain`]). Others are decoded ([`decode`]), taken apart into [`statements`] with their
//! places, and read by `tobj` from a clean text ([`clean`]). Then [`polygons`] that are no fans are cut.

mod clean;
mod decode;
mod extent;
mod foreign;
mod left_out;
mod lines;
mod outline;
mod plain;
mod polygons;
mod statements;
mod tangled;
#[cfg(test)]
mod tests;
mod words;

pub use lines::triangle_lines;

use crate::error::{Error, SourceText, Span};
use crate::file_kind;
use crate::objects::Mesh;
use clean::Clean;
use statements::{Kind, Statements};
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
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
    /// Polygons that are not convex, and are cut inside their outline.
    pub concave: usize,
    /// Points and lines, which no picture shows.
    pub points: usize,
    pub lines: usize,
}

/// A mesh file of a scene.
#[derive(Clone, Debug)]
pub struct MeshFile {
    pub path: PathBuf,
    /// Index of its mesh. A copy of another file has the mesh of that one.
    pub mesh: u32,
    pub counts: MeshCounts,
}

impl fmt::Display for MeshFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let MeshCounts { vertices, faces, triangles, degenerate, polygons, concave, points, lines } = self.counts;
        write!(
            f,
            "{}: vertices {vertices}, faces {faces}, triangles {triangles}, degenerate faces left out {degenerate}, \
             polygons cut {polygons} (concave {concave})",
            self.path.display()
        )?;
        match points + lines {
            0 => Ok(()),
            _ => write!(f, ", points {points} and lines {lines} left out"),
        }
    }
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
    points: usize,
    lines: usize,
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

impl Polygon {
    fn range(&self) -> Range<usize> {
        self.first_triangle..self.first_triangle + self.triangles
    }
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
    let file = parse_plain_mesh(path, bytes).map_or_else(|| parse_any_mesh(path, bytes), Ok)?;
    Ok(ObjFile { mesh: file.mesh.with_normals(), ..file })
}

/// Reads the OBJ file at `path` by all threads, if it is plain. The mesh has no normals yet.
pub(super) fn parse_plain_mesh(path: &Path, bytes: &[u8]) -> Option<ObjFile> {
    let faces = plain::read(bytes.strip_prefix(decode::UTF8_MARK).unwrap_or(bytes))?;
    Some(finish(path, faces, MeshCounts::default(), Vec::new(), || source_text(path, bytes)))
}

fn source_text(path: &Path, bytes: &[u8]) -> Arc<SourceText> {
    Arc::new(SourceText { path: path.to_owned(), text: decode::decode(bytes) })
}

/// Reads an OBJ file that need not be plain, in more time and memory. The mesh has no normals yet.
///
/// # Errors
/// As [`parse_mesh`].
pub(super) fn parse_any_mesh(path: &Path, bytes: &[u8]) -> Result<ObjFile, Error> {
    let source = source_text(path, bytes);
    if let Some(what) = foreign::kind_of(bytes, &source.text) {
        return Err(Error::file(path, format!("this is no OBJ mesh: the file is {what}")));
    }
    let clean = match Clean::new(&source) {
        Err(_) if file_kind::is_binary(&source.text) => return Err(no_mesh(&source)),
        clean => clean?,
    };
    let degenerate = clean.left_out.degenerate.count;
    if clean.vertices == 0 && (degenerate == 0 || file_kind::is_binary(&source.text)) {
        return Err(no_mesh(&source));
    }
    let warnings = clean.warnings(&source);
    let counts = MeshCounts { degenerate, ..MeshCounts::default() };
    let faces = clean.read(&source)?;
    Ok(finish(path, faces, counts, warnings, || source))
}

/// The error for a file without a vertex.
fn no_mesh(source: &Arc<SourceText>) -> Error {
    if file_kind::is_binary(&source.text) {
        return Error::file(&source.path, "this is no OBJ mesh: the file is binary");
    }
    let place_of = |kind| {
        let mut statements = Statements::new(&source.text);
        statements.find(|statement| statement.kind == kind).map(|statement| statement.keyword)
    };
    let message = "this is no OBJ mesh: no line is a vertex ('v') or a face ('f')";
    if let Some(slip) = place_of(Kind::Slip) {
        return source.error(slip, message).with_note("vertices are written 'v 1 2 3', faces 'f 1 2 3'");
    }
    if let Some(call) = place_of(Kind::Call) {
        return source.error(call, message).with_note("'call' names another file, which is not read");
    }
    let start = source.text.find(|c| !statements::separates(c)).unwrap_or_default();
    let line = source.text[start..].lines().next().unwrap_or_default();
    source.error(Span { start, end: start + line.len() }, message)
}

/// Cuts polygons and makes the mesh.
fn finish(
    path: &Path,
    mut faces: Faces,
    mut counts: MeshCounts,
    mut warnings: Vec<String>,
    source: impl FnOnce() -> Arc<SourceText>,
) -> ObjFile {
    let cuts = polygons::cut(&faces.positions, &mut faces.triangles, &faces.polygons);
    if let Some((face, doubt)) = cuts.first_doubtful {
        let source = source();
        let place = source.location(place_of_face(&source.text, face));
        let (doubt, others) = (doubt.words(), others(cuts.doubtful));
        warnings.push(format!(
            "{place}: this polygon {doubt}{others}: it becomes a fan of triangles around its first corner"
        ));
    }
    counts.vertices = faces.vertices;
    counts.faces = faces.faces + counts.degenerate;
    counts.triangles = faces.triangles.len();
    counts.polygons = faces.polygons.len();
    counts.concave = cuts.concave;
    (counts.points, counts.lines) = (faces.points, faces.lines);
    warnings.extend(extent::without_area(path, &faces.positions, &faces.triangles));
    let mesh = Mesh::without_normals(faces.positions, faces.triangles);
    warnings.extend(extent::rounded_away(path, &mesh));
    ObjFile { mesh, counts, warnings }
}

/// The place of a face, by its number among those with three corners or more.
fn place_of_face(text: &str, number: usize) -> Span {
    let is_face =
        |statement: &statements::Statement| statement.kind == Kind::Face && statement.words().nth(2).is_some();
    Statements::new(text).filter(is_face).nth(number).map_or(Span::default(), |statement| statement.keyword)
}

/// Says how many there are besides the one that a sentence is about.
pub(super) fn others(count: usize) -> String {
    match count {
        0 | 1 => String::new(),
        2 => " (and one more like it)".to_owned(),
        n => format!(" (and {} more like it)", n - 1),
    }
}
