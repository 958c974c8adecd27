//! [`Description`] in, [`Scene`] out: loads meshes, multiplies transforms, flattens groups.
//!
//! Mistakes that need arithmetic or another file to be found are reported here, at their place in the scene file.

use super::camera::camera;
use super::copies::remove_copies;
use super::hidden::remove_hidden;
use super::hints::Hints;
use super::lights::lights;
use super::mesh_files::LoadedMeshes;
use super::mistakes::with_other_mistakes;
use super::named_files::cube_map;
use super::obj::MeshFile;
use super::places::Places;
use super::transforms::{composed, no_inverse_of_product};
use super::{Background, Geometry, LOOP_OBJECTS, Scene};
use crate::camera::Camera;
use crate::error::{Error, Remarks, Span, counted};
use crate::light::Light;
use crate::material::Material;
use crate::memory::Budget;
use crate::objects::{Object, Shape, Transform};
use crate::plan::Plan;
use crate::scene_file::{Description, Leaf, LeafShape, Node};
use crate::timing::{Times, timed};
use std::path::Path;
use std::sync::Arc;
use vecmath::{Matrix4, Vector3, is_unusual};

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
        Some(name) if plan.cube_map => {
            let cube_map = cube_map(source, folder, name, &mut remarks)?;
            let fits = budget.add_cube_map(cube_map.decoded_bytes());
            fits.map_err(|error| source.error(name.span, error.to_string()))?;
            Some(cube_map)
        }
        _ => None,
    };
    let cube_map_name = description.background.cube_map.as_ref().filter(|_| cube_map.is_some());
    let cube_map_name = cube_map_name.map(|name| (Arc::clone(source), name.span));
    let mut flattened = Flattened {
        loaded: LoadedMeshes::new(source, folder, plan, budget),
        objects: Vec::new(),
        places: Vec::new(),
        hints: Hints::default(),
        is_usual: !is_unusual(camera.center.max_abs()),
        camera: &camera,
    };
    flattened.add(&description.root, None)?;
    let Flattened { loaded, mut objects, places, hints, is_usual, .. } = flattened;
    let LoadedMeshes { meshes, mesh_files, remarks: of_meshes, mut left_out, .. } = loaded;
    remarks.add(of_meshes);
    let (lights, ambient_light) = lights(description, plan, is_usual, &mut remarks);
    hints.finish(plan, &objects, &camera, source, &mut remarks);
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
        background: Background { color: description.background.color, cube_map, cube_map_name },
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
    for (count, one_side, other) in [(hidden.inside, "inside", "outside"), (hidden.outside, "outside", "inside")] {
        if count > 0 {
            let what = counted(count, "object");
            left_out.push(format!("{what}: {one_side} a sphere, with the eye and all lights {other} of it"));
        }
    }
}

/// Flattens the tree of objects to a list.
struct Flattened<'a> {
    loaded: LoadedMeshes<'a>,
    hints: Hints,
    objects: Vec<Object>,
    /// Of the objects, if the plan wants them.
    places: Vec<Span>,
    /// Whether no size in the scene [is unusual](is_unusual).
    is_usual: bool,
    camera: &'a Camera,
}

impl Flattened<'_> {
    /// Adds a node and everything below it. `world_from_parent` is `None` outside any transform.
    fn add(&mut self, node: &Node, world_from_parent: Option<&Matrix4>) -> Result<(), Error> {
        match node {
            Node::Group(members) => members.iter().try_for_each(|member| self.add(member, world_from_parent)),
            Node::Transform { steps, child } => {
                let parent = world_from_parent.copied().unwrap_or(Matrix4::IDENTITY);
                let world_from_object = parent * composed(self.loaded.source, steps)?;
                self.add(child, Some(&world_from_object))
            }
            Node::Leaf(leaf) => self.add_leaf(leaf, world_from_parent),
        }
    }

    fn add_leaf(&mut self, leaf: &Leaf, world_from_object: Option<&Matrix4>) -> Result<(), Error> {
        let (shape, matrix) = self.shape(leaf)?.within_range(world_from_object.copied());
        let world_from_object = matrix.as_ref();
        let bounds = shape.bounds(&self.loaded.meshes);
        if bounds.is_some_and(|bounds| bounds.is_empty()) {
            return Ok(());
        }
        if matches!(&shape, Shape::Triangle(triangle) if triangle.normal == Vector3::ZERO) {
            self.hints.left_out(leaf.span);
            return Ok(());
        }
        let transform = match world_from_object {
            None => None,
            Some(matrix) => Some(Box::new(
                Transform::new(matrix)
                    .map_err(|_| self.loaded.source.error(leaf.span, no_inverse_of_product(matrix)))?,
            )),
        };
        self.hints.note(leaf.span, &shape, world_from_object, bounds.as_ref());
        let object = Object::new(shape, transform, leaf.material, bounds.as_ref());
        self.hints.note_seen(leaf.span, &object, self.camera);
        self.is_usual &= object.bounds.is_none_or(|bounds| !is_unusual(bounds.max_abs()));
        self.objects.push(object);
        if self.loaded.plan.places {
            self.places.push(leaf.span);
        }
        Ok(())
    }

    fn shape(&mut self, leaf: &Leaf) -> Result<Shape, Error> {
        match &leaf.shape {
            LeafShape::Shape(shape) if self.loaded.plan.robust => Ok(shape.clone().with_unit_normal()),
            LeafShape::Shape(shape) => Ok(shape.clone()),
            LeafShape::Mesh(obj_file) => Ok(Shape::Mesh(self.loaded.index_of(obj_file)?)),
        }
    }
}
