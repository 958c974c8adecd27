//! Tests of the command line, by running the program.

use crate::support::{Folder, LIGHT, SCENE, TRIANGLE, middle};
use std::process::Command;

#[test]
fn no_arguments_print_the_usage_and_exit_with_2() {
    let run = Folder::new().a2("");
    assert_eq!(run.exit_code, 2);
    assert!(run.stderr.starts_with("Usage: a2 SCENE.txt -output"), "{}", run.stderr);
    assert_eq!(run.stdout, "");
}

#[test]
fn help_and_version_exit_with_0() {
    let folder = Folder::new();
    for help in ["-help", "--help"] {
        let run = folder.a2(help);
        assert_eq!(run.exit_code, 0);
        for flag in ["-input", "-depth MIN MAX FILE", "-compare", "-seed"] {
            assert!(run.stdout.contains(flag), "{flag}");
        }
    }
    assert!(folder.a2("-version").stdout.starts_with(&format!("a2 {}\n", env!("CARGO_PKG_VERSION"))));
}

#[test]
fn a_wrong_command_line_exits_with_2() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    for (arguments, part) in [
        ("-input s.txt", "no picture is asked for"),
        ("-output o.png", "-input is missing"),
        ("-input s.txt -output o.png -size 0 4", "from 1 to 65536, found '0'"),
        ("-input s.txt -output o.png -bounces -2", "-bounces: expected"),
        ("-input s.txt -output o.bmp", "ends in .png"),
        ("-input s.txt -output o.png -shadow", "did you mean -shadows"),
        ("-input s.txt -output", "-output needs 1 value: -output FILE"),
        ("-input s.txt -depth 1 2", "-depth needs 3 values: -depth MIN MAX FILE"),
    ] {
        let run = folder.a2(arguments);
        assert_eq!(run.exit_code, 2, "{arguments}");
        assert!(run.stderr.starts_with("error: ") && run.stderr.contains(part), "{arguments}: {}", run.stderr);
        assert_eq!(run.stdout, "");
    }
    assert_eq!(folder.files(), ["s.txt"]);
}

#[test]
fn errors_exit_with_1_and_leave_no_file() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE).write("bad.txt", "Group {").write("latin.txt", b"Group { \xe9 }");
    std::fs::create_dir(folder.path("folder.png")).unwrap();
    std::fs::create_dir(folder.path("folder.txt")).unwrap();
    for (arguments, part) in [
        ("-input none.txt -output o.png", "none.txt: cannot read the scene"),
        ("-input bad.txt -output o.png", "bad.txt:1:8: expected"),
        ("-input latin.txt -output o.png", "latin.txt:1:9: this is not UTF-8 text: save the file as UTF-8"),
        ("-input folder.txt -output o.png", "this is a folder"),
        ("-input s.txt -output nowhere/o.png", "the folder 'nowhere' does not exist"),
        ("-input s.txt -output folder.png", "folder.png: this is a folder"),
        ("-input s.txt -output o.png -normals nowhere/n.png", "nowhere/n.png"),
    ] {
        let run = folder.a2(arguments);
        assert_eq!(run.exit_code, 1, "{arguments}: {}", run.stderr);
        assert!(run.stderr.starts_with("error: ") && run.stderr.contains(part), "{arguments}: {}", run.stderr);
    }
    assert_eq!(folder.files(), ["bad.txt", "folder.png", "folder.txt", "latin.txt", "s.txt"]);
}

#[test]
fn one_run_writes_all_three_pictures() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    let run = folder.a2("-input s.txt -output c.png -normals n.png -depth 9 11 d.png -size 9 5");
    assert_eq!((run.exit_code, run.stdout.as_str(), run.stderr.as_str()), (0, "", ""));
    assert_eq!(folder.files(), ["c.png", "d.png", "n.png", "s.txt"]);
    // The triangle fills the middle at distance 10: half of the way from 9 to 11.
    assert_eq!(middle(&folder.picture("c.png")), [255, 255, 255]);
    assert_eq!(middle(&folder.picture("n.png")), [127, 127, 255]);
    assert_eq!(middle(&folder.picture("d.png")), [127, 127, 127]);
    // The corners show the background.
    assert_eq!(folder.picture("c.png").get_pixel(0, 0).0, [0, 0, 0]);
    assert_eq!(folder.picture("n.png").get_pixel(0, 0).0, [127, 127, 127]);
    assert_eq!(folder.picture("d.png").get_pixel(0, 0).0, [0, 0, 0]);
}

#[test]
fn a_failed_run_keeps_the_existing_picture() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE).write("bad.txt", "Nonsense").write("o.png", "precious");
    assert_eq!(folder.a2("-input bad.txt -output o.png").exit_code, 1);
    assert_eq!(std::fs::read(folder.path("o.png")).unwrap(), b"precious");
    assert_eq!(folder.a2("-input s.txt -output o.png").exit_code, 0);
    assert_eq!(folder.picture("o.png").dimensions(), (100, 100));
}

