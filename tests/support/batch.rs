//! The course's batch of scenes, read from `data/batch.txt`.

use super::{Folder, project};
use std::path::Path;

/// A scene of the batch and its flags.
#[derive(Clone, Debug)]
pub struct Scene {
    /// `01`, `02`, ..., part of the names of its pictures.
    pub number: String,
    /// The scene file's name without its ending.
    pub name: String,
    /// Nearest and farthest distance of the depth picture.
    pub depth: [String; 2],
    /// Further flags, separated by spaces.
    pub flags: String,
}

/// Returns all scenes, in order.
pub fn scenes() -> Vec<Scene> {
    let scenes = read("data/batch.txt");
    assert_eq!(scenes.len(), 7);
    scenes
}

/// Returns the scenes of a table in the form of `data/batch.txt`, in order.
pub fn read(table: &str) -> Vec<Scene> {
    let text = std::fs::read_to_string(project(table)).unwrap();
    let lines = text.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines
        .map(|line| {
            let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
            let [number, name, near, far, flags @ ..] = words.as_slice() else { panic!("{table}: {line}") };
            let depth = [near.clone(), far.clone()];
            Scene { number: number.clone(), name: name.clone(), depth, flags: flags.join(" ") }
        })
        .collect()
}

impl Scene {
    /// Returns the file name and the further flags, as words of a command line.
    pub fn arguments(&self) -> String {
        format!("{}.txt {}", self.name, self.flags).trim_end().to_owned()
    }

    /// Returns the file names of the colour, normal and depth picture.
    pub fn pictures(&self) -> [String; 3] {
        ["", "n", "d"].map(|kind| format!("a{}{kind}.png", self.number))
    }

    /// Renders the three pictures of this scene of the folder `data` into `folder`.
    pub fn render(&self, data: &Path, size: u32, folder: &Folder) {
        let scene = data.join(format!("{}.txt", self.name));
        let ([color, normals, depth], [near, far], flags) = (self.pictures(), &self.depth, &self.flags);
        let pictures = format!("-output {color} -normals {normals} -depth {near} {far} {depth}");
        let run = folder.a2(&format!("-input {} -size {size} {size} {pictures} {flags}", scene.display()));
        assert_eq!(run.exit_code, 0, "{}: {}", scene.display(), run.stderr);
    }
}
