//! The course's batch of 21 pictures: with our own data against `sample_out/`, and with the data of the course's
//! starter, whose folder the environment variable `A2_STARTER` names, against its pictures.

use crate::support::batch::{self, Scene};
use crate::support::{Folder, picture, project};
use a2::measure::Comparison;
use std::path::{Path, PathBuf};

/// Renders the batch over the scenes in `data` into a fresh folder.
fn render_batch(data: &Path) -> Folder {
    let folder = Folder::new();
    batch::scenes().iter().for_each(|scene| scene.render(data, 800, &folder));
    folder
}

fn names() -> Vec<String> {
    batch::scenes().iter().flat_map(Scene::pictures).collect()
}

#[test]
fn our_pictures_equal_sample_out() {
    let folder = render_batch(&project("data"));
    for name in names() {
        let comparison = Comparison::new(&folder.picture(&name), &picture(&project("sample_out").join(&name)));
        assert_eq!(comparison.worst, 0, "{name}\n{comparison}");
    }
}

/// Programs of the course read neither comments nor quotes.
#[test]
fn our_scenes_are_for_any_program() {
    let folders = ["data", "data/gallery"].map(project);
    let entries = folders.iter().flat_map(|folder| std::fs::read_dir(folder).unwrap());
    let lists = ["batch.txt", "gallery.txt"];
    let is_scene = |path: &PathBuf| {
        path.extension().is_some_and(|end| end == "txt") && !lists.iter().any(|list| path.ends_with(list))
    };
    let scenes: Vec<_> = entries.map(|entry| entry.unwrap().path()).filter(is_scene).collect();
    assert!(scenes.len() >= 16, "{scenes:?}");
    for scene in scenes {
        let text = std::fs::read_to_string(&scene).unwrap();
        assert!(!["#", "//", "\""].iter().any(|mark| text.contains(mark)), "{}", scene.display());
    }
}

/// `.ci/run` runs this test if the starter is there.
#[test]
#[ignore = "needs the course's starter, whose folder A2_STARTER names"]
fn the_courses_pictures_are_met() {
    let starter = PathBuf::from(std::env::var_os("A2_STARTER").expect("A2_STARTER names the course's starter"));
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

/// `scripts/render_all.sh` renders the same pictures from the same table.
#[cfg(unix)]
#[test]
fn the_script_renders_the_batch() {
    let (ours, theirs) = (Folder::new(), Folder::new());
    batch::scenes().iter().for_each(|scene| scene.render(&project("data"), 9, &ours));
    let mut script = std::process::Command::new(project("scripts/render_all.sh"));
    script.args(["."]).env("A2", env!("CARGO_BIN_EXE_a2")).env("SIZE", "9").env_remove("DATA");
    let run = theirs.run(&mut script);
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let scene = project("data/scene01_plane.txt").display().to_string();
    let antialiased = format!("-input {scene} -size 2 2 -output a01aa.png -jitter -filter");
    assert_eq!(ours.a2(&antialiased).exit_code, 0);
    assert_eq!(theirs.files(), ours.files());
    for name in ours.files() {
        assert_eq!(std::fs::read(theirs.path(&name)).unwrap(), std::fs::read(ours.path(&name)).unwrap(), "{name}");
    }
}
