//! Pictures that the course does not have, against a second renderer written directly from the formulas. The limits
//! are the same as for the course's own pictures.

use crate::support::reference::{self, Flags};
use crate::support::{Folder, project};
use a2::measure::Comparison;

/// Renders a scene with both renderers and checks the differences.
fn compare(folder: &Folder, scene: &str, flags: Flags) {
    let path = folder.path(scene);
    let mut arguments = format!(
        "-input {scene} -output out.png -size {} {} -bounces {}",
        flags.width, flags.height, flags.bounces
    );
    for (on, flag) in [(flags.shadows, " -shadows"), (flags.filter, " -filter")] {
        arguments += if on { flag } else { "" };
    }
    let run = folder.a2(&arguments);
    assert_eq!(run.exit_code, 0, "{arguments}: {}", run.stderr);
    let comparison = Comparison::new(&folder.picture("out.png"), &reference::render(&path, flags));
    let pixels = comparison.pixels as f64;
    // 1%, 0.01% and 12 of 640,000 pixels, plus one pixel for pictures that are too small for these shares.
    assert!(comparison.percent_over(0) <= 1.0, "{arguments}\n{comparison}");
    assert!(comparison.pixels_over(1) as f64 <= 1.0 + 1e-4 * pixels, "{arguments}\n{comparison}");
    assert!(comparison.pixels_over(8) as f64 <= 1.0 + 12.0 / 640_000.0 * pixels, "{arguments}\n{comparison}");
}

/// Copies the project's scenes to a folder, without cube maps, which the reference does not have.
fn own_scenes() -> (Folder, Vec<String>) {
    let folder = Folder::new();
    for model in ["cube2.obj", "bunny_200.obj"] {
        folder.write(&format!("models/{model}"), std::fs::read(project("data/models").join(model)).unwrap());
    }
    let mut names = Vec::new();
    for entry in std::fs::read_dir(project("data")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if !name.starts_with("scene0") {
            continue;
        }
        let text = std::fs::read_to_string(project("data").join(&name)).unwrap();
        let without_cube_map = text.lines().filter(|line| !line.trim_start().starts_with("cubeMap"));
        // The reference tests every triangle, so the small bunny must do.
        let text = without_cube_map.collect::<Vec<_>>().join("\n").replace("bunny_1k", "bunny_200");
        folder.write(&name, text);
        names.push(name);
    }
    names.sort();
    assert_eq!(names.len(), 7);
    (folder, names)
}

#[test]
fn own_scenes_at_other_sizes_and_with_every_flag_agree() {
    let (folder, names) = own_scenes();
    for (i, name) in names.iter().enumerate() {
        let (width, height) = [(120, 120), (150, 80), (70, 130)][i % 3];
        let plain = Flags { width, height, ..Flags::default() };
        compare(&folder, name, plain);
        compare(&folder, name, Flags { bounces: 3, shadows: true, ..plain });
    }
}

#[test]
fn filtered_pictures_agree() {
    let (folder, names) = own_scenes();
    for name in names.iter().filter(|name| !name.contains("bunny")) {
        let flags = Flags { width: 60, height: 50, bounces: 1, shadows: true, filter: true };
        compare(&folder, name, flags);
    }
}

/// Features of the format that the seven scenes do not use.
const ODDITIES: &str = "
    Group { numObjects 5
        MaterialIndex 2
        Plane { normal 0 0.5 0.1 offset -1.2 }
        Group { numObjects 1
            Transform { Rotate { 1 2 3 50 } Translate 0.5 0 1 Scale 0.5 1.5 1
                Transform { Matrix4f { 1 0.2 0 0  0 1 0 0  0.3 0 1 0  0.5 0.5 -1 1 } YRotate 20
                    Group { numObjects 2
                        MaterialIndex 1
                        Sphere { center 0 0 0 radius 1 }
                        Transform { Translate -2 1 0 UniformScale 0.7 TriangleMesh { obj_file models/cube2.obj } } } } } }
        Triangle { vertex0 -3 -1 -2 vertex1 3 -1 -3 vertex2 0 4 -2.5 }
        MaterialIndex 0
        Transform { XRotate -80 Plane { normal 0 3 0 offset -9 } }
        Sphere { center 1.5 -0.5 2 radius 0.6 }
    }
    Materials { numMaterials 3
        Material { diffuseColor 0.4 0.5 0.6 specularColor 0.3 0.3 0.2 }
        PhongMaterial { diffuseColor 0.8 0.2 0.1 specularColor 0.5 0.6 0.4 shininess 7.5 bump none.png }
        Material { diffuseColor 0.2 0.4 0.2 specularColor 0.06 0.06 0.06 shininess 3 } }
    PerspectiveCamera { angle 50 up 0.1 1.3 0.2 direction 0.05 -0.1 -1 center 0 1 8 }
    Background { ambientLight 0.1 0.05 0.1 color 0.3 0.5 0.8 }
";

#[test]
fn features_that_the_seven_scenes_do_not_use_agree() {
    let (folder, _) = own_scenes();
    let lights = "Lights { numLights 3
        PointLight { position 3 5 4 color 20 18 16 falloff 0.7 }
        PointLight { color 4 8 9 position -4 2 3 falloff 1.5 }
        DirectionalLight { color 0.2 0.2 0.3 direction 0.3 -1 -0.7 } }";
    for (lights, bounces, shadows) in
        [(lights, 0, false), (lights, 5, true), ("", 2, true), ("Lights { numLights 0 }", 0, false)]
    {
        folder.write("odd.txt", format!("{ODDITIES}{lights}"));
        compare(&folder, "odd.txt", Flags { width: 140, height: 100, bounces, shadows, filter: false });
    }
}
