//! [`Names`]: what the parts of a scene are called, and where they stand in its files.

use crate::material;
use crate::objects::{Hit, Shape};
use crate::scene::{MeshFile, Place, Places, Scene, triangle_lines};
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::PathBuf;

/// Names the parts of a scene.
pub struct Names<'a> {
    pub scene: &'a Scene,
    pub places: &'a Places,
    mesh_files: &'a [MeshFile],
    /// For each mesh that was hit, the lines of its triangles, if they are known.
    lines: RefCell<HashMap<u32, Option<Vec<u32>>>>,
}

/// An object that a ray has hit.
#[derive(Debug)]
pub struct Object {
    pub place: Place,
    /// The triangle, if the object is a mesh.
    pub triangle: Option<MeshTriangle>,
}

/// A triangle of a mesh.
#[derive(Debug)]
pub struct MeshTriangle {
    pub file: PathBuf,
    /// Counted from 0, in the order of the file's faces.
    pub number: u32,
    /// Line of its face in the file, counted from 1; `None` if the file's lines are not plain.
    pub line: Option<u32>,
}

/// A material as the scene has it.
#[derive(Debug)]
pub struct Material {
    pub place: Place,
    /// Its `MaterialIndex`.
    pub index: u32,
    pub values: material::Material,
    pub is_mirror: bool,
}

impl<'a> Names<'a> {
    pub fn new(scene: &'a Scene, places: &'a Places, mesh_files: &'a [MeshFile]) -> Self {
        Self { scene, places, mesh_files, lines: RefCell::default() }
    }

    pub fn object(&self, hit: &Hit) -> Object {
        let triangle = match self.scene.geometry.objects[hit.object as usize].shape {
            Shape::Mesh(mesh) => self.triangle(mesh, hit.surface.triangle),
            _ => None,
        };
        Object { place: self.places.object(hit.object), triangle }
    }

    pub fn material(&self, hit: &Hit) -> Material {
        let index = self.scene.geometry.objects[hit.object as usize].material;
        let values = self.scene.materials[index as usize].clone();
        Material { place: self.places.material(index), index, is_mirror: values.is_mirror(), values }
    }

    fn triangle(&self, mesh: u32, number: u32) -> Option<MeshTriangle> {
        let file = self.mesh_files.iter().find(|file| file.mesh == mesh)?.path.clone();
        let count = self.scene.geometry.meshes[mesh as usize].triangle_count();
        let mut lines = self.lines.borrow_mut();
        let lines = lines.entry(mesh).or_insert_with(|| triangle_lines(&file, count));
        let line = lines.as_ref().map(|lines| lines[number as usize]);
        Some(MeshTriangle { file, number, line })
    }
}
