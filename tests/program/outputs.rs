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

/// One reader cannot tell two files apart, but a device takes what it is given.
#[test]
fn no_two_results_share_a_pipe() {
    let folder = folder_with_scene();
    symlink("/dev/stdout", folder.path("so.png")).unwrap();
    symlink("/dev/stdout", folder.path("so.json")).unwrap();
    for line in [
        "mkfifo f.png; (a2 s.txt -output f.png -normals ./f.png; echo $? > code) & cat f.png; wait; exit $(cat code)",
        "a2 s.txt -output - -normals so.png | cat; exit ${PIPESTATUS[0]}",
        "a2 s.txt -normals so.png -report so.json | cat; exit ${PIPESTATUS[0]}",
        "a2 s.txt -output - -normals both.png > both.png",
        "a2 s.txt -output so.png -report so.json > both.png",
    ] {
        // A reader of a pipe that nobody opens would wait for ever.
        let run = shell(&folder, &line.replace("cat f.png", "timeout 1 cat f.png"));
        assert_eq!((run.exit_code, run.stdout.as_str()), (2, ""), "{line}: {}", run.stderr);
        assert!(run.stderr.contains("are the same file: one of them would be lost"), "{line}: {}", run.stderr);
    }
    let run = shell(&folder, "a2 s.txt -output so.png > one.png");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    assert_eq!(folder.picture("one.png").dimensions(), (100, 100));
}

#[test]
fn names_are_shown_without_control_characters() {
    let folder = folder_with_scene();
    for line in [
        "a2 $'\\e[31mx.txt' -output o.png",
        "a2 s.txt -output $'no\\e[31md/o.png'",
        "a2 s.txt -output $'o.\\e[31m'",
        "a2 s.txt $'\\e[31m'",
        "cp s.txt $'\\e[31m.txt'; echo x >> $'\\e[31m.txt'; a2 $'\\e[31m.txt' -check",
    ] {
        let run = shell(&folder, line);
        assert_ne!(run.exit_code, 0, "{line}");
        assert!(run.stderr.contains("␛[31m") && !run.stderr.contains('\x1b'), "{line}: {}", run.stderr);
    }
    let run = shell(&folder, "cp s.txt $'\\e[32m.txt'; a2 $'\\e[32m.txt' -check");
    assert!(run.stdout.starts_with("␛[32m.txt: no mistakes"), "{}", run.stdout);
}

#[test]
fn errors_of_the_system_say_what_refused() {
    let folder = folder_with_scene();
    symlink("/proc/version", folder.path("version.png")).unwrap();
    must_be_refused(&folder, "s.txt -output version.png", "version.png: cannot write ");
    let run = shell(&folder, "ulimit -n 4; a2 s.txt -output o.png");
    assert_eq!(run.exit_code, 1, "{}", run.stderr);
    assert!(run.stderr.contains("'ulimit -n' shows how many"), "{}", run.stderr);
    // The superuser may write anywhere, so another user tries, if this one may become another.
    folder.write("locked/o.png", "old");
    let open = |mode| fs::set_permissions(folder.path(mode), Permissions::from_mode(0o777));
    open(".").unwrap();
    fs::set_permissions(folder.path("locked/o.png"), Permissions::from_mode(0o666)).unwrap();
    fs::set_permissions(folder.path("locked"), Permissions::from_mode(0o555)).unwrap();
    let program = folder.path("a2");
    fs::copy(env!("CARGO_BIN_EXE_a2"), &program).unwrap();
    let as_other = "setpriv --reuid 54321 --regid 54321 --clear-groups ./a2 s.txt -output locked/o.png";
    let line = format!("if [ $(id -u) = 0 ]; then {as_other}; else ./a2 s.txt -output locked/o.png; fi");
    let run = shell(&folder, &line);
    assert_eq!(run.exit_code, 1, "{}", run.stderr);
    assert!(run.stderr.contains("because no file can be made in its folder: Permission denied"), "{}", run.stderr);
    fs::set_permissions(folder.path("locked"), Permissions::from_mode(0o755)).unwrap();
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
    for (command, exit_code) in [
        ("-help", 1),
        ("-version", 1),
        ("s.txt -check", 1),
        ("s.txt -pixel 50 50", 1),
        // 1 would mean that they differ.
        ("-compare o.png o.png", 2),
    ] {
        for (output, message) in [("> /dev/full", "No space left"), ("1< /dev/null", "Bad file descriptor")] {
            let run = shell(&folder, &format!("a2 {command} {output}"));
            assert_eq!(run.exit_code, exit_code, "{command} {output}");
            let message = format!("error: cannot write to standard output: {message}");
            assert!(run.stderr.contains(&message), "{command} {output}: {}", run.stderr);
        }
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
