//! The mistakes of a scene that the parser cannot see, for messages about all of them.

use super::camera::camera;
use super::named_files::{cube_map, unreadable};
use super::transforms::composed;
use crate::error::{Error, MOST_SHOWN, Remarks, SourceText};
use crate::file_path::KnownFolders;
use crate::scene_file::{Description, LeafShape, Node, Parsed};
use std::path::Path;
use std::sync::Arc;

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
    let mut search = Search { source, folder, folders: KnownFolders::default(), most, mistakes: others };
    search.add_those_below(&description.root);
    let known: Vec<String> = mistakes.iter().map(Error::to_string).collect();
    mistakes.extend(search.mistakes.into_iter().filter(|other| !known.contains(&other.to_string())));
    Error::all(mistakes)
}

/// The mistakes in the tree of a scene.
struct Search<'a> {
    source: &'a Arc<SourceText>,
    folder: &'a Path,
    folders: KnownFolders,
    /// How many of them are looked for.
    most: usize,
    mistakes: Vec<Error>,
}

impl Search<'_> {
    /// Adds the mistakes of a part of the tree, in the order of their places.
    fn add_those_below(&mut self, node: &Node) {
        match node {
            // To say what is meant, folders are read.
            _ if self.mistakes.len() >= self.most => {}
            Node::Group(members) => members.iter().for_each(|member| self.add_those_below(member)),
            Node::Transform { steps, child } => {
                self.mistakes.extend(composed(self.source, steps).err());
                self.add_those_below(child);
            }
            Node::Leaf(leaf) => {
                let LeafShape::Mesh(name) = &leaf.shape else { return };
                // A mesh without a name is a mistake of its own, and one under another spelling is read.
                if name.value.is_empty() || self.folders.respelt(self.folder, &name.value).is_some() {
                    return;
                }
                // A pipe would wait for somebody who writes into it.
                if let Err(error) = self.folder.join(&name.value).metadata() {
                    self.mistakes.push(unreadable(self.source, self.folder, name, &error));
                }
            }
        }
    }
}
