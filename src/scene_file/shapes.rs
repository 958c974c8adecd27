//! Parses shapes. Each shape has a function, whose documentation shows the syntax.
//!
//! To add a shape, write its function and add it to [`SHAPES`].

use super::description::{At, LeafShape};
use super::fields::{Fields, Key, Occurs};
use super::lexer::Token;
use crate::error::Error;
use crate::objects::{Plane, Shape, Sphere, Triangle};
use vecmath::{Real, Vector3};

pub(super) type ParseShape = for<'a> fn(&mut Fields<'a>, Token<'a>) -> Result<LeafShape, Error>;

/// The name of each shape, and the function that parses its block.
const SHAPES: [(&str, ParseShape); 4] =
    [("Sphere", sphere), ("Plane", plane), ("Triangle", triangle), ("TriangleMesh", triangle_mesh)];

/// Returns the names of all shapes.
pub(super) fn shape_names() -> impl Iterator<Item = &'static str> + Clone {
    SHAPES.into_iter().map(|shape| shape.0)
}

/// Returns the function that parses the block of the shape `name`; `None` if there is no such shape.
pub(super) fn shape_parser(name: &str) -> Option<ParseShape> {
    SHAPES.into_iter().find(|shape| shape.0 == name).map(|shape| shape.1)
}

/// Parses `Sphere { center x y z  radius r }`.
fn sphere<'a>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<LeafShape, Error> {
    const KEYS: &[Key] = &[("center", Occurs::Once), ("radius", Occurs::Once)];
    let mut center = Vector3::ZERO;
    let mut radius = At { value: 1.0, span: name.span };
    fields.block(name, KEYS, |fields, key, span| {
        match key {
            "center" => center = fields.vector3(key)?,
            _ => radius = At { value: fields.number(key)?, span },
        }
        Ok(())
    })?;
    if radius.value <= 0.0 {
        return Err(fields.error(radius.span, "'radius' must be above 0"));
    }
    Ok(LeafShape::Shape(Shape::Sphere(Sphere { center, radius: radius.value as Real })))
}

/// Parses `Plane { normal x y z  offset d }`.
fn plane<'a>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<LeafShape, Error> {
    const KEYS: &[Key] = &[("normal", Occurs::Once), ("offset", Occurs::Once)];
    let mut normal = At { value: Vector3::new(0.0, 1.0, 0.0), span: name.span };
    let mut offset = 0.0;
    fields.block(name, KEYS, |fields, key, span| {
        match key {
            "normal" => normal = At { value: fields.vector3(key)?, span },
            _ => offset = fields.number(key)?,
        }
        Ok(())
    })?;
    if normal.value == Vector3::ZERO {
        return Err(fields.error(normal.span, "'normal' has no length"));
    }
    Ok(LeafShape::Shape(Shape::Plane(Plane::new(normal.value, offset as Real))))
}

/// Parses `Triangle { vertex0 x y z  vertex1 x y z  vertex2 x y z }`.
fn triangle<'a>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<LeafShape, Error> {
    const KEYS: &[Key] = &[("vertex0", Occurs::Once), ("vertex1", Occurs::Once), ("vertex2", Occurs::Once)];
    let mut corners = [Vector3::ZERO; 3];
    fields.block(name, KEYS, |fields, key, _| {
        let index = match key {
            "vertex0" => 0,
            "vertex1" => 1,
            _ => 2,
        };
        corners[index] = fields.vector3(key)?;
        Ok(())
    })?;
    Ok(LeafShape::Shape(Shape::Triangle(Triangle::new(corners))))
}

/// Parses `TriangleMesh { obj_file path.obj }`.
fn triangle_mesh<'a>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<LeafShape, Error> {
    const KEYS: &[Key] = &[("obj_file", Occurs::Once)];
    let mut obj_file = At { value: String::new(), span: name.span };
    let is_clear = fields.block(name, KEYS, |fields, key, _| {
        obj_file = fields.path(key, "a file")?;
        Ok(())
    })?;
    if !is_clear {
        // It may be a part of the name only.
        obj_file.value.clear();
    }
    Ok(LeafShape::Mesh(obj_file))
}
