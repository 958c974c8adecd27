//! Broken files of every kind give a picture or one clear error, never a crash and never a half-written picture.

use crate::support::{Folder, project};
use std::process::Command;

/// A small random number generator (xorshift64*), so that every run breaks the files in the same ways.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % bound
    }
}

/// Breaks a text: deletes, repeats, swaps or replaces words, or changes a character.
fn mutated(text: &str, random: &mut Random) -> String {
    const STRANGE: [&str; 16] = [
        "{",
        "}",
        "-",
        "nan",
        "1e308",
        "-1e-320",
        "0",
        "-1",
        "99999999999999",
        "Group",
        "Transform",
        "MaterialIndex",
        "\u{0}",
        "é",
        "Matrix4f { 1",
        "1/2/3",
    ];
    let mut words: Vec<String> = text.split_inclusive(char::is_whitespace).map(str::to_owned).collect();
    for _ in 0..1 + random.below(3) {
        let (at, other) = (random.below(words.len()), random.below(words.len()));
        match random.below(6) {
            0 => drop(words.remove(at)),
            1 => words.insert(at, words[other].clone()),
            2 => words.swap(at, other),
            3 => words[at] = format!("{} ", STRANGE[random.below(STRANGE.len())]),
            4 => words.truncate(at.max(1)),
            _ => {
                let mut letters: Vec<char> = words[at].chars().collect();
                let position = random.below(letters.len());
                letters[position] = char::from(33 + random.below(94) as u8);
                words[at] = letters.into_iter().collect();
            }
        }
    }
    words.concat()
}

/// Runs the binary, which must write a picture or exit with an error.
fn must_not_crash(folder: &Folder, what: &str) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_a2"));
    command.args("-input s.txt -output o.png -size 4 4 -bounces 2 -shadows".split(' '));
    let run = folder.run(&mut command);
    assert!(run.exit_code == 0 || run.exit_code == 1, "exit code {}\n{}\n{what}", run.exit_code, run.stderr);
    assert!(!run.stderr.contains("panicked"), "{}\n{what}", run.stderr);
    assert_eq!(run.exit_code == 0, folder.path("o.png").exists(), "{what}");
    if run.exit_code == 1 {
        assert!(run.stderr.starts_with("error: "), "{}\n{what}", run.stderr);
    }
    let _ = std::fs::remove_file(folder.path("o.png"));
}

const SCENES: [&str; 4] = ["scene01_plane.txt", "scene02_cube.txt", "scene04_axes.txt", "scene07_arch.txt"];

#[test]
fn broken_scenes_do_not_crash() {
    let folder = Folder::new();
    folder.write("models/cube2.obj", std::fs::read(project("data/models/cube2.obj")).unwrap());
    let mut random = Random(1);
    for round in 0..200 {
        let text = std::fs::read_to_string(project("data").join(SCENES[round % SCENES.len()])).unwrap();
        let text = mutated(&text.replace("cubeMap", "# cubeMap"), &mut random);
        folder.write("s.txt", &text);
        must_not_crash(&folder, &text);
    }
}

#[test]
fn broken_meshes_do_not_crash() {
    let folder = Folder::new();
    folder.write("s.txt", std::fs::read(project("data/scene02_cube.txt")).unwrap());
    let mesh = std::fs::read_to_string(project("data/models/cube2.obj")).unwrap();
    let mut random = Random(2);
    for _ in 0..100 {
        let text = mutated(&mesh, &mut random);
        folder.write("models/cube2.obj", &text);
        must_not_crash(&folder, &text);
    }
}

#[test]
fn broken_cube_map_faces_do_not_crash() {
    let folder = Folder::new();
    folder.write(
        "s.txt",
        "PerspectiveCamera { center 0 0 0 direction 1 0 0 up 0 1 0 angle 30 }
         Background { cubeMap map } Group { numObjects 0 }",
    );
    let mut face = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_fn(9, 7, |x, y| image::Rgb([x as u8, y as u8, 77]))
        .write_to(&mut face, image::ImageFormat::Png)
        .unwrap();
    let face = face.into_inner();
    for name in ["right", "left", "up", "down", "front", "back"] {
        folder.write(&format!("map/{name}.png"), &face);
    }
    must_not_crash(&folder, "whole");
    let mut random = Random(3);
    for round in 0..60 {
        let mut broken = face.clone();
        let at = random.below(broken.len());
        if round % 3 == 0 {
            broken.truncate(at);
        } else {
            broken[at] = random.below(256) as u8;
        }
        folder.write("map/right.png", &broken);
        must_not_crash(&folder, &format!("round {round}"));
    }
}
