//! [`Description`] in, [`Scene`] out: loads meshes, multiplies transforms, flattens groups.
//!
//! Mistakes that need arithmetic or another file to be found are reported here, at their place in the scene file.

use super::copies::{KnownFiles, remove_copies};
use super::hidden::remove_hidden;
use super::hints::Hints;
use super::lights::lights;
use super::mistakes::with_other_mistakes;
use super::obj::{self, MeshFile};
use super::places::Places;
use super::{Background, Geometry, LOOP_OBJECTS, Scene};
use crate::camera::{Camera, CameraError};
use crate::cube_map::CubeMap;
use crate::error::{Error, Remarks, SourceText, Span, counted, cut_short};
use crate::file_path::{self, FilePath, Kind};
use crate::input::read_whole;
use crate::light::Light;
use crate::material::Material;
use crate::memory::Budget;
use crate::objects::{Mesh, Object, Shape, Transform};
use crate::plan::Plan;
use crate::scene_file::{At, Description, Leaf, LeafShape, Node, TransformStep};
use crate::timing::{Times, timed};
use std::collections::HashMap;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vecmath::{Matrix4, Real, Vector3, is_unusual};

/// Largest mesh file that is read. A triangle takes two bytes at least, so their numbers fit into 32 bits.
const MAX_MESH_BYTES: u64 = 4 << 30;
/// Bytes of memory for a byte of a mesh file, while the mesh is read and its tree is built: 3.0 were measured with a
/// million triangles.
const MEMORY_FOR_A_BYTE: u64 = 4;
/// Further bytes, if the file is not plain: 3.4 were measured.
const MEMORY_FOR_AN_UNUSUAL_BYTE: u64 = 4;

/// A scene, and remarks about it.
#[derive(Debug)]
pub struct Compiled {
    pub scene: Scene,
    /// Only if the plan wants them.
    pub places: Option<Places>,
    /// The files of its meshes.
    pub mesh_files: Vec<MeshFile>,
    /// What was left out and why, a sentence each.
    pub left_out: Vec<String>,
    pub remarks: Remarks,
    /// The time it took to build trees.
    pub build: Times,
}

/// Loads and flattens the parts of a scene that `plan` needs.
///
/// # Errors
/// [`Error::Source`] for a mistake in the scene or in a mesh, or for a cube map that cannot be opened; [`Error::Several`]
/// for more.
pub fn compile(description: &Description, plan: &Plan, budget: &mut Budget) -> Result<Compiled, Error> {
    compile_as_far_as_right(description, plan, budget)
        .map_err(|error| with_other_mistakes(vec![error], description))
}

/// Does the same, and stops at the first mistake.
fn compile_as_far_as_right(
    description: &Description,
    plan: &Plan,
    budget: &mut Budget,
) -> Result<Compiled, Error> {
    let source = &description.source;
    let folder = source.path.parent().unwrap_or(Path::new(""));
    let mut remarks = Remarks { hints: description.hints.clone(), ..Remarks::default() };
    let camera = camera(description)?;
    let cube_map = match &description.background.cube_map {
        Some(name) if plan.cube_map => Some(cube_map(source, folder, name, &mut remarks)?),
        _ => None,
    };
    let mut flattened = Flattened {
        source,
        folder,
        plan,
        objects: Vec::new(),
        places: Vec::new(),
        meshes: Vec::new(),
        files: HashMap::new(),
        known_files: KnownFiles::default(),
        mesh_files: Vec::new(),
        budget,
        hints: Hints::default(),
        remarks,
        left_out: Vec::new(),
        is_usual: !is_unusual(camera.center.max_abs()),
        eye: camera.center,
    };
    flattened.add(&description.root, None)?;
    let Flattened { mut objects, places, meshes, mesh_files, hints, mut remarks, mut left_out, is_usual, .. } =
        flattened;
    let (lights, ambient_light) = lights(description, plan, is_usual, &mut remarks);
    hints.finish(plan, &objects, source, &mut remarks);
    if !meshes.is_empty() && !plan.shows_normals() {
        left_out.push("the smooth normals of meshes: neither colours nor normals are asked for".to_owned());
    }
    // Places are those of all objects.
    if objects.len() > LOOP_OBJECTS && !plan.places {
        leave_out_objects(&mut objects, camera.center, &lights, plan, &mut left_out);
    }
    // Shadow and mirror rays may go anywhere, and the trees that only these meet are built when they do.
    let is_in_picture = |object: &Object| object.bounds.as_ref().is_none_or(|bounds| camera.may_see(bounds));
    let (geometry, build) = timed(|| Geometry::for_rays_at(is_in_picture, objects, meshes, plan.simd));
    let materials: Vec<Material> = description.materials.iter().map(|material| material.value.clone()).collect();
    let places = plan.places.then(|| Places::new(description, plan, places));
    let scene = Scene {
        camera,
        lights,
        ambient_light,
        background: Background { color: description.background.color, cube_map },
        throughput_never_grows: materials.iter().all(|material| material.specular.max_abs() <= 1.0),
        materials,
        geometry,
    };
    Ok(Compiled { scene, places, mesh_files, left_out, remarks, build })
}

