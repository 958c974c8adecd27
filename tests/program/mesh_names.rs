//! Tests of the names of mesh files, of their size, and of what is reported about them.

use crate::meshes::{KITE, refusal};
use crate::parse_errors::with_material;
use crate::support::{Folder, Run, SCENE, TRIANGLE};
use image::RgbImage;

/// Runs a scene whose mesh is named so; `folder` holds the kite under the names `files`.
fn named(name: &str, files: &[&str]) -> Run {
    let folder = Folder::new();
    for file in files {
        folder.write(file, KITE);
    }
    folder.write("s.txt", SCENE.replace(TRIANGLE, &format!("TriangleMesh {{\n  obj_file {name} }}")));
    folder.a2("-input s.txt -output o.png -size 9 9")
}

#[test]
fn names_with_spaces_stand_in_quotes() {
    for (name, file) in [
        ("\"my mesh.obj\"", "my mesh.obj"),
        ("'my mesh.obj'", "my mesh.obj"),
        ("\"a #1 {b} 'c'.obj\"", "a #1 {b} 'c'.obj"),
        ("\"plain.obj\"", "plain.obj"),
        ("it's.obj", "it's.obj"),
    ] {
        let run = named(name, &[file]);
        assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""), "{name}");
    }
    let run = named("my old mesh.obj", &["my old mesh.obj"]);
    assert!(run.stderr.starts_with("error: s.txt:6:15: 'TriangleMesh' has no 'old'"), "{}", run.stderr);
    assert!(
        run.stderr.contains("help: a name with spaces stands in quotes: \"my old mesh.obj\""),
        "{}",
        run.stderr
    );
    for (name, message) in [
        ("\"my mesh.obj", "s.txt:6:12: this name has no closing quote in its line"),
        ("\"my\nmesh.obj\"", "s.txt:6:12: this name has no closing quote in its line"),
        ("\"\"", "s.txt:6:12: expected a file for 'obj_file', found an empty name"),
    ] {
        let run = named(name, &["my mesh.obj"]);
        assert!(run.stderr.starts_with(&format!("error: {message}")), "{name}: {}", run.stderr);
    }
    let folder = Folder::new();
    let sky = SCENE.replace("Background { color 0 0 0 }", "Background { cubeMap \"my sky\" }");
    folder.write("s.txt", sky);
    std::fs::create_dir(folder.path("my sky")).unwrap();
    for face in ["left", "right", "up", "down", "front", "back"] {
        let picture = RgbImage::from_pixel(2, 2, image::Rgb([9, 99, 199]));
        picture.save(folder.path(&format!("my sky/{face}.png"))).unwrap();
    }
    let run = folder.a2("-input s.txt -output o.png -size 9 9");
    assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""));
}

#[test]
fn a_name_that_is_nearly_right_is_found_or_suggested() {
    // On a system that takes A for a, the file is simply there.
    if cfg!(target_os = "linux") {
        for (name, file) in [
            ("Kite.OBJ", "kite.obj"),
            ("models\\kite.obj", "models/kite.obj"),
            (".\\Models\\Kite.obj", "./models/kite.obj"),
        ] {
            let run = named(name, &[file]);
            let warning = format!("hint: s.txt:6:12: there is no '{name}': '{file}' is read\n");
            assert_eq!((run.exit_code, run.stderr), (0, warning), "{name}");
        }
    }
    for (name, file) in [("kit.obj", "kite.obj"), ("model/kite.obj", "models/kite.obj")] {
        let run = named(name, &[file, "unlike.txt"]);
        let start = format!("error: s.txt:6:12: cannot read the mesh '{name}': ");
        assert!(run.stderr.starts_with(&start), "{}", run.stderr);
        assert!(run.stderr.contains(&format!("help: did you mean '{file}'?")), "{}", run.stderr);
    }
    let run = named("teapot.obj", &["kite.obj"]);
    assert!(run.exit_code == 1 && run.stderr.contains("help: this folder holds kite.obj\n"), "{}", run.stderr);
    let files = ["models/a.obj", "models/b.obj", "models/c.txt", "models/d.obj/e"];
    assert!(named("models/teapot.obj", &files).stderr.contains("help: 'models' holds a.obj, b.obj\n"));
    assert!(named("models/teapot.ply", &files).stderr.contains("help: 'models' holds no .ply file\n"));
    assert!(named("meshes/teapot.obj", &files).stderr.contains("help: there is no folder 'meshes'\n"));
}

#[test]
fn a_mesh_under_two_spellings_is_read_once() {
    let folder = Folder::new();
    let meshes = ["Kite.obj", "kite.obj", "KITE.obj", "Kite.obj"]
        .map(|name| format!("TriangleMesh {{ obj_file {name} }}"))
        .join(" ");
    let scene = SCENE.replace(TRIANGLE, &meshes).replace("numObjects 1", "numObjects 4");
    folder.write("s.txt", scene).write("kite.obj", KITE);
    let run = folder.a2("-input s.txt -output o.png -size 9 9 -explain -threads 1");
    assert_eq!((run.exit_code, run.stderr.matches("mesh kite.obj: vertices 4").count()), (0, 1), "{}", run.stderr);
    if cfg!(target_os = "linux") {
        assert_eq!(run.stderr.matches("'kite.obj' is read").count(), 2, "{}", run.stderr);
    }
}

