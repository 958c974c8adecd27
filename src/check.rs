//! `-check`: reads all files of a scene, and renders nothing.

use crate::error::{Error, counted};
use crate::memory::Budget;
use crate::options::Options;
use crate::output::say;
use crate::plan::Plan;
use crate::scene::{Compiled, compile};
use crate::scene_file::Description;
use vecmath::Vector3;

/// A direction into each face of a cube map.
const AXES: [Vector3; 6] = [
    Vector3::new(1.0, 0.0, 0.0),
    Vector3::new(-1.0, 0.0, 0.0),
    Vector3::new(0.0, 1.0, 0.0),
    Vector3::new(0.0, -1.0, 0.0),
    Vector3::new(0.0, 0.0, 1.0),
    Vector3::new(0.0, 0.0, -1.0),
];

/// Reads a scene's meshes and its cube map. Returns what it holds, as text for the user; prints warnings and hints.
///
/// # Errors
/// [`Error`] for mistakes in the scene or in a file that it names.
pub fn check(description: &Description, plan: &Plan, options: &Options) -> Result<String, Error> {
    let mut budget = Budget::new(options.max_memory);
    let Compiled { scene, mesh_files, remarks, .. } = compile(description, plan, &mut budget)?;
    if let Some(cube_map) = &scene.background.cube_map {
        cube_map.decode(&AXES);
        scene.background.decoded_faces()?;
    }
    remarks.lines(options.quiet).for_each(|line| say(&line));
    let mut text = format!(
        "{}: no mistakes: {}, {}, {}{}\n",
        description.source.path.display(),
        counted(description.lights.len(), "light"),
        counted(description.materials.len(), "material"),
        counted(scene.geometry.objects.len(), "object"),
        if scene.background.cube_map.is_some() { ", a cube map" } else { "" }
    );
    mesh_files.iter().for_each(|file| text += &format!("mesh {file}\n"));
    Ok(text)
}