/// Removes the objects that no picture can show, and says so.
fn leave_out_objects(
    objects: &mut Vec<Object>,
    eye: Vector3,
    lights: &[Light],
    plan: &Plan,
    left_out: &mut Vec<String>,
) {
    let copies = remove_copies(objects);
    if copies > 0 {
        left_out.push(format!(
            "{}: an equal one at the same place comes first in the file",
            counted(copies, "object")
        ));
    }
    let hidden = remove_hidden(objects, eye, lights, plan);
    if hidden > 0 {
        let what = counted(hidden, "object");
        left_out.push(format!("{what}: inside a sphere, with the eye and all lights outside of it"));
    }
}

pub(super) fn cube_map(
    source: &Arc<SourceText>,
    folder: &Path,
    name: &At<String>,
    remarks: &mut Remarks,
) -> Result<CubeMap, Error> {
    let mut path = folder.join(&name.value);
    if let FilePath::Respelt(spelling) = file_path::find(folder, &name.value) {
        remarks.hints.push(respelt(source, name, &spelling));
        path = folder.join(spelling);
    }
    CubeMap::open(&path).map_err(|message| {
        let error = source.error(name.span, message);
        if path.exists() {
            error
        } else {
            error.with_note(file_path::what_is_there(folder, &name.value, Kind::Folder))
        }
    })
}

/// Makes the error for a mesh that cannot be read.
pub(super) fn unreadable(source: &Arc<SourceText>, folder: &Path, name: &At<String>, error: &io::Error) -> Error {
    let path = folder.join(&name.value).display().to_string();
    let refusal = source.error(name.span, format!("cannot read the mesh '{}': {error}", cut_short(&path)));
    match error.kind() {
        ErrorKind::NotFound => refusal.with_note(file_path::what_is_there(folder, &name.value, Kind::File)),
        _ => refusal,
    }
}

/// Returns the hint for a file or folder that is found under another spelling.
fn respelt(source: &SourceText, name: &At<String>, spelling: &str) -> String {
    format!("{}: there is no '{}': '{spelling}' is read", source.location(name.span), name.value)
}

pub(super) fn camera(description: &Description) -> Result<Camera, Error> {
    let block = &description.camera;
    let angle_radians = block.angle_degrees.value.to_radians();
    let camera = Camera::new(block.center.value, block.direction.value, block.up.value, angle_radians);
    camera.map_err(|error| {
        let (span, message) = match error {
            CameraError::Angle => (block.angle_degrees.span, "'angle' must be above 0 and below 180 degrees"),
            CameraError::Direction => (block.direction.span, "'direction' has no length"),
            CameraError::Up => (block.up.span, "'up' has no length"),
            CameraError::UpAlongDirection => (block.up.span, "'up' is parallel to 'direction'"),
        };
        description.source.error(span, message)
    })
}

