//! The mistakes of a scene that the parser cannot see, for messages about all of them.

use super::camera::camera;
use super::named_files::{cube_map, unreadable};
use super::transforms::composed;
use crate::error::{Error, MOST_SHOWN, Remarks};
use crate::file_path;
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
    // Some of these may be known.
    let most = others.len() + mistakes.len() + MOST_SHOWN;
    add_mistakes_below(&description.root, description, folder, most, &mut others);
    let known: Vec<String> = mistakes.iter().map(Error::to_string).collect();
    mistakes.extend(others.into_iter().filter(|other| !known.contains(&other.to_string())));
    Error::all(mistakes)
}

/// Adds the mistakes of a part of the tree, in the order of their places, as far as they can be among the first ones.
fn add_mistakes_below(
    node: &Node,
    description: &Description,
    folder: &Path,
    most: usize,
    mistakes: &mut Vec<Error>,
) {
    match node {
        // To say what is meant, folders are read.
        _ if mistakes.len() >= most => {}
        Node::Group(members) => {
            members.iter().for_each(|member| add_mistakes_below(member, description, folder, most, mistakes));
        }
        Node::Transform { steps, child } => {
            mistakes.extend(composed(&description.source, steps).err());
            add_mistakes_below(child, description, folder, most, mistakes);
        }
        Node::Leaf(leaf) => {
            let LeafShape::Mesh(name) = &leaf.shape else { return };
            // A mesh without a name is a mistake of its own, and one under another spelling is read.
            if name.value.is_empty() || file_path::respelt(folder, &name.value).is_some() {
                return;
            }
            // A pipe would wait for somebody who writes into it.
            if let Err(error) = folder.join(&name.value).metadata() {
                mistakes.push(unreadable(&description.source, folder, name, &error));
            }
        }
    }
}