/// A limit on the size of files simulates a full disk.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_and_leaves_no_file() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE.replace(TRIANGLE, "Sphere { center 0 0 0 radius 9 }"));
    let names = if cfg!(feature = "exr") { ["o.png", "o.pfm", "o.exr"].as_slice() } else { &["o.png", "o.pfm"] };
    for name in names {
        let command = format!(
            "trap '' XFSZ; ulimit -f 1; exec '{}' -input s.txt -output {name} -size 900 900",
            env!("CARGO_BIN_EXE_a2")
        );
        let run = folder.run(Command::new("bash").args(["-c", &command]));
        assert_eq!(run.exit_code, 1, "{}", run.stderr);
        let expected = format!("{name}: cannot write the picture: File too large");
        assert!(run.stderr.contains(&expected), "{}", run.stderr);
        assert_eq!(folder.files(), ["s.txt"]);
    }
}

#[test]
fn quiet_silences_hints_but_no_warning_that_a_picture_is_wrong() {
    let folder = Folder::new();
    folder.write("dark.txt", SCENE.replace("numLights 1", "numLights 0").replace(LIGHT, ""));
    let run = folder.a2("-input dark.txt -output o.png");
    assert!(
        run.stderr.contains("hint: dark.txt: the scene has no lights: ambient light becomes 1 1 1"),
        "{}",
        run.stderr
    );
    assert_eq!(middle(&folder.picture("o.png")), [255, 255, 255]);
    assert_eq!(folder.a2("-input dark.txt -output o.png -quiet").stderr, "");

    let point = "PointLight { position 0 0 5 color 1 1 1 }";
    folder.write("infinite.txt", SCENE.replace(LIGHT, point));
    for quiet in ["", "-quiet"] {
        let run = folder.a2(&format!("-input infinite.txt -output o.png {quiet}"));
        let message = "warning: infinite.txt:2:22: this PointLight has no falloff";
        assert!(run.stderr.starts_with(message), "{quiet}: {}", run.stderr);
        let run = folder
            .a2(&format!("-input infinite.txt -output o.png -jitter -target-error 1e-9 -time-limit 0.1 {quiet}"));
        assert_eq!(run.exit_code, 3);
        assert!(run.stderr.contains("warning: the target error of 1e-9 levels was not reached"), "{}", run.stderr);
    }
}

#[test]
fn paths_are_relative_to_the_scene_and_may_be_any_text() {
    let folder = Folder::new();
    let scene = SCENE.replace(TRIANGLE, "TriangleMesh { obj_file modèles/carré.obj }");
    folder.write("tiefe Ordner/scène.txt", scene);
    folder.write("tiefe Ordner/modèles/carré.obj", crate::support::SQUARE_OBJ);
    let run = folder.run(Command::new(env!("CARGO_BIN_EXE_a2")).args([
        "-input",
        "tiefe Ordner/scène.txt",
        "-output",
        "Bild 1.png",
    ]));
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    assert_eq!(middle(&folder.picture("Bild 1.png")), [255, 255, 255]);
}

#[test]
fn explain_says_what_is_left_out() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    let run = folder.a2("-input s.txt -output o.png -bounces 3 -explain");
    for part in ["left out: shadow rays", "left out: mirror rays: no material", "camera rays: 10000"] {
        assert!(run.stderr.contains(part), "{part}: {}", run.stderr);
    }
}

#[test]
fn negative_numbers_are_no_flags() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    for number in ["-5", "-.5", "-1e-3", "-1E+3", "-0.5e2", "-1e300"] {
        let run = folder.a2(&format!("-input s.txt -depth {number} 15 d.png"));
        assert_eq!(run.exit_code, 0, "{number}: {}", run.stderr);
    }
    assert!(folder.a2("-input s.txt -size -1e-3 5 -output o.png").stderr.contains("-size: expected"));
}

#[test]
fn what_gives_strange_pictures_is_warned_about() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    for (scale, is_lost) in [("1e-6", false), ("1e-20", true)] {
        let sphere = format!("Transform {{ Scale 1 1 {scale} Sphere {{ center 0 0 0 radius 1 }} }}");
        folder.write("thin.txt", SCENE.replace(TRIANGLE, &sphere));
        let run = folder.a2("-input thin.txt -output o.png");
        assert_eq!(run.stderr.contains("this sphere is flattened to"), is_lost, "{}", run.stderr);
    }
    // The scene is 2 across, so that its rounding is about 1e-16.
    for (epsilon, is_lost) in [("0", true), ("1e-20", true), ("1e-9", false)] {
        let run = folder.a2(&format!("-input s.txt -output o.png -shadows -epsilon {epsilon}"));
        assert_eq!(run.stderr.contains("rays hit the surface that they leave"), is_lost, "{}", run.stderr);
        assert_eq!(folder.a2(&format!("-input s.txt -output o.png -epsilon {epsilon}")).stderr, "");
    }
    let light = "DirectionalLight { direction 0 0 -1 color 1.7e308 0 0 }";
    folder.write("bright.txt", SCENE.replace(LIGHT, light));
    let run = folder.a2("-input bright.txt -output o.png");
    assert!(run.stderr.contains("bright.txt:2:22: this light is brighter than numbers go"), "{}", run.stderr);
}
