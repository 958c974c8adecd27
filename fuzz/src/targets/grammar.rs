//! Scenes made of bytes: nearly all are valid.

use arbitrary::{Result, Unstructured};
use std::fmt::Write;
use std::path::Path;

pub const CUBE_MAP: &str = "sky";

/// The names of the meshes: a cube, a sheet that needs a tree, an arrow head.
const MESHES: [&str; 3] = ["cube.obj", "sheet.obj", "arrow.obj"];

/// Which numbers stand in a scene.
#[derive(Clone, Copy, PartialEq)]
pub enum Numbers {
    /// Any, also those that overflow when they are multiplied.
    Any,
    /// Such as people write.
    Usual,
}

/// Writes the meshes that scenes name.
pub fn write_meshes(folder: &Path) {
    let cube = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
                f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 4 8 7 3\nf 1 5 8 4\nf 2 3 7 6\n";
    let mut sheet = String::new();
    for corner in 0..100 {
        let (x, y) = (corner % 10, corner / 10);
        let _ = writeln!(sheet, "v {}.5 {}.25 0.{}", x - 5, y - 5, corner * 7 % 10);
    }
    for corner in (1..90).filter(|corner| corner % 10 != 0) {
        let _ = writeln!(sheet, "f {corner} {} {} {}", corner + 1, corner + 11, corner + 10);
    }
    let arrow = "v 0 0 0\nv 2 1 0\nv 0 2 0.5\nv 0.5 1 0\nf 1 2 3 4\nf 4 3 2\n";
    for (name, text) in MESHES.into_iter().zip([cube, &sheet, arrow]) {
        std::fs::write(folder.join(name), text).expect("a mesh");
    }
}

/// Writes a scene.
///
/// # Errors
/// Those of `arbitrary`.
pub fn scene(bytes: &mut Unstructured, numbers: Numbers) -> Result<String> {
    let mut writer = Writer { bytes, numbers, text: String::new(), materials: 0, objects: 0 };
    writer.camera()?;
    writer.lights()?;
    writer.background()?;
    writer.materials()?;
    writer.group(0)?;
    Ok(writer.text)
}

struct Writer<'a, 'b> {
    bytes: &'a mut Unstructured<'b>,
    numbers: Numbers,
    text: String,
    materials: u8,
    objects: u32,
}

/// So few objects that a picture is quick, and more than are tested one by one.
const MOST_OBJECTS: u32 = 40;

impl Writer<'_, '_> {
    fn add(&mut self, text: &str) {
        self.text += text;
        self.text.push(' ');
    }

    fn number(&mut self) -> Result<()> {
        const USUAL: [&str; 12] = ["0", "1", "-1", "0.5", "2", "-3", "5", "0.1", "-0.25", "10", "1e-3", "90"];
        const ODD: [&str; 8] = ["1e-30", "1e30", "-1e160", "1e308", "-0", "5e-324", "1e-160", "16777217"];
        let word = match self.bytes.int_in_range(0..=7)? {
            0..=3 => (*self.bytes.choose(&USUAL)?).to_owned(),
            7 if self.numbers == Numbers::Any => (*self.bytes.choose(&ODD)?).to_owned(),
            _ => format!("{}", f64::from(self.bytes.int_in_range(-1000..=1000_i32)?) / 64.0),
        };
        self.add(&word);
        Ok(())
    }

    fn field(&mut self, name: &str, count: usize) -> Result<()> {
        self.add(name);
        (0..count).try_for_each(|_| self.number())
    }

    /// A number above zero, for what must be.
    fn positive(&mut self, name: &str) -> Result<()> {
        let number = f64::from(self.bytes.int_in_range(1..=200_u8)?) / 32.0;
        self.add(&format!("{name} {number}"));
        Ok(())
    }

    fn color(&mut self, name: &str) -> Result<()> {
        self.add(name);
        for _ in 0..3 {
            let share = f64::from(self.bytes.int_in_range(0..=40_u8)?) / 32.0;
            self.add(&share.to_string());
        }
        Ok(())
    }

