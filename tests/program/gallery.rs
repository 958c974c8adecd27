//! The gallery: its scenes stay small, use everything that a scene file can say, and look as docs/gallery shows them.

use crate::support::{Folder, batch, picture, project};
use image::RgbImage;
use std::fmt::Write;

/// The courtyard in README.md is smoothed, which changes pixels at edges.
const SAME_COURTYARD: f64 = 6.0;
const SIZE: (u32, u32) = (400, 300);

fn text(path: &str) -> String {
    std::fs::read_to_string(project(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn scenes() -> Vec<batch::Scene> {
    let scenes = batch::read("data/gallery.txt");
    assert_eq!(scenes.len(), 8);
    scenes
}

#[test]
fn scenes_of_the_gallery_are_small_and_use_everything() {
    let mut words = String::new();
    for scene in scenes() {
        let text = text(&format!("data/gallery/{}.txt", scene.name));
        assert!(text.lines().count() < 60, "{}: {} lines", scene.name, text.lines().count());
        for line in text.lines() {
            assert!(line.len() <= 120, "{}: {line}", scene.name);
            assert!(!line.contains('#'), "the course's programs know no comments: {}: {line}", scene.name);
        }
        write!(words, " {} {}", text.split_whitespace().collect::<Vec<_>>().join(" "), scene.flags).unwrap();
    }
    for word in "DirectionalLight PointLight falloff ambientLight cubeMap diffuseColor specularColor shininess Sphere \
                 Plane Triangle TriangleMesh Group Transform Translate Scale UniformScale XRotate YRotate ZRotate Rotate \
                 Matrix4f -shadows -bounces"
        .split_whitespace()
    {
        assert!(words.contains(&format!(" {word} ")), "no scene shows '{word}'");
    }
}

/// Returns the mean colours of blocks of 4 x 4 pixels.
fn shrunk(picture: &RgbImage) -> RgbImage {
    assert_eq!(picture.dimensions(), SIZE);
    image::imageops::thumbnail(picture, SIZE.0 / 4, SIZE.1 / 4)
}

/// Returns how many levels the components of two pictures differ on average.
fn mean_difference(a: &RgbImage, b: &RgbImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let sum: u64 = a.as_raw().iter().zip(b.as_raw()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.as_raw().len() as f64
}

/// The pictures of the page are smoothed, which changes the means of blocks by less than `SAME` levels on average. Two
/// different scenes differ by more than `OTHER`.
#[test]
fn pictures_of_the_gallery_show_their_scenes() {
    const SAME: f64 = 4.0;
    const OTHER: f64 = 20.0;
    let page = text("docs/gallery.md");
    let folder = Folder::new();
    let mut shown = Vec::new();
    for scene in scenes() {
        let name = &scene.name;
        let input = project(&format!("data/gallery/{name}.txt"));
        let (w, h) = SIZE;
        let run =
            folder.a2(&format!("-input {} -output {name}.png -size {w} {h} {}", input.display(), scene.flags));
        assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""), "{name}");
        let small = shrunk(&picture(&project(&format!("docs/gallery/{name}.png"))));
        let found = shrunk(&folder.picture(&format!("{name}.png")));
        assert!(mean_difference(&small, &found) < SAME, "{name}: {}", mean_difference(&small, &found));
        for (other, earlier) in &shown {
            let difference = mean_difference(earlier, &found);
            assert!(difference > OTHER, "{name} looks like {other}: {difference}");
        }
        assert!(page.contains(&format!("](gallery/{name}.png)")), "docs/gallery.md does not show {name}");
        let command = format!("a2 -input data/gallery/{name}.txt -output {name}.png -size 400 300 ");
        let line = page.lines().find(|line| line.starts_with(&command)).unwrap_or_else(|| panic!("{name}"));
        assert!(line.ends_with(&format!("{} -jitter -filter", scene.flags)), "{line}");
        shown.push((name.clone(), small));
    }
}

#[test]
fn the_picture_of_the_readme_shows_the_courtyard() {
    let command = "a2 -input data/courtyard.txt -output courtyard.png -size 640 640 -bounces 2 -shadows -jitter ";
    assert!(text("README.md").contains(command));
    let folder = Folder::new();
    let input = project("data/courtyard.txt");
    let pictures = "-output courtyard.png -depth 5 45 courtyard-depth.png -normals courtyard-normals.png";
    let run =
        folder.a2(&format!("-input {} {pictures} -size 640 640 -bounces 2 -shadows -quiet", input.display()));
    // The first picture that a reader renders warns of nothing.
    assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""));
    for name in folder.files() {
        let (shown, found) = (picture(&project(&format!("docs/{name}"))), folder.picture(&name));
        let difference = mean_difference(&shown, &found);
        assert!(difference < SAME_COURTYARD, "{name}: {difference}");
    }
}
