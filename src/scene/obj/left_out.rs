//! What an OBJ file holds besides vertices and faces, and the warnings about it.

use super::others;
use super::statements::{Kind, Statement};
use crate::error::{SourceText, Span, cut_short};

/// Some things of a kind: how many, and where the first one stands.
#[derive(Default)]
pub(super) struct Found {
    pub count: usize,
    first: Span,
}

impl Found {
    pub fn add(&mut self, place: Span) {
        if self.count == 0 {
            self.first = place;
        }
        self.count += 1;
    }
}

/// What no picture shows.
#[derive(Default)]
pub(super) struct LeftOut {
    /// Faces with fewer than three corners.
    pub degenerate: Found,
    pub points: usize,
    pub lines: usize,
    /// Curves, free-form surfaces and calls of other files, by their keywords.
    shapes: Vec<(String, usize)>,
    first_shape: Span,
    calls: usize,
    /// Lines that are probably meant as vertices or faces.
    slips: Found,
}

impl LeftOut {
    /// Notes a statement that is neither a vertex nor a face.
    pub fn add(&mut self, source: &SourceText, statement: &Statement) {
        match statement.kind {
            Kind::Points => self.points += statement.words().count(),
            Kind::Line => self.lines += 1,
            Kind::Curved => self.add_shape(source, statement.keyword),
            Kind::Call => {
                self.calls += 1;
                self.add_shape(source, statement.keyword);
            }
            Kind::Slip => self.slips.add(statement.keyword),
            Kind::Vertex | Kind::Face | Kind::Other => {}
        }
    }

    fn add_shape(&mut self, source: &SourceText, place: Span) {
        if self.shapes.is_empty() {
            self.first_shape = place;
        }
        let keyword = &source.text[place.start..place.end];
        match self.shapes.iter_mut().find(|(known, _)| known == keyword) {
            Some((_, count)) => *count += 1,
            None => self.shapes.push((keyword.to_owned(), 1)),
        }
    }

    /// Says where the first line is that is probably meant as a vertex or a face.
    pub fn slip(&self, source: &SourceText) -> Option<String> {
        let Found { count, first } = self.slips;
        (count > 0).then(|| {
            format!(
                "{}: '{}' is no keyword as 'v' and 'f' are, and this line is left out{}",
                source.location(first),
                cut_short(&source.text[first.start..first.end]),
                others(count)
            )
        })
    }

    /// Says what the file's author should know, beside so many vertices and faces.
    pub fn warnings(&self, source: &SourceText, vertices: usize, faces: usize) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.degenerate.count > 0 {
            warnings.push(format!(
                "{}: this face has fewer than three corners and is left out{}",
                source.location(self.degenerate.first),
                others(self.degenerate.count)
            ));
        }
        warnings.extend(self.slip(source));
        if faces == 0 {
            let curved = self.shapes.iter().map(|(_, count)| count).sum::<usize>() - self.calls;
            warnings.push(format!(
                "{}: no picture shows this mesh, for it has no face (vertices {vertices}, points {}, lines {}, curves and \
                 surfaces {curved})",
                source.path.display(),
                self.points,
                self.lines
            ));
        }
        if self.calls > 0 || faces > 0 && !self.shapes.is_empty() {
            let shapes: Vec<_> = self.shapes.iter().map(|(keyword, count)| format!("{keyword} {count}")).collect();
            warnings.push(format!(
                "{}: only faces are shown, and what else the file describes is left out: {}",
                source.location(self.first_shape),
                shapes.join(", ")
            ));
        }
        warnings
    }
}
