//! Parses lights. Each kind has a function, whose documentation shows the syntax.
//!
//! To add a kind of light, write its function and add it to [`LIGHTS`].

use super::description::At;
use super::fields::{Count, Fields, Key, Occurs};
use super::lexer::Token;
use crate::error::Error;
use crate::light::Light;
use vecmath::{Real, Vector3};

type ParseLight = for<'a> fn(&mut Fields<'a>, Token<'a>) -> Result<Light, Error>;

/// The name of each kind of light, and the function that parses its block.
const LIGHTS: [(&str, ParseLight); 2] = [("DirectionalLight", directional_light), ("PointLight", point_light)];

/// Returns the names of all kinds of lights.
pub(super) fn light_names() -> impl Iterator<Item = &'static str> {
    LIGHTS.into_iter().map(|light| light.0)
}

/// Parses `Lights { numLights n  (DirectionalLight { } | PointLight { }) ... }`.
pub(super) fn lights<'a>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<Vec<At<Light>>, Error> {
    let mut keys: Vec<Key> = vec![("numLights", Occurs::Once)];
    keys.extend(LIGHTS.map(|light| (light.0, Occurs::AnyNumber)));
    let mut count = Count::new(fields);
    let mut lights = Vec::new();
    fields.block(name, &keys, |fields, key, span| {
        match LIGHTS.into_iter().find(|light| light.0 == key) {
            Some((_, parse)) => lights.push(At { value: parse(fields, Token { text: key, span })?, span }),
            None => count.read(fields, key, span)?,
        }
        Ok(())
    })?;
    count.check(fields, "numLights", lights.len(), "light")?;
    Ok(lights)
}

/// Parses `DirectionalLight { direction x y z  color r g b }`.
fn directional_light<'a>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<Light, Error> {
    const KEYS: &[Key] = &[("direction", Occurs::Once), ("color", Occurs::Once)];
    let mut direction = At { value: Vector3::new(0.0, 0.0, -1.0), span: name.span };
    let mut color = Vector3::ZERO;
    fields.block(name, KEYS, |fields, key, span| {
        match key {
            "direction" => direction = At { value: fields.vector3(key)?, span },
            _ => color = fields.vector3(key)?,
        }
        Ok(())
    })?;
    match direction.value.try_normalized() {
        Some(unit) => Ok(Light::Directional { to_light: -unit, color }),
        None => Err(fields.error(direction.span, "'direction' has no length")),
    }
}

/// Parses `PointLight { position x y z  color r g b  falloff a }`, falloff optional.
fn point_light<'a>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<Light, Error> {
    const KEYS: &[Key] = &[("position", Occurs::Once), ("color", Occurs::Once), ("falloff", Occurs::AtMostOnce)];
    let (mut position, mut color, mut falloff) = (Vector3::ZERO, Vector3::ZERO, 0.0);
    fields.block(name, KEYS, |fields, key, _| {
        match key {
            "position" => position = fields.vector3(key)?,
            "color" => color = fields.vector3(key)?,
            _ => falloff = fields.number(key)? as Real,
        }
        Ok(())
    })?;
    Ok(Light::Point { position, color, falloff })
}
