//! The mistakes of a scene that the parser cannot see, for messages about all of them.

use super::camera::camera;
use super::named_files::{cube_map, unreadable};
use super::transforms::composed;
use crate::error::{Error, Remarks};
use crate::file_path::{self, FilePath};
use crate::scene_file::{Description, LeafShape, Node, Parsed};
use std::path::Path;

/// Returns the scene of a file without mistakes.
///
/// # Errors
/// All mistakes that can be told apart.
pub fn without_mistakes(parsed: Parsed) -> Result<Description, Error> {
    match parsed.mistakes.is_empty() {
        true => Ok(parsed.description),
        false => Err(with_other_mistakes(parsed.mistakes, &parsed.description)),
    }
}

/// Adds to the mistakes of a scene those that need arithmetic or other files to be found: a camera that sees nothing,
/// transforms without inverse, meshes and cube maps that are not there. What is in a mesh is not read. Makes one error
/// of all.
pub(super) fn with_other_mistakes(mut mistakes: Vec<Error>, description: &Description) -> Error {
    let source = &description.source;
    let folder = source.path.parent().unwrap_or(Path::new(""));
    let mut others = Vec::from_iter(camera(description).err());
    let map = description.background.cube_map.as_ref();
    others.extend(map.and_then(|name| cube_map(source, folder, name, &mut Remarks::default()).err()));
    add_mistakes_below(&description.root, description, folder, &mut others);
    let known: Vec<String> = mistakes.iter().map(Error::to_string).collect();
    mistakes.extend(others.into_iter().filter(|other| !known.contains(&other.to_string())));
    Error::all(mistakes)
}

fn add_mistakes_below(node: &Node, description: &Description, folder: &Path, mistakes: &mut Vec<Error>) {
    match node {
        Node::Group(members) => {
            members.iter().for_each(|member| add_mistakes_below(member, description, folder, mistakes));
        }
        Node::Transform { steps, child } => {
            mistakes.extend(composed(&description.source, steps).err());
            add_mistakes_below(child, description, folder, mistakes);
        }
        Node::Leaf(leaf) => {
            let LeafShape::Mesh(name) = &leaf.shape else { return };
            // A mesh without a name is a mistake of its own, and one under another spelling is read.
            if name.value.is_empty() || matches!(file_path::find(folder, &name.value), FilePath::Respelt(_)) {
                return;
            }
            // A pipe would wait for somebody who writes into it.
            if let Err(error) = folder.join(&name.value).metadata() {
                mistakes.push(unreadable(&description.source, folder, name, &error));
            }
        }
    }
}
