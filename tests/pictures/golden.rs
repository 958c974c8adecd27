//! The course's batch of 21 pictures: over our own data against `sample_out/`, and where the environment variable
//! `A2_STARTER` names the course's starter, over its data against its pictures.

use crate::support::{Folder, picture, project};
use a2::measure::Comparison;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Scene, depth range, further flags: pictures a01, a02, ... in this order.
const BATCH: [(&str, &str, &str); 7] = [
    ("scene01_plane", "8 18", ""),
    ("scene02_cube", "8 18", ""),
    ("scene03_sphere", "8 18", ""),
    ("scene04_axes", "8 18", ""),
    ("scene05_bunny_200", "0.8 1.0", ""),
    ("scene06_bunny_1k", "8 18", "-bounces 4"),
    ("scene07_arch", "8 18", "-bounces 4 -shadows"),
];

/// Renders the batch over the scenes in `data` into a fresh folder.
fn render_batch(data: &Path) -> Folder {
    let folder = Folder::new();
    for (number, (scene, depth_range, flags)) in (1..).zip(BATCH) {
        let scene = data.join(format!("{scene}.txt"));
        let pictures =
            format!("-output a0{number}.png -normals a0{number}n.png -depth {depth_range} a0{number}d.png");
        let run = folder.a2(&format!("-input {} -size 800 800 {pictures} {flags}", scene.display()));
        assert_eq!(run.exit_code, 0, "{}: {}", scene.display(), run.stderr);
    }
    folder
}

fn names() -> impl Iterator<Item = String> {
    (1..=7).flat_map(|number| ["", "n", "d"].map(|kind| format!("a0{number}{kind}.png")))
}

#[test]
fn our_pictures_are_what_they_were() {
    let folder = render_batch(&project("data"));
    for name in names() {
        let comparison = Comparison::new(&folder.picture(&name), &picture(&project("sample_out").join(&name)));
        assert_eq!(comparison.worst, 0, "{name}\n{comparison}");
    }
}

fn starter() -> Option<PathBuf> {
    static SAID: OnceLock<()> = OnceLock::new();
    let starter = std::env::var_os("A2_STARTER").map(PathBuf::from);
    if starter.is_none() {
        SAID.get_or_init(|| println!("NOT RUN: A2_STARTER does not name the course's starter"));
    }
    starter
}

#[test]
fn the_courses_pictures_are_met() {
    let Some(starter) = starter() else { return };
    let folder = render_batch(&starter.join("data"));
    for name in names() {
        let theirs = picture(&starter.join("sample_out").join(&name));
        let comparison = Comparison::new(&folder.picture(&name), &theirs);
        println!("{name}\n{comparison}");
        assert!(comparison.percent_over(0) <= 1.0, "{name}\n{comparison}");
        assert!(comparison.percent_over(1) <= 0.01, "{name}\n{comparison}");
        assert!(comparison.pixels_over(8) <= 12, "{name}\n{comparison}");
    }
}