    fn camera(&mut self) -> Result<()> {
        self.add("PerspectiveCamera {");
        self.field("center", 3)?;
        self.field("direction", 3)?;
        self.field("up", 3)?;
        let degrees = self.bytes.int_in_range(1..=179_u8)?;
        self.add(&format!("angle {degrees} }}\n"));
        Ok(())
    }

    fn lights(&mut self) -> Result<()> {
        let count = self.bytes.int_in_range(0..=3_u8)?;
        if count == 0 {
            return Ok(());
        }
        self.add(&format!("Lights {{ numLights {count}"));
        for _ in 0..count {
            if self.bytes.ratio(1, 2)? {
                self.add("DirectionalLight {");
                self.field("direction", 3)?;
            } else {
                self.add("PointLight {");
                self.field("position", 3)?;
                // Without one, light is infinite.
                if self.numbers == Numbers::Usual || self.bytes.ratio(3, 4)? {
                    self.positive("falloff")?;
                }
            }
            self.color("color")?;
            self.add("}");
        }
        self.add("}\n");
        Ok(())
    }

    fn background(&mut self) -> Result<()> {
        self.add("Background {");
        self.color("color")?;
        self.color("ambientLight")?;
        if self.bytes.ratio(1, 4)? {
            self.add(&format!("cubeMap {CUBE_MAP}"));
        }
        self.add("}\n");
        Ok(())
    }

    fn materials(&mut self) -> Result<()> {
        self.materials = self.bytes.int_in_range(1..=3)?;
        self.add(&format!("Materials {{ numMaterials {}", self.materials));
        for _ in 0..self.materials {
            self.add("Material {");
            self.color("diffuseColor")?;
            if self.bytes.ratio(2, 3)? {
                self.color("specularColor")?;
                self.positive("shininess")?;
            }
            self.add("}");
        }
        self.add("}\n");
        Ok(())
    }

    fn group(&mut self, depth: u32) -> Result<()> {
        let most = if depth == 0 { MOST_OBJECTS } else { 4 };
        let count = self.bytes.int_in_range(0..=most)?.min(MOST_OBJECTS.saturating_sub(self.objects));
        self.objects += count;
        self.add(&format!("Group {{ numObjects {count}"));
        for number in 0..count {
            if (number == 0 && depth == 0) || self.bytes.ratio(1, 3)? {
                let index = self.bytes.int_in_range(0..=self.materials - 1)?;
                self.add(&format!("MaterialIndex {index}"));
            }
            self.object(depth + 1)?;
        }
        self.add("}\n");
        Ok(())
    }

    fn object(&mut self, depth: u32) -> Result<()> {
        match self.bytes.int_in_range(0..=7)? {
            0 | 1 => {
                self.field("Sphere { center", 3)?;
                self.positive("radius")?;
            }
            2 => {
                self.field("Plane { normal", 3)?;
                self.field("offset", 1)?;
            }
            3 | 4 => {
                self.add("Triangle {");
                ["vertex0", "vertex1", "vertex2"].into_iter().try_for_each(|name| self.field(name, 3))?;
            }
            5 => {
                let mesh = *self.bytes.choose(&MESHES)?;
                self.add(&format!("TriangleMesh {{ obj_file {mesh}"));
            }
            6 if depth < 4 => return self.transform(depth),
            7 if depth < 4 => return self.group(depth),
            _ => self.add("Sphere { center 0 0 0 radius 1"),
        }
        self.add("}\n");
        Ok(())
    }

    fn transform(&mut self, depth: u32) -> Result<()> {
        self.add("Transform {");
        for _ in 0..self.bytes.int_in_range(0..=3)? {
            match self.bytes.int_in_range(0..=6)? {
                0 => self.field("Translate", 3)?,
                1 => self.field("Scale", 3)?,
                2 => self.positive("UniformScale")?,
                3 => self.field("XRotate", 1)?,
                4 => self.field("YRotate", 1)?,
                5 => {
                    self.field("Rotate {", 4)?;
                    self.add("}");
                }
                _ => {
                    self.add("Matrix4f {");
                    for column in 0..4 {
                        self.field("", 3)?;
                        self.add(if column == 3 { "1 }" } else { "0" });
                    }
                }
            }
        }
        self.object(depth + 1)?;
        self.add("}\n");
        Ok(())
    }
}