/// Flattens the tree of objects to a list.
struct Flattened<'a> {
    source: &'a Arc<SourceText>,
    folder: &'a Path,
    plan: &'a Plan,
    hints: Hints,
    objects: Vec<Object>,
    /// Of the objects, if the plan wants them.
    places: Vec<Span>,
    meshes: Vec<Mesh>,
    /// Meshes by their file.
    files: HashMap<PathBuf, u32>,
    known_files: KnownFiles,
    mesh_files: Vec<MeshFile>,
    budget: &'a mut Budget,
    remarks: Remarks,
    left_out: Vec<String>,
    /// Whether no size in the scene [is unusual](is_unusual).
    is_usual: bool,
    eye: Vector3,
}

impl Flattened<'_> {
    /// Adds a node and everything below it. `world_from_parent` is `None` outside any transform.
    fn add(&mut self, node: &Node, world_from_parent: Option<&Matrix4>) -> Result<(), Error> {
        match node {
            Node::Group(members) => members.iter().try_for_each(|member| self.add(member, world_from_parent)),
            Node::Transform { steps, child } => {
                let parent = world_from_parent.copied().unwrap_or(Matrix4::IDENTITY);
                let world_from_object = parent * composed(self.source, steps)?;
                self.add(child, Some(&world_from_object))
            }
            Node::Leaf(leaf) => self.add_leaf(leaf, world_from_parent),
        }
    }

    fn add_leaf(&mut self, leaf: &Leaf, world_from_object: Option<&Matrix4>) -> Result<(), Error> {
        let (shape, matrix) = self.shape(leaf)?.within_range(world_from_object.copied());
        let world_from_object = matrix.as_ref();
        let bounds = shape.bounds(&self.meshes);
        if bounds.is_some_and(|bounds| bounds.is_empty()) {
            return Ok(());
        }
        if matches!(&shape, Shape::Triangle(triangle) if triangle.normal == Vector3::ZERO) {
            self.hints.left_out(leaf.span);
            return Ok(());
        }
        let transform = match world_from_object {
            None => None,
            Some(matrix) => Some(Box::new(Transform::new(matrix).map_err(|_| {
                self.source
                    .error(leaf.span, no_inverse("the product of the transforms around this object", matrix))
            })?)),
        };
        self.hints.note(leaf.span, &shape, world_from_object, bounds.as_ref());
        let object = Object::new(shape, transform, leaf.material, bounds.as_ref());
        self.hints.note_too_thin(leaf.span, &object, self.eye);
        self.is_usual &= object.bounds.is_none_or(|bounds| !is_unusual(bounds.max_abs()));
        self.objects.push(object);
        if self.plan.places {
            self.places.push(leaf.span);
        }
        Ok(())
    }

    fn shape(&mut self, leaf: &Leaf) -> Result<Shape, Error> {
        match &leaf.shape {
            LeafShape::Shape(shape) if self.plan.robust => Ok(shape.clone().with_unit_normal()),
            LeafShape::Shape(shape) => Ok(shape.clone()),
            LeafShape::Mesh(obj_file) => Ok(Shape::Mesh(self.mesh(obj_file)?)),
        }
    }

    /// Returns the index of a mesh. Each file is loaded once.
    fn mesh(&mut self, obj_file: &At<String>) -> Result<u32, Error> {
        let path = self.folder.join(&obj_file.value);
        if let Some(&known) = self.files.get(&path) {
            return Ok(known);
        }
        let index = match file_path::find(self.folder, &obj_file.value) {
            FilePath::AsWritten | FilePath::Similar(_) => self.load(&path, obj_file)?,
            FilePath::Respelt(name) => {
                self.remarks.hints.push(respelt(self.source, obj_file, &name));
                let path = self.folder.join(&name);
                match self.files.get(&path) {
                    Some(&known) => known,
                    None => self.load(&path, obj_file)?,
                }
            }
        };
        self.files.insert(path, index);
        Ok(index)
    }

    fn reserve(&mut self, bytes: u64, mesh: Span) -> Result<(), Error> {
        self.budget.add_mesh(bytes).map_err(|error| self.source.error(mesh, error.to_string()))
    }

    /// Reads the mesh file at `path`, which the scene calls `name`.
    fn load(&mut self, path: &Path, name: &At<String>) -> Result<u32, Error> {
        if let Ok(metadata) = path.metadata() {
            self.reserve(MEMORY_FOR_A_BYTE * metadata.len(), name.span)?;
        }
        let bytes = read_whole(path, MAX_MESH_BYTES)
            .map_err(|error| unreadable(self.source, self.folder, name, &error))?;
        let index = self.meshes.len() as u32;
        if let Some(mesh) = self.known_files.find_or_add(path, &bytes, index) {
            self.budget.take_back_mesh(MEMORY_FOR_A_BYTE * bytes.len() as u64);
            if let Some(original) = self.mesh_files.iter().find(|file| file.mesh == mesh) {
                let names = (path.display(), original.path.display());
                self.left_out.push(format!("a second mesh for {}: its bytes are those of {}", names.0, names.1));
                self.mesh_files.push(MeshFile { path: path.to_owned(), ..original.clone() });
            }
            self.files.insert(path.to_owned(), mesh);
            return Ok(mesh);
        }
        let file = match obj::parse_plain_mesh(path, &bytes) {
            Some(file) => file,
            None => {
                self.reserve(MEMORY_FOR_AN_UNUSUAL_BYTE * bytes.len() as u64, name.span)?;
                obj::parse_any_mesh(path, &bytes)?
            }
        };
        self.meshes.push(if self.plan.shows_normals() { file.mesh.with_normals() } else { file.mesh });
        self.remarks.warnings.extend(file.warnings);
        self.mesh_files.push(MeshFile { path: path.to_owned(), mesh: index, counts: file.counts });
        self.files.insert(path.to_owned(), index);
        Ok(index)
    }
}

