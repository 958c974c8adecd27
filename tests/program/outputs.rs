//! Tests of where pictures go: links, pipes, devices, names that cannot be written, and files that would be lost.
#![cfg(unix)]

use crate::support::{Folder, Run, SCENE, middle};
use std::fs::{self, Permissions};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::process::Command;

/// Runs a command line of the shell, in which `a2` is the program.
fn shell(folder: &Folder, line: &str) -> Run {
    let line = format!("a2() {{ '{}' \"$@\"; }}; {line}", env!("CARGO_BIN_EXE_a2"));
    folder.run(Command::new("bash").args(["-c", &line]))
}

fn folder_with_scene() -> Folder {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    folder
}

fn must_be_refused(folder: &Folder, arguments: &str, part: &str) {
    let before = folder.files();
    let run = folder.a2(arguments);
    assert_eq!(run.exit_code, 1, "{arguments}: {}", run.stderr);
    assert!(run.stderr.contains(part), "{arguments}: {}", run.stderr);
    assert_eq!(folder.files(), before, "{arguments}");
}

#[test]
fn a_link_stays_and_its_target_is_replaced_with_the_same_mode() {
    let folder = folder_with_scene();
    folder.write("sub/target.png", "old");
    fs::set_permissions(folder.path("sub/target.png"), Permissions::from_mode(0o640)).unwrap();
    symlink("target.png", folder.path("sub/inner")).unwrap();
    symlink("sub/inner", folder.path("link.png")).unwrap();
    symlink("sub/new.png", folder.path("dangling.png")).unwrap();
    let run = folder.a2("-input s.txt -output link.png -normals dangling.png");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    assert!(folder.path("link.png").is_symlink() && folder.path("dangling.png").is_symlink());
    assert_eq!(fs::read_link(folder.path("sub/inner")).unwrap().to_str(), Some("target.png"));
    assert_eq!(folder.picture("sub/target.png").dimensions(), (100, 100));
    assert_eq!(folder.picture("sub/new.png").dimensions(), (100, 100));
    assert_eq!(folder.path("sub/target.png").metadata().unwrap().permissions().mode() & 0o7777, 0o640);
}

#[test]
fn pipes_and_devices_are_written_into() {
    let folder = folder_with_scene();
    for format in ["png", "pfm", "exr"].into_iter().filter(|format| *format != "exr" || cfg!(feature = "exr")) {
        let line = format!(
            "mkfifo p.{format}; cat p.{format} > got.{format} & a2 -input s.txt -output p.{format} && wait"
        );
        let run = shell(&folder, &line);
        assert_eq!(run.exit_code, 0, "{}", run.stderr);
        assert_eq!(folder.a2(&format!("-input s.txt -output file.{format}")).exit_code, 0);
        assert_eq!(
            fs::read(folder.path(&format!("got.{format}"))).unwrap(),
            fs::read(folder.path(&format!("file.{format}"))).unwrap(),
            "{format}"
        );
    }
    symlink("/dev/null", folder.path("null.png")).unwrap();
    symlink("/dev/null", folder.path("null2.png")).unwrap();
    assert_eq!(folder.a2("-input s.txt -output null.png -normals null2.png").exit_code, 0);
    assert!(folder.path("null.png").is_symlink());
    symlink("/dev/full", folder.path("full.png")).unwrap();
    must_be_refused(&folder, "-input s.txt -output full.png", "full.png: cannot write the picture");
}

#[test]
fn no_two_results_share_a_file() {
    let folder = folder_with_scene();
    folder.write("old.png", "old");
    symlink("old.png", folder.path("link.png")).unwrap();
    symlink(".", folder.path("here")).unwrap();
    let before = folder.files();
    for (first, second) in [
        ("-output o.png", "-normals o.png"),
        ("-output o.png", "-normals ./o.png"),
        ("-output here/o.png", "-error-map o.png"),
        ("-output old.png", "-normals link.png"),
        ("-normals link.png", "-error-map here/link.png"),
        ("-output -", "-report -"),
    ] {
        let run = folder.a2(&format!("-input s.txt {first} {second} -output x.png {first}"));
        assert_eq!(run.exit_code, 2, "{first} {second}: {}", run.stderr);
        let message = format!("error: {first} and {second} are the same file: one of them would be lost\n");
        assert!(run.stderr.starts_with(&message), "{message}{}", run.stderr);
        assert_eq!(folder.files(), before);
    }
    assert_eq!(fs::read(folder.path("old.png")).unwrap(), b"old");
}

#[test]
fn names_that_cannot_be_written_are_found_before_rendering() {
    let folder = folder_with_scene();
    folder.write("locked.png", "old");
    fs::set_permissions(folder.path("locked.png"), Permissions::from_mode(0o444)).unwrap();
    symlink("circle.png", folder.path("circle.png")).unwrap();
    // Rendering at this size would take minutes.
    let slow = "-input s.txt -size 20000 13000 -output o.png -normals";
    must_be_refused(&folder, &format!("{slow} {}.png", "x".repeat(300)), "File name too long");
    must_be_refused(&folder, &format!("{slow} locked.png"), "locked.png: this file is read-only");
    must_be_refused(&folder, &format!("{slow} circle.png"), "circle.png: cannot write this file");
    must_be_refused(&folder, &format!("{slow} s.txt/n.png"), "s.txt/n.png: cannot write this file");
}

