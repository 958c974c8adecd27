//! [`Places`]: where in the scene file the objects, materials and lights of a scene stand.

use crate::error::{SourceText, Span};
use crate::plan::Plan;
use crate::scene_file::Description;
use std::sync::Arc;

/// Places of the parts of a [`Scene`](super::Scene), in the order of its lists.
#[derive(Debug)]
pub struct Places {
    source: Arc<SourceText>,
    objects: Vec<Span>,
    materials: Vec<Span>,
    lights: Vec<Span>,
}

/// A block of the scene file.
#[derive(Clone, Debug)]
pub struct Place {
    /// The word that the block begins with, as in `Sphere`.
    pub block: String,
    /// `file:line:column`
    pub location: String,
    /// Counted from 1.
    pub line: usize,
}

impl Places {
    /// Notes the places of objects, materials and of the plan's lights.
    pub(super) fn new(description: &Description, plan: &Plan, objects: Vec<Span>) -> Self {
        Self {
            source: Arc::clone(&description.source),
            objects,
            materials: description.materials.iter().map(|material| material.span).collect(),
            lights: plan.lights.iter().map(|&light| description.lights[light].span).collect(),
        }
    }

    pub fn object(&self, index: u32) -> Place {
        self.place(self.objects[index as usize])
    }

    pub fn material(&self, index: u32) -> Place {
        self.place(self.materials[index as usize])
    }

    pub fn light(&self, index: usize) -> Place {
        self.place(self.lights[index])
    }

    fn place(&self, span: Span) -> Place {
        Place {
            block: self.source.text[span.start..span.end].to_owned(),
            location: self.source.location(span),
            line: self.source.line_and_column(span.start).0,
        }
    }
}
