//! `docs/messages.md`: ten ways to break a scene, and what the program says to each.

use crate::snapshots::holds_at;
use crate::support::{Folder, project};
use std::fmt::Write as _;

/// What is broken, the text of the scene that it replaces, and what the message must say for the mistake to be found.
const BROKEN: [(&str, &str, &str, &str); 10] = [
    ("A word is misspelt.", "shininess 30", "shinines 30", "did you mean 'shininess'?"),
    ("A number is missing.", "center 0 0 10", "center 0 10", "'center' takes 3 numbers"),
    ("There is a number too many.", "angle 30", "angle 30 40", "'angle' takes 1 number, and this is a 2nd"),
    (
        "A brace is missing.",
        "shininess 30\n    }\n}",
        "shininess 30\n}",
        "expected '}' to end the 'Material' of line 24",
    ),
    ("Numbers have commas between them.", "color 0.2 0 0.6", "color 0.2, 0, 0.6", "no commas: write '0.2 0 0.6'"),
    (
        "A character comes from a Chinese keyboard.",
        "Translate 0.5 -2.6 0",
        "Translate 0.5 \u{ff0d}2.6 0",
        "is a full-width character: type '-'",
    ),
    ("The name of a file is wrong.", "bunny_1k.obj", "bunny1k.obj", "did you mean 'models/bunny_1k.obj'?"),
    (
        "A `MaterialIndex` is the number of no material.",
        "MaterialIndex 0\n    Plane",
        "MaterialIndex 1\n    Plane",
        "one material, number 0",
    ),
    ("A count is not that of what stands there.", "numLights 1", "numLights 2", "says 2, but 1 light stands here"),
    ("A word comes from another format.", "specularColor", "reflectiveColor", "a 'specularColor' longer than 0.1"),
];

const HEAD: &str = "\
# What the program says

Written by `tests/program/messages.rs`: scene06 is broken in ten ways, one after another, and here is what `a2 scene.txt
-output 06.png` then says. All mistakes that can be told apart are shown in one run, up to ten, and the last section shows
two of them. `a2 scene.txt -check` looks for mistakes without rendering.
";

/// Makes a folder with scene06 and its files. Comments would be in the way of the line numbers.
fn folder_with_scene06() -> (Folder, String) {
    let folder = Folder::new();
    let data = project("data");
    for file in ["models/bunny_1k.obj", "models/bunny_200.obj", "tex/courtyard"].map(|name| data.join(name)) {
        let name = file.strip_prefix(&data).unwrap().to_str().unwrap().to_owned();
        if file.is_dir() {
            for face in std::fs::read_dir(&file).unwrap().map(|entry| entry.unwrap().path()) {
                let face_name = face.file_name().unwrap().to_str().unwrap();
                folder.write(&format!("{name}/{face_name}"), std::fs::read(&face).unwrap());
            }
        } else {
            folder.write(&name, std::fs::read(file).unwrap());
        }
    }
    let scene = std::fs::read_to_string(data.join("scene06_bunny_1k.txt")).unwrap();
    let lines: Vec<&str> = scene.lines().skip_while(|line| line.starts_with('#') || line.is_empty()).collect();
    (folder, lines.join("\n") + "\n")
}

/// Runs a scene that must be refused; returns the message.
fn message(folder: &Folder, scene: &str) -> String {
    folder.write("scene.txt", scene);
    let run = folder.a2("scene.txt -output 06.png -size 20 20");
    assert_eq!(run.exit_code, 1, "{scene}\n{}", run.stderr);
    run.stderr
}

#[test]
fn ten_broken_scenes_and_what_is_said() {
    let (folder, scene) = folder_with_scene06();
    folder.write("scene.txt", &scene);
    let run = folder.a2("scene.txt -output 06.png -size 20 20");
    assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""));
    let mut page = HEAD.to_owned();
    let mut both = scene.clone();
    for (index, (what, from, to, expected)) in BROKEN.into_iter().enumerate() {
        assert_eq!(scene.matches(from).count(), 1, "{from}");
        let said = message(&folder, &scene.replace(from, to));
        assert!(said.starts_with("error: scene.txt:") && said.contains(expected), "{expected}\n{said}");
        assert_eq!(said.matches("error: ").count(), 1, "{said}");
        let _ = write!(page, "\n## {}. {what}\n\n```text\n{said}```\n", index + 1);
        if [0, 6].contains(&index) {
            both = both.replace(from, to);
        }
    }
    let said = message(&folder, &both);
    assert!(said.ends_with("\nerror: 2 mistakes\n"), "{said}");
    let _ = write!(page, "\n## Two at once\n\n```text\n{said}```\n");
    holds_at(&project("docs/messages.md"), &page);
}
