//! Hints: what is probably not meant is told on a terminal, and nowhere else.

use crate::support::{Folder, SCENE};
#[cfg(target_os = "linux")]
use crate::terminal::on_a_terminal;

/// Scenes, flags and what is hinted at.
const CASES: [(&str, &str, &str, Option<&str>); 12] = [
    ("", "", "-output o.png", None),
    (
        "Material { }",
        "Material { specularColor 1 1 1 }",
        "-output o.png",
        Some("s.txt:4:28: this material is a mirror"),
    ),
    ("Material { }", "Material { specularColor 1 1 1 }", "-output o.png -bounces 0", None),
    ("Material { }", "Material { specularColor 1 1 1 }", "-normals n.png", None),
    (
        "Material { }",
        "Material { diffuseColor 255 51 0 }",
        "-output o.png",
        Some("s.txt:4:28: diffuseColor 255 51 0: colours are 0 to 1 (divided by 255 it is 1 0.2 0)"),
    ),
    ("color 0 0 0", "color 0 0 -0.5", "-output o.png", Some("s.txt: color 0 0 -0.5: colours are 0 to 1\r")),
    ("color 1 1 1", "color 9 9 9", "-output o.png", None),
    ("color 1 1 1", "color 1 1 -1", "-output o.png", Some("s.txt:2:22: color 1 1 -1: colours are 0 to 1")),
    ("direction 0 0 -1 up", "direction 0 0 1 up", "-output o.png", Some("no ray from the camera hits anything")),
    ("", "", "-depth 2 3 d.png", Some("nothing that is hit lies between 2 and 3: -depth auto finds the range")),
    ("", "", "-depth 9 16 d.png", None),
    ("direction 0 0 -1 up", "direction 0 0 1 up", "-output o.png -quiet", None),
];

#[cfg(target_os = "linux")]
#[test]
fn hints_are_told_on_a_terminal_once() {
    let folder = Folder::new();
    for (from, to, flags, expected) in CASES {
        folder.write("s.txt", SCENE.replace(from, to));
        let run = on_a_terminal(&folder, "", &format!("-input s.txt -size 21 21 {flags}"));
        assert_eq!(run.exit_code, 0, "{flags}: {}{}", run.stdout, run.stderr);
        let hints: Vec<&str> = run.stdout.split('\n').filter(|line| line.contains("hint: ")).collect();
        assert_eq!(hints.len(), usize::from(expected.is_some()), "{to} {flags}: {}", run.stdout);
        assert!(hints.iter().zip(expected).all(|(hint, part)| hint.contains(part)), "{to} {flags}: {hints:?}");
    }
}

#[test]
fn hints_are_for_terminals_only() {
    let folder = Folder::new();
    for (from, to, flags, _) in CASES {
        folder.write("s.txt", SCENE.replace(from, to));
        let run = folder.a2(&format!("-input s.txt -size 21 21 {flags}"));
        assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""), "{to} {flags}");
    }
}