/// Multiplies the steps of a transform. A step multiplies from the right, so the first one is applied last; a
/// `Matrix4f` multiplies from the left, as in the starter.
pub(super) fn composed(source: &Arc<SourceText>, steps: &[At<TransformStep>]) -> Result<Matrix4, Error> {
    let mut product = Matrix4::IDENTITY;
    for step in steps {
        let matrix = step_matrix(&step.value).map_err(|message| source.error(step.span, message))?;
        if matrix.affine_inverse().is_err() {
            return Err(source.error(step.span, no_inverse("this transformation", &matrix)));
        }
        product = match step.value {
            TransformStep::Matrix4f(_) => matrix * product,
            _ => product * matrix,
        };
    }
    Ok(product)
}

/// Returns the message for a matrix without inverse.
fn no_inverse(what: &str, matrix: &Matrix4) -> String {
    let condition = matrix.linear().condition_number();
    format!("{what} squashes space flat: its matrix has no inverse (condition number {condition:.1e})")
}

/// Returns the matrix of one step, or the message for a mistake in it.
fn step_matrix(step: &TransformStep) -> Result<Matrix4, &'static str> {
    match *step {
        TransformStep::Translate(offset) => Ok(Matrix4::translation(offset)),
        TransformStep::Scale(factors) => Ok(Matrix4::scaling(factors)),
        TransformStep::Rotate { axis, degrees } => {
            let axis = axis.try_normalized().ok_or("the axis of this rotation has no length")?;
            Ok(Matrix4::rotation(axis, degrees.to_radians() as Real))
        }
        TransformStep::Matrix4f(numbers) => {
            let matrix = Matrix4::from_column_major(numbers.map(|number| number as Real));
            let last_row = "the last row of this matrix (its numbers 4, 8, 12 and 16) must be 0 0 0 1";
            matrix.is_affine().then_some(matrix).ok_or(last_row)
        }
    }
}
