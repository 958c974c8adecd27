//! OBJ files of every kind, read by `tobj`, which gets a clean text.
//!
//! The text is written anew with only what a picture shows: `v x y z`, and `f` with the vertex numbers of three corners or
//! more. Mistakes are reported here, at their places in the file, for `tobj` names none. Names of groups and materials would
//! make it start a new model and number its corners anew, which would tear smooth surfaces apart; it never sees them.

use super::Faces;
use super::left_out::LeftOut;
use super::statements::{Kind, Statement, Statements};
use super::words::{coordinate, vertex_number, vertex_part};
use crate::error::{Error, SourceText, Span, cut_short};
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// A clean text, and what the file holds.
#[derive(Default)]
pub(super) struct Clean {
    text: Vec<u8>,
    pub vertices: usize,
    /// Faces with three corners or more.
    pub faces: usize,
    pub left_out: LeftOut,
    /// Corners that name a vertex further on in the file: those with a larger number than all before them.
    ahead: Vec<(i64, Span)>,
    /// Vertices with a coordinate that is not finite, by their number from 1, and that coordinate's place.
    not_finite: Vec<(i64, Span)>,
}

impl Clean {
    /// Cleans a text.
    ///
    /// # Errors
    /// The first vertex or face that cannot be read.
    pub fn new(source: &Arc<SourceText>) -> Result<Self, Error> {
        let mut clean = Self::default();
        for statement in Statements::new(&source.text) {
            match statement.kind {
                Kind::Vertex => clean.add_vertex(source, &statement)?,
                Kind::Face => clean.add_face(source, &statement)?,
                _ => clean.left_out.add(source, &statement),
            }
        }
        match clean.ahead.iter().find(|&&(number, _)| number > clean.vertices as i64) {
            Some(&(_, span)) => Err(clean.no_vertex(source, span)),
            None => Ok(clean),
        }
    }

    /// Says what the file's author should know.
    pub fn warnings(&self, source: &SourceText) -> Vec<String> {
        self.left_out.warnings(source, self.vertices, self.faces)
    }

    fn add_vertex(&mut self, source: &Arc<SourceText>, statement: &Statement) -> Result<(), Error> {
        self.vertices += 1;
        self.text.push(b'v');
        let (mut count, mut strange) = (0, None);
        for (word, span) in statement.words().take(3) {
            let Some(coordinate) = coordinate(word.as_bytes()) else {
                return Err(not_finite(source, word, span));
            };
            if !coordinate.is_finite() {
                strange.get_or_insert(span);
            }
            self.add_word(word);
            count += 1;
        }
        if count < 3 {
            let message = format!("a vertex needs three coordinates, this one has {count}");
            return Err(source.error(statement.keyword, message));
        }
        self.not_finite.extend(strange.map(|span| (self.vertices as i64, span)));
        self.text.push(b'\n');
        Ok(())
    }

    fn add_face(&mut self, source: &Arc<SourceText>, statement: &Statement) -> Result<(), Error> {
        let start = self.text.len();
        self.text.push(b'f');
        let mut corners = 0;
        for (word, span) in statement.words() {
            let Some(number) = vertex_number(vertex_part(word.as_bytes())) else {
                let message = format!("expected a vertex number, found '{}'", cut_short(word));
                return Err(source.error(span, message));
            };
            if number == 0 || number < -(self.vertices as i64) {
                return Err(self.no_vertex(source, span));
            }
            if number > self.ahead.last().map_or(self.vertices as i64, |last| last.0) {
                self.ahead.push((number, span));
            }
            self.add_word(word.split('/').next().unwrap_or(word));
            corners += 1;
        }
        if corners < 3 {
            self.text.truncate(start);
            self.left_out.degenerate.add(statement.keyword);
            return Ok(());
        }
        self.faces += 1;
        self.text.push(b'\n');
        Ok(())
    }

    fn add_word(&mut self, word: &str) {
        self.text.push(b' ');
        self.text.extend_from_slice(word.as_bytes());
    }

    fn no_vertex(&self, source: &Arc<SourceText>, corner: Span) -> Error {
        let word = cut_short(source.text[corner.start..corner.end].split('/').next().unwrap_or_default());
        let message = match self.vertices {
            _ if word.starts_with('-') => {
                format!("there is no vertex {word}: {} stand before this face", self.vertices)
            }
            count => format!("there is no vertex {word}: the file has {count}, numbered from 1"),
        };
        let error = source.error(corner, message);
        match self.left_out.slip(source) {
            Some(slip) => error.with_note(slip),
            None => error,
        }
    }

    /// Has `tobj` read the clean text.
    ///
    /// # Errors
    /// A face with a corner that is not finite.
    pub fn read(self, source: &Arc<SourceText>) -> Result<Faces, Error> {
        // Polygons stay whole: tobj would cut them into fans, and not all are fit for that.
        let options = tobj::LoadOptions::default();
        let no_materials = |_: &Path| Err(tobj::LoadError::GenericFailure);
        let (models, _) = tobj::load_obj_buf(&mut &self.text[..], &options, no_materials)
            .map_err(|error| Error::file(&source.path, format!("cannot read this mesh: {error}")))?;
        // It leaves out a model without faces.
        let mesh = models.into_iter().next().map(|model| model.mesh).unwrap_or_default();
        let positions: Vec<[f32; 3]> = mesh.positions.as_chunks().0.to_vec();
        if !positions.as_flattened().iter().all(|coordinate| coordinate.is_finite()) {
            let span = self.first_used(source).unwrap_or_default();
            return Err(not_finite(source, &source.text[span.start..span.end], span));
        }
        let LeftOut { points, lines, .. } = self.left_out;
        let (vertices, count) = (self.vertices, self.faces);
        let mut faces = Faces { positions, vertices, faces: count, points, lines, ..Faces::default() };
        if mesh.face_arities.is_empty() {
            faces.triangles = mesh.indices.as_chunks().0.to_vec();
            return Ok(faces);
        }
        let mut rest = mesh.indices.as_slice();
        for (face, &corners) in mesh.face_arities.iter().enumerate() {
            let (polygon, behind) = rest.split_at(corners as usize);
            rest = behind;
            faces.add_fan(face, polygon);
        }
        Ok(faces)
    }

    /// The place of a coordinate that is not finite, of the first vertex that a face uses and that has one.
    fn first_used(&self, source: &SourceText) -> Option<Span> {
        let places: HashMap<i64, Span> = self.not_finite.iter().copied().collect();
        let mut vertices = 0;
        for statement in Statements::new(&source.text) {
            match statement.kind {
                Kind::Vertex => vertices += 1,
                Kind::Face if statement.words().count() >= 3 => {
                    let mut corners = statement.words().filter_map(|(word, _)| {
                        let number = vertex_number(vertex_part(word.as_bytes()))?;
                        places.get(&if number < 0 { vertices + 1 + number } else { number })
                    });
                    if let Some(&span) = corners.next() {
                        return Some(span);
                    }
                }
                _ => {}
            }
        }
        None
    }
}

fn not_finite(source: &Arc<SourceText>, word: &str, span: Span) -> Error {
    let found = cut_short(word);
    match word.parse::<f64>() {
        Ok(_) if word.contains(|c: char| c.is_ascii_digit()) => {
            source.error(span, format!("the coordinate '{found}' is too large (at most 3.4e38)"))
        }
        _ => source.error(span, format!("expected a finite coordinate, found '{found}'")),
    }
}
