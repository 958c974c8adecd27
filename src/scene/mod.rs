//! [`Scene`]: everything that rays can meet. It is flat and immutable, and all threads share it.
//!
//! [`compile()`] makes a scene of a [`Description`](crate::scene_file::Description) and a
//! [`Plan`](crate::plan::Plan): it loads meshes and multiplies transforms.

mod brightness;
mod camera;
mod compile;
mod copies;
mod files;
mod geometry;
mod hidden;
mod hints;
mod lights;
mod mesh_files;
mod mistakes;
mod named_files;
mod obj;
mod object_tree;
mod places;
mod queries;
mod tally;
mod transforms;

pub use compile::{Compiled, compile};
pub use files::{hash_of_files, named_files};
pub use geometry::{Geometry, build_mesh_tree};
pub use mistakes::without_mistakes;
pub use obj::{MeshCounts, MeshFile, parse_mesh, triangle_lines};
pub use object_tree::LOOP_OBJECTS;
pub use places::{Place, Places};
pub use tally::{ObjectCounts, TestCounts};

use crate::camera::Camera;
use crate::cube_map::CubeMap;
use crate::error::{Error, SourceText, Span};
use crate::light::Light;
use crate::material::Material;
use std::sync::Arc;
use vecmath::Vector3;

/// The background, seen by every ray that hits no object.
#[derive(Debug)]
pub struct Background {
    pub color: Vector3,
    pub cube_map: Option<CubeMap>,
    /// The text of the scene, and the place where it names its cube map.
    pub cube_map_name: Option<(Arc<SourceText>, Span)>,
}

impl Background {
    /// Returns the colour that a ray sees if it leaves the scene in this direction.
    pub fn color(&self, direction: Vector3) -> Vector3 {
        self.cube_map.as_ref().map_or(self.color, |cube_map| cube_map.color(direction))
    }

    /// Returns the number of cube map faces that were decoded because rays reached them.
    ///
    /// # Errors
    /// [`Error::Source`] at the name of the cube map, for the first face that could not be decoded.
    pub fn decoded_faces(&self) -> Result<usize, Error> {
        let Some(cube_map) = &self.cube_map else { return Ok(0) };
        match (cube_map.broken_face(), &self.cube_map_name) {
            (None, _) => Ok(cube_map.decoded_faces()),
            (Some(message), Some((source, place))) => Err(source.error(*place, message)),
            (Some(message), None) => Err(Error::Refused(message)),
        }
    }
}

/// Everything that rays can meet.
#[derive(Debug)]
pub struct Scene {
    pub camera: Camera,
    pub lights: Vec<Light>,
    pub ambient_light: Vector3,
    pub background: Background,
    pub materials: Vec<Material>,
    pub geometry: Geometry,
    /// Whether no mirror makes its mirror image brighter, in any component.
    pub throughput_never_grows: bool,
}