#[test]
fn what_is_read_is_not_written_over() {
    let folder = folder_with_scene();
    let mesh = "TriangleMesh { obj_file m.obj }";
    folder
        .write("mesh.txt", SCENE.replace(crate::support::TRIANGLE, mesh))
        .write("m.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    assert_eq!(folder.a2("-input s.txt -output r.png").exit_code, 0);
    for face in ["right", "left", "up", "down", "front", "back"] {
        fs::create_dir_all(folder.path("sky")).unwrap();
        fs::copy(folder.path("r.png"), folder.path(&format!("sky/{face}.png"))).unwrap();
    }
    folder.write("sky.txt", SCENE.replace("Background {", "Background { cubeMap sky "));
    symlink("s.txt", folder.path("scene.png")).unwrap();
    symlink("m.obj", folder.path("mesh.png")).unwrap();
    for (arguments, file) in [
        ("-input s.txt -output scene.png", "s.txt"),
        ("-input mesh.txt -output mesh.png", "m.obj"),
        ("-input sky.txt -output o.png -normals sky/up.png", "sky/up.png"),
        // Also where these pictures show no cube map.
        ("-input sky.txt -normals ./sky/left.png", "sky/left.png"),
        ("-input sky.txt -depth 8 12 sky/down.png", "sky/down.png"),
        ("-input sky.txt -depth auto sky/back.png", "sky/back.png"),
        ("-input s.txt -output ./r.png -reference r.png", "r.png"),
    ] {
        must_be_refused(&folder, arguments, &format!("{file}: this file is read, so it must not be written over"));
    }
    let run = folder.a2("-compare r.png sky/up.png -diff ./r.png");
    assert_eq!(run.exit_code, 2, "{}", run.stderr);
    assert!(run.stderr.contains("r.png: this file is read"), "{}", run.stderr);
}

#[test]
fn four_writers_of_one_name_leave_a_whole_file() {
    let folder = folder_with_scene();
    let run = shell(
        &folder,
        "for i in 1 2 3 4 5 6 7 8 9 10; do for n in 1 2 3 4; do a2 -input s.txt -output o.png -size 20$n 100 & done; \
         wait; a2 -compare o.png o.png > same || exit 9; done",
    );
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    assert_eq!(folder.files(), ["o.png", "s.txt", "same"]);
    assert!((201..=204).contains(&folder.picture("o.png").width()));
}

#[test]
fn results_that_cannot_be_printed_are_an_error() {
    let folder = folder_with_scene();
    assert_eq!(folder.a2("-input s.txt -output o.png").exit_code, 0);
    assert_ne!(middle(&folder.picture("o.png")), [0; 3]);
    for command in ["-help", "-version", "-compare o.png o.png"] {
        let run = shell(&folder, &format!("a2 {command} > /dev/full"));
        assert_eq!(run.exit_code, 2, "{command}");
        assert!(run.stderr.contains("error: cannot write to standard output: No space left"), "{}", run.stderr);
    }
}

#[test]
fn a_dash_is_standard_input_and_output() {
    let folder = folder_with_scene();
    let flags = "-size 31 17 -seed 7 -jitter";
    assert_eq!(folder.a2(&format!("s.txt -output o.png {flags} -report r.json")).exit_code, 0);
    for line in [
        format!("a2 - -output - {flags} < s.txt > got.png"),
        format!("a2 -input - -output - {flags} < s.txt | cat > got.png"),
        format!("cat s.txt | a2 -output got.png -input - {flags}"),
        format!("a2 s.txt -normals n.png -output - {flags} > got.png"),
    ] {
        let _ = fs::remove_file(folder.path("got.png"));
        let run = shell(&folder, &line);
        assert_eq!((run.exit_code, run.stderr.as_str(), run.stdout.as_str()), (0, "", ""), "{line}");
        assert_eq!(fs::read(folder.path("got.png")).unwrap(), fs::read(folder.path("o.png")).unwrap(), "{line}");
    }
    let report = folder.a2(&format!("s.txt -output o.png {flags} -report -")).stdout;
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let in_a_file = folder.json("r.json");
    assert!(report["estimated_error"]["levels"].is_object());
    for key in ["scene", "width", "height", "seed", "samples", "estimated_error"] {
        assert_eq!(report[key], in_a_file[key], "{key}");
    }
    assert!(!folder.path("-").exists());
    let run = shell(&folder, "echo 'Group { numObjects x }' | a2 - -output o.png");
    assert_eq!(run.exit_code, 1);
    assert!(run.stderr.starts_with("error: standard input:1:20: expected a whole number"), "{}", run.stderr);
    let run = shell(&folder, "a2 s.txt -output - > /dev/full");
    assert_eq!(run.exit_code, 1);
    assert!(run.stderr.starts_with("error: -: cannot write the picture: No space left"), "{}", run.stderr);
    // A name in the current folder, and not a flag.
    assert_eq!(folder.a2("s.txt -output ./-.png").exit_code, 0);
}
