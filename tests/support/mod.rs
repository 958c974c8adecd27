//! Shared by the test binaries: a fresh folder, the real binary, pictures.
#![allow(dead_code)]

pub mod batch;
// It computes in `f64`.
#[cfg(not(feature = "f32"))]
pub mod reference;

use a2::args::{Request, parse};
use a2::options::Options;
use image::RgbImage;
use serde_json::Value;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// A fresh folder in which the real binary runs.
pub struct Folder {
    directory: TempDir,
}

/// The result of a run of the binary.
#[derive(Debug)]
pub struct Run {
    pub exit_code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Folder {
    pub fn new() -> Self {
        Self { directory: TempDir::new().unwrap() }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    pub fn write(&self, name: &str, contents: impl AsRef<[u8]>) -> &Self {
        std::fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        std::fs::write(self.path(name), contents).unwrap();
        self
    }

    /// Runs `a2` in the folder; arguments are separated by spaces.
    pub fn a2(&self, arguments: &str) -> Run {
        self.run(Command::new(env!("CARGO_BIN_EXE_a2")).args(arguments.split_whitespace()))
    }

    pub fn run(&self, command: &mut Command) -> Run {
        let output = command.current_dir(self.directory.path()).output().unwrap();
        Run {
            exit_code: output.status.code().unwrap_or(-1),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    pub fn picture(&self, name: &str) -> RgbImage {
        picture(&self.path(name))
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&std::fs::read(self.path(name)).unwrap()).unwrap()
    }

    /// Names of the files in the folder, sorted.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.directory.path()).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Renders the text of a scene; the run must succeed.
    pub fn render(&self, scene: &str, arguments: &str) -> RgbImage {
        self.write("scene.txt", scene);
        let run = self.a2(&format!("-input scene.txt -output out.png {arguments}"));
        assert_eq!(run.exit_code, 0, "{arguments}: {}", run.stderr);
        self.picture("out.png")
    }
}

/// Parses the command line of a picture, whose words are separated by spaces.
pub fn options(line: &str) -> Options {
    match parse(line.split_whitespace().map(OsString::from)) {
        Ok(Request::Render(options)) => *options,
        other => panic!("{line}: {other:?}"),
    }
}

/// Parses the same, and keeps the colours of the picture as numbers.
pub fn options_of_numbers(line: &str) -> Options {
    let mut options = options(line);
    options.measure.keep_linear = true;
    options
}

pub fn picture(path: &Path) -> RgbImage {
    image::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display())).into_rgb8()
}

/// A path in the project.
pub fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The colour of the pixel in the middle.
pub fn middle(picture: &RgbImage) -> [u8; 3] {
    picture.get_pixel(picture.width() / 2, picture.height() / 2).0
}

/// A scene of a white triangle in the plane z = 0 in the middle of the picture, lit from the eye, at a distance of
/// 10.
pub const SCENE: &str = "PerspectiveCamera { center 0 0 10 direction 0 0 -1 up 0 1 0 angle 90 }
Lights { numLights 1 DirectionalLight { direction 0 0 -1 color 1 1 1 } }
Background { color 0 0 0 }
Materials { numMaterials 1 Material { } }
Group { numObjects 1 MaterialIndex 0 Triangle { vertex0 -3 -3 0 vertex1 3 -3 0 vertex2 0 4 0 } }
";

/// The object of [`SCENE`].
pub const TRIANGLE: &str = "Triangle { vertex0 -3 -3 0 vertex1 3 -3 0 vertex2 0 4 0 }";

/// The light of [`SCENE`].
pub const LIGHT: &str = "DirectionalLight { direction 0 0 -1 color 1 1 1 }";

/// The camera of [`SCENE`].
pub const CAMERA_BLOCK: &str = "PerspectiveCamera { center 0 0 10 direction 0 0 -1 up 0 1 0 angle 90 }";

/// The square from -1 to 1 in the plane z = 0 as an OBJ file.
pub const SQUARE_OBJ: &str = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3\nf 1 3 4\n";
