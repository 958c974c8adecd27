//! The blocks that hold no objects, and the objects that hold no others. One function per block; its documentation
//! shows the block's syntax.

use super::description::{At, BackgroundBlock, CameraBlock, LightBlock, MaterialBlock, ShapeBlock, TransformStep};
use super::fields::{Fields, Key, Occurs};
use super::lexer::Token;
use crate::error::{Error, Span};
use vecmath::{Real, Vector3};

const AXES: [Vector3; 3] = [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.0, 0.0, 1.0)];

/// `PerspectiveCamera { center x y z  direction x y z  up x y z  angle degrees }`
pub(super) fn camera<'a>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<CameraBlock, Error> {
    const KEYS: &[Key] =
        &[("center", Occurs::Once), ("direction", Occurs::Once), ("up", Occurs::Once), ("angle", Occurs::Once)];
    let at = |value, span| At { value, span };
    let mut camera = CameraBlock {
        center: at(Vector3::ZERO, name.span),
        direction: at(Vector3::ZERO, name.span),
        up: at(Vector3::ZERO, name.span),
        angle_degrees: At { value: 0.0, span: name.span },
    };
    fields.block(name, KEYS, |fields, key, span| {
        match key {
            "center" => camera.center = at(fields.vector3(key)?, span),
            "direction" => camera.direction = at(fields.vector3(key)?, span),
            "up" => camera.up = at(fields.vector3(key)?, span),
            _ => camera.angle_degrees = At { value: fields.number(key)?, span },
        }
        Ok(())
    })?;
    Ok(camera)
}

/// `Lights { numLights n  (DirectionalLight { } | PointLight { }) ... }`
pub(super) fn lights<'a>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<Vec<LightBlock>, Error> {
    const KEYS: &[Key] =
        &[("numLights", Occurs::Once), ("DirectionalLight", Occurs::AnyNumber), ("PointLight", Occurs::AnyNumber)];
    let mut count = Count::default();
    let mut lights = Vec::new();
    fields.block(name, KEYS, |fields, key, span| {
        match key {
            "numLights" => count.read(fields, key, span)?,
            "DirectionalLight" => lights.push(directional_light(fields, Token { text: key, span })?),
            _ => lights.push(point_light(fields, Token { text: key, span })?),
        }
        Ok(())
    })?;
    count.check(fields, "numLights", lights.len(), "light")?;
    Ok(lights)
}

/// `Background { color r g b  ambientLight r g b  cubeMap folder }`, all optional
pub(super) fn background<'a>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<BackgroundBlock, Error> {
    const KEYS: &[Key] =
        &[("color", Occurs::AtMostOnce), ("ambientLight", Occurs::AtMostOnce), ("cubeMap", Occurs::AtMostOnce)];
    let mut background = BackgroundBlock::default();
    fields.block(name, KEYS, |fields, key, _| {
        match key {
            "color" => background.color = fields.vector3(key)?,
            "ambientLight" => background.ambient_light = fields.vector3(key)?,
            _ => background.cube_map = Some(path_value(fields, key, "a folder")?),
        }
        Ok(())
    })?;
    Ok(background)
}

/// `Materials { numMaterials n  (Material { } | PhongMaterial { }) ... }`
pub(super) fn materials<'a>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<Vec<MaterialBlock>, Error> {
    const KEYS: &[Key] =
        &[("numMaterials", Occurs::Once), ("Material", Occurs::AnyNumber), ("PhongMaterial", Occurs::AnyNumber)];
    let mut count = Count::default();
    let mut materials = Vec::new();
    fields.block(name, KEYS, |fields, key, span| {
        match key {
            "numMaterials" => count.read(fields, key, span)?,
            _ => materials.push(material(fields, Token { text: key, span })?),
        }
        Ok(())
    })?;
    count.check(fields, "numMaterials", materials.len(), "material")?;
    Ok(materials)
}

/// What `numLights` and its like say, against what is there.
#[derive(Default)]
pub(super) struct Count {
    said: u32,
    span: Span,
}

impl Count {
    pub fn read(&mut self, fields: &mut Fields, key: &str, span: Span) -> Result<(), Error> {
        self.said = fields.count(key)?;
        self.span = span;
        Ok(())
    }

    pub fn check(&self, fields: &Fields, key: &str, found: usize, item: &str) -> Result<(), Error> {
        if self.said as usize == found {
            return Ok(());
        }
        let plural = if found == 1 { "" } else { "s" };
        let message = format!("'{key}' says {}, but {found} {item}{plural} stand here", self.said);
        Err(fields.error(self.span, message.replace("1 object stand ", "1 object stands ")))
    }
}

/// `DirectionalLight { direction x y z  color r g b }`
fn directional_light(fields: &mut Fields, name: Token) -> Result<LightBlock, Error> {
    const KEYS: &[Key] = &[("direction", Occurs::Once), ("color", Occurs::Once)];
    let mut direction = At { value: Vector3::ZERO, span: name.span };
    let mut color = Vector3::ZERO;
    let name = Token { text: "DirectionalLight", ..name };
    fields.block(name, KEYS, |fields, key, span| {
        match key {
            "direction" => direction = At { value: fields.vector3(key)?, span },
            _ => color = fields.vector3(key)?,
        }
        Ok(())
    })?;
    Ok(LightBlock::Directional { direction, color })
}

