//! [`Scene`]: what rays meet. Flat, immutable, shared by all threads.
//!
//! [`compile()`] makes one of a [`Description`](crate::scene_file::Description) and a [`Plan`](crate::plan::Plan): it
//! loads meshes and multiplies transformations out.

mod compile;
mod hints;
mod mesh_file;
mod plain_obj;

pub use compile::{Compiled, compile};
pub use mesh_file::parse_mesh;

use crate::accel::Accelerator;
use crate::camera::Camera;
use crate::cube_map::CubeMap;
use crate::error::Error;
use crate::light::Light;
use crate::material::Material;
use crate::objects::{Mesh, Object};
use vecmath::Vector3;

/// What surrounds everything: seen by every ray that meets no object.
#[derive(Debug)]
pub struct Background {
    pub color: Vector3,
    pub cube_map: Option<CubeMap>,
}

impl Background {
    /// How many faces of the cube map rays have reached and decoded.
    ///
    /// # Errors
    /// [`Error::File`] for the first face that could not be decoded.
    pub fn decoded_faces(&self) -> Result<usize, Error> {
        let Some(cube_map) = &self.cube_map else { return Ok(0) };
        cube_map.check_decoded_faces()?;
        Ok(cube_map.decoded_faces())
    }
}

/// Everything a ray can meet, ready to be met.
#[derive(Debug)]
pub struct Scene {
    pub camera: Camera,
    pub lights: Vec<Light>,
    pub ambient_light: Vector3,
    pub background: Background,
    pub materials: Vec<Material>,
    /// In the order of the file: where two objects are hit at the same distance, the first one counts.
    pub objects: Vec<Object>,
    /// Each mesh file once, however many objects use it.
    pub meshes: Vec<Mesh>,
    pub accelerator: Accelerator,
}