#[test]
fn what_stands_around_a_name_is_named() {
    let folder = Folder::new();
    folder.write("p.obj", KITE).write("my mesh.obj", KITE).write("other.obj", "");
    for (name, cure) in [
        ("\u{201c}p.obj\u{201d}", "would be part of the name: write \"p.obj\""),
        ("<p.obj>", "'<' and '>' would be part of the name: write \"p.obj\""),
        ("my\\ mesh.obj", "a name with spaces stands in quotes: \"my mesh.obj\""),
        ("\u{201c}my mesh.obj\u{201d}", "a name with spaces stands in quotes: \"my mesh.obj\""),
    ] {
        folder.write("s.txt", SCENE.replace(TRIANGLE, &format!("TriangleMesh {{ obj_file {name} }}")));
        let run = folder.a2("-input s.txt -output o.png");
        assert!(run.exit_code == 1 && run.stderr.contains(cure), "{name}: {}", run.stderr);
    }
}

#[cfg(unix)]
#[test]
fn endless_files_end_at_the_limit() {
    let folder = Folder::new();
    for link in ["m.obj", "s.txt"] {
        std::os::unix::fs::symlink("/dev/zero", folder.path(link)).unwrap();
    }
    let run = folder.a2("-input s.txt -output o.png");
    assert_eq!(run.exit_code, 1);
    let message = "error: s.txt: cannot read the scene: it holds more than 1 GiB, which is the limit\n";
    assert_eq!(run.stderr, message);
    folder.write("t.txt", SCENE.replace(TRIANGLE, "TriangleMesh { obj_file m.obj }"));
    let run = folder.a2("-input t.txt -output o.png");
    assert_eq!(run.exit_code, 1);
    let message =
        "error: t.txt:5:62: cannot read the mesh 'm.obj': it holds more than 1 GiB, which is the limit\n";
    assert!(run.stderr.starts_with(message), "{}", run.stderr);
}

#[cfg(unix)]
#[test]
fn a_mesh_may_come_through_a_pipe() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE.replace(TRIANGLE, "TriangleMesh { obj_file m.obj }")).write("kite.obj", KITE);
    let command = format!(
        "mkfifo m.obj; cat kite.obj > m.obj & '{}' -input s.txt -output o.png -size 9 9",
        env!("CARGO_BIN_EXE_a2")
    );
    let run = folder.run(std::process::Command::new("sh").args(["-c", &command]));
    assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""));
}

#[test]
fn words_of_any_length_are_cut_in_messages_and_cost_little() {
    let long = "y".repeat(20_000_000);
    let start = std::time::Instant::now();
    for text in [
        refusal(format!("v 0 0 {long}\n").as_bytes()),
        refusal(format!("v 0 0 0\nf 1 1 {long}/1\n").as_bytes()),
        refusal(format!("v 0 0 0\nf 1 1 {}\n", "7".repeat(20_000_000)).as_bytes()),
        named(&format!("a.obj\n  {long}"), &["a.obj"]).stderr,
        named(&format!("a.obj {long}"), &["a.obj"]).stderr,
        named(&long, &["a.obj"]).stderr,
    ] {
        assert!(text.len() < 1000, "{}", &text[..1000]);
    }
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

#[test]
fn what_became_of_a_mesh_is_reported() {
    let folder = Folder::new();
    let mesh = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 1 2 0\nv 9 9 9\nf 1 2 3\nf 1 2 3 4\nf 1 2 3 4 5\nf 1 2\nf\n";
    let mesh = mesh.to_owned() + "l 1 2 3\np 1 2\nl 2 1\n";
    folder.write("s.txt", SCENE.replace(TRIANGLE, "TriangleMesh { obj_file m.obj }")).write("m.obj", &mesh);
    let run = folder.a2("-input s.txt -output o.png -size 9 9 -stats -report r.json -explain");
    let counts = "m.obj: vertices 6, faces 5, triangles 6, degenerate faces left out 2, polygons cut 2 (concave 1), \
                  points 2 and lines 2 left out\n";
    for line in [format!("\nmesh {counts}"), format!("\nmesh         {counts}")] {
        assert!(run.stderr.contains(&line), "{line}{}", run.stderr);
    }
    let report = folder.json("r.json");
    let expected = serde_json::json!([{
        "file": "m.obj", "vertices": 6, "faces": 5, "triangles": 6, "degenerate_faces_left_out": 2, "polygons_cut": 2,
        "concave_polygons": 1, "points_left_out": 2, "lines_left_out": 2,
    }]);
    assert_eq!(report["meshes"], expected);
    let plain = mesh.replace("f 1 2\nf\n", "");
    folder.write("m.obj", plain);
    let run = folder.a2("-input s.txt -check");
    assert!(
        run.stdout.contains(&counts.replace("faces 5", "faces 3").replace("out 2,", "out 0,")),
        "{}",
        run.stdout
    );
}

/// Each search reads the folder, and only ten mistakes are shown.
#[test]
fn three_thousand_missing_meshes_are_ten_mistakes() {
    let folder = Folder::new();
    let mesh = |n: usize| format!("MaterialIndex 0 TriangleMesh {{ obj_file mesh{n}x.obj }}\n");
    let meshes: String = (0..3000).map(mesh).collect();
    (0..3000).for_each(|n| _ = folder.write(&format!("mesh{n}.obj"), ""));
    folder.write("s.txt", with_material(&format!("Group {{ numObjects 3000\n{meshes}}}")));
    let run = folder.a2("s.txt -output o.png");
    assert_eq!(run.exit_code, 1);
    assert!(run.stderr.contains("did you mean 'mesh0.obj'?"), "{}", run.stderr);
    assert!(run.stderr.ends_with("10 mistakes or more: these are the first\n"), "{}", run.stderr);
}