/// `PointLight { position x y z  color r g b  falloff a }`, falloff optional
fn point_light(fields: &mut Fields, name: Token) -> Result<LightBlock, Error> {
    const KEYS: &[Key] = &[("position", Occurs::Once), ("color", Occurs::Once), ("falloff", Occurs::AtMostOnce)];
    let (mut position, mut color, mut falloff) = (Vector3::ZERO, Vector3::ZERO, 0.0);
    let span = name.span;
    let name = Token { text: "PointLight", span };
    fields.block(name, KEYS, |fields, key, _| {
        match key {
            "position" => position = fields.vector3(key)?,
            "color" => color = fields.vector3(key)?,
            _ => falloff = fields.number(key)?,
        }
        Ok(())
    })?;
    Ok(LightBlock::Point { position, color, falloff, span })
}

/// `Material { diffuseColor r g b  specularColor r g b  shininess s  bump file }`, all optional
fn material(fields: &mut Fields, name: Token) -> Result<MaterialBlock, Error> {
    const KEYS: &[Key] = &[
        ("diffuseColor", Occurs::AtMostOnce),
        ("specularColor", Occurs::AtMostOnce),
        ("shininess", Occurs::AtMostOnce),
        ("bump", Occurs::AtMostOnce),
    ];
    let mut material = MaterialBlock { diffuse: Vector3::splat(1.0), specular: Vector3::ZERO, shininess: 0.0 };
    let text = if name.text == "Material" { "Material" } else { "PhongMaterial" };
    fields.block(Token { text, ..name }, KEYS, |fields, key, span| {
        match key {
            "diffuseColor" => material.diffuse = fields.vector3(key)?,
            "specularColor" => material.specular = fields.vector3(key)?,
            "shininess" => {
                material.shininess = fields.number(key)?;
                if material.shininess < 0.0 {
                    return Err(
                        fields.error(span, "'shininess' must be 0 or above: a highlight would be infinite")
                    );
                }
            }
            // The starter reads bump maps and does nothing with them.
            _ => drop(path_value(fields, key, "a file")?),
        }
        Ok(())
    })?;
    Ok(material)
}

/// An object that holds no other:
/// `Sphere { center x y z  radius r }`, `Plane { normal x y z  offset d }`,
/// `Triangle { vertex0 x y z  vertex1 x y z  vertex2 x y z }`, `TriangleMesh { obj_file path.obj }`
pub(super) fn shape<'a>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<ShapeBlock, Error> {
    let keys: &[Key] = match name.text {
        "Sphere" => &[("center", Occurs::Once), ("radius", Occurs::Once)],
        "Plane" => &[("normal", Occurs::Once), ("offset", Occurs::Once)],
        "Triangle" => &[("vertex0", Occurs::Once), ("vertex1", Occurs::Once), ("vertex2", Occurs::Once)],
        _ => &[("obj_file", Occurs::Once)],
    };
    let mut vectors = [Vector3::ZERO; 3];
    let mut vector_span = name.span;
    let mut number = At { value: 0.0, span: name.span };
    let mut file = None;
    fields.block(name, keys, |fields, key, span| {
        match key {
            "radius" | "offset" => number = At { value: fields.number(key)?, span },
            "obj_file" => file = Some(path_value(fields, key, "a file")?),
            _ => {
                let index = match key {
                    "vertex1" => 1,
                    "vertex2" => 2,
                    _ => 0,
                };
                vectors[index] = fields.vector3(key)?;
                vector_span = span;
            }
        }
        Ok(())
    })?;
    Ok(match (name.text, file) {
        ("Sphere", _) => ShapeBlock::Sphere { center: vectors[0], radius: number },
        ("Plane", _) => {
            ShapeBlock::Plane { normal: At { value: vectors[0], span: vector_span }, offset: number.value }
        }
        (_, Some(obj_file)) => ShapeBlock::TriangleMesh { obj_file },
        _ => ShapeBlock::Triangle { vertices: vectors },
    })
}

/// `Translate x y z | Scale x y z | UniformScale s | XRotate degrees | YRotate degrees | ZRotate degrees
/// | Rotate { x y z degrees } | Matrix4f { 16 numbers, column by column }`
pub(super) fn transform_step(fields: &mut Fields, name: Token) -> Result<TransformStep, Error> {
    let about = |axis: usize, degrees| TransformStep::Rotate { axis: AXES[axis], degrees };
    let key = name.text;
    Ok(match key {
        "Translate" => TransformStep::Translate(fields.vector3(key)?),
        "Scale" => TransformStep::Scale(fields.vector3(key)?),
        "UniformScale" => TransformStep::Scale(Vector3::splat(fields.number(key)? as Real)),
        "XRotate" => about(0, fields.number(key)?),
        "YRotate" => about(1, fields.number(key)?),
        "ZRotate" => about(2, fields.number(key)?),
        "Rotate" => {
            let axis_and_degrees = numbers_in_braces::<4>(fields, key)?;
            let [x, y, z, degrees] = axis_and_degrees;
            let axis = Vector3::from([x, y, z].map(|n| n as Real));
            TransformStep::Rotate { axis, degrees }
        }
        _ => TransformStep::Matrix4f(numbers_in_braces(fields, key)?),
    })
}

fn numbers_in_braces<const N: usize>(fields: &mut Fields, key: &str) -> Result<[f64; N], Error> {
    fields.open_brace(key)?;
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = fields.number(key)?;
    }
    let token = fields.next(|_| format!("'}}' to end '{key}'"))?;
    if token.text == "}" {
        return Ok(numbers);
    }
    let message = format!("expected '}}' after the {N} numbers of '{key}', found '{}'", token.text);
    Err(fields.error(token.span, message))
}

fn path_value(fields: &mut Fields, key: &str, expected: &str) -> Result<At<String>, Error> {
    let token = fields.word(key, expected)?;
    Ok(At { value: token.text.to_owned(), span: token.span })
}
