//! Parses camera, background and materials. Each block has a function, whose documentation shows the syntax.

use super::description::{At, BackgroundBlock, CameraBlock};
use super::fields::{Count, Fields, Key, Occurs};
use super::lexer::Token;
use super::words::MATERIAL_NAMES;
use crate::error::Error;
use crate::material::Material;
use vecmath::{Real, Vector3};

/// Parses `PerspectiveCamera { center x y z  direction x y z  up x y z  angle degrees }`.
pub(super) fn camera<'a>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<CameraBlock, Error> {
    const KEYS: &[Key] =
        &[("center", Occurs::Once), ("direction", Occurs::Once), ("up", Occurs::Once), ("angle", Occurs::Once)];
    let at = |value, span| At { value, span };
    let mut camera = CameraBlock::default();
    let is_clear = fields.block(name, KEYS, |fields, key, span| {
        match key {
            "center" => camera.center = at(fields.vector3(key)?, span),
            "direction" => camera.direction = at(fields.vector3(key)?, span),
            "up" => camera.up = at(fields.vector3(key)?, span),
            _ => camera.angle_degrees = At { value: fields.number(key)?, span },
        }
        Ok(())
    })?;
    Ok(if is_clear { camera } else { CameraBlock::default() })
}

/// Parses `Background { color r g b  ambientLight r g b  cubeMap folder }`, all optional.
pub(super) fn background<'a>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<BackgroundBlock, Error> {
    const KEYS: &[Key] =
        &[("color", Occurs::AtMostOnce), ("ambientLight", Occurs::AtMostOnce), ("cubeMap", Occurs::AtMostOnce)];
    let mut background = BackgroundBlock::default();
    let is_clear = fields.block(name, KEYS, |fields, key, _| {
        match key {
            "color" => background.color = fields.vector3(key)?,
            "ambientLight" => background.ambient_light = fields.vector3(key)?,
            _ => background.cube_map = Some(fields.path(key, "a folder")?),
        }
        Ok(())
    })?;
    if !is_clear {
        // It may be a part of the name only.
        background.cube_map = None;
    }
    Ok(background)
}

/// Parses `Materials { numMaterials n  (Material { } | PhongMaterial { }) ... }`.
pub(super) fn materials<'a>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<Vec<At<Material>>, Error> {
    const KEYS: &[Key] = &[
        ("numMaterials", Occurs::Once),
        (MATERIAL_NAMES[0], Occurs::AnyNumber),
        (MATERIAL_NAMES[1], Occurs::AnyNumber),
    ];
    let mut count = Count::new(fields);
    let mut materials = Vec::new();
    fields.block(name, KEYS, |fields, key, span| {
        match key {
            "numMaterials" => count.read(fields, key, span)?,
            _ => materials.push(At { value: material(fields, Token { text: key, span })?, span }),
        }
        Ok(())
    })?;
    count.check(fields, "numMaterials", materials.len(), "material")?;
    Ok(materials)
}

/// Parses `Material { diffuseColor r g b  specularColor r g b  shininess s  bump file }`, all optional.
fn material<'a>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<Material, Error> {
    const KEYS: &[Key] = &[
        ("diffuseColor", Occurs::AtMostOnce),
        ("specularColor", Occurs::AtMostOnce),
        ("shininess", Occurs::AtMostOnce),
        ("bump", Occurs::AtMostOnce),
    ];
    let mut material = Material { diffuse: Vector3::splat(1.0), specular: Vector3::ZERO, shininess: 0.0 };
    fields.block(name, KEYS, |fields, key, span| {
        match key {
            "diffuseColor" => material.diffuse = fields.vector3(key)?,
            "specularColor" => material.specular = fields.vector3(key)?,
            "shininess" => {
                let shininess = fields.number(key)?;
                if shininess < 0.0 {
                    let message = "'shininess' must be 0 or above: a highlight would be infinite";
                    return Err(fields.error(span, message));
                }
                material.shininess = shininess as Real;
            }
            // The starter reads the name of a bump map and ignores it.
            _ => drop(fields.path(key, "a file")?),
        }
        Ok(())
    })?;
    Ok(material)
}
