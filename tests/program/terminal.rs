//! What is said on a terminal only, and `-check`.

use crate::support::{Folder, Run, SCENE, project};
use std::process::Command;

/// Runs `a2` on a terminal of its own, which util-linux's `script` makes; what is said there is in `stdout`.
#[cfg(target_os = "linux")]
pub fn on_a_terminal(folder: &Folder, setting: &str, arguments: &str) -> Run {
    let line = format!("{setting} '{}' {arguments}", env!("CARGO_BIN_EXE_a2"));
    let mut command = Command::new("script");
    folder.run(command.args(["-qec", &line, "/dev/null"]).env_remove("NO_COLOR").env("TERM", "xterm"))
}

#[cfg(target_os = "linux")]
#[test]
fn errors_have_colors_on_a_terminal_that_wants_them() {
    let folder = Folder::new();
    folder.write("bad.txt", SCENE.replace("Material { }", "Material { shinines 3 }"));
    let line = "-output o.png bad.txt";
    let plain = folder.a2(line).stderr;
    assert!(!plain.contains('\u{1b}') && plain.contains("did you mean 'shininess'?"), "{plain}");
    for (setting, has_colors) in [("", true), ("NO_COLOR=1", false), ("NO_COLOR=", true), ("TERM=dumb", false)] {
        let run = on_a_terminal(&folder, setting, line);
        assert_eq!(run.exit_code, 1, "{}", run.stdout);
        assert_eq!(run.stdout.contains("\u{1b}[91merror\u{1b}[0m"), has_colors, "{setting}: {}", run.stdout);
        assert_eq!(run.stdout.replace('\r', "") == plain, !has_colors, "{setting}: {}", run.stdout);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_terminal_is_told_what_is_written() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    let written = |arguments: &str| {
        let run = on_a_terminal(&folder, "", arguments);
        assert_eq!(run.exit_code, 0, "{}", run.stdout);
        run.stdout.lines().find_map(|line| Some(line[line.find("wrote ")?..].trim_end().to_owned()))
    };
    let said = written("s.txt -output o.png -normals n.png -size 30 20").unwrap();
    assert!(said.starts_with("wrote o.png, n.png, 30 x 20, 0.") && said.ends_with(" s"), "{said}");
    assert_eq!(written("s.txt -output o.png -quiet"), None);
    assert_eq!(folder.a2("s.txt -output o.png").stderr, "");
    let run = on_a_terminal(&folder, "NO_COLOR=1", "s.txt -output -");
    assert_eq!(run.exit_code, 1);
    assert!(run.stdout.starts_with("error: -: standard output is a terminal"), "{}", run.stdout);
}

#[test]
fn check_reads_all_files_and_writes_none() {
    let folder = Folder::new();
    let scene = project("data/scene06_bunny_1k.txt");
    let run = folder.run(Command::new(env!("CARGO_BIN_EXE_a2")).arg(&scene).arg("-check"));
    let name = scene.display();
    assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""));
    let expected = format!("{name}: no mistakes: 1 light, 1 material, 2 objects, a cube map\nmesh ");
    assert!(run.stdout.starts_with(&expected), "{}", run.stdout);
    assert!(run.stdout.contains("bunny_1k.obj: vertices 502, faces 1000"), "{}", run.stdout);

    // A face that no ray reaches is read, too.
    folder.write("sky.txt", SCENE.replace("Background {", "Background { cubeMap sky "));
    for face in ["right", "left", "up", "down", "front", "back"] {
        folder.write(&format!("sky/{face}.png"), "");
        image::RgbImage::new(4, 4).save(folder.path(&format!("sky/{face}.png"))).unwrap();
    }
    assert_eq!(folder.a2("-check -output o.png -size 9 9 sky.txt").exit_code, 0);
    let back = std::fs::read(folder.path("sky/back.png")).unwrap();
    folder.write("sky/back.png", &back[..back.len() - 20]);
    let run = folder.a2("-check -output o.png -size 9 9 sky.txt");
    assert_eq!(run.exit_code, 1, "{}", run.stdout);
    assert!(run.stderr.starts_with("error: sky.txt:3:22: cube map face 'sky/back.png'"), "{}", run.stderr);
    folder.write("m.txt", SCENE.replace("Triangle {", "TriangleMesh { obj_file none.obj } Triangle {"));
    let run = folder.a2("m.txt -check");
    assert_eq!((run.exit_code, run.stdout.as_str()), (1, ""));
    let run = folder.a2("sky.txt -check -report r.json");
    assert_eq!((run.exit_code, run.stdout.as_str()), (2, ""));
    assert!(run.stderr.starts_with("error: -report: does not go with -check"), "{}", run.stderr);
    assert_eq!(folder.files(), ["m.txt", "sky", "sky.txt"]);
}
