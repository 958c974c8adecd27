//! Parses the steps of a `Transform`.

use super::description::TransformStep;
use super::fields::Fields;
use super::lexer::Token;
use crate::error::{Error, cut_short};
use vecmath::{Real, Vector3};

const AXES: [Vector3; 3] = [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.0, 0.0, 1.0)];

pub(super) const STEP_NAMES: [&str; 8] =
    ["Translate", "Scale", "UniformScale", "XRotate", "YRotate", "ZRotate", "Rotate", "Matrix4f"];

/// Parses `Translate x y z | Scale x y z | UniformScale s | XRotate degrees | YRotate degrees | ZRotate degrees
/// | Rotate { x y z degrees } | Matrix4f { 16 numbers, column by column }`
///
/// `name` must be one of [`STEP_NAMES`].
pub(super) fn transform_step<'a>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<TransformStep, Error> {
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
            let [x, y, z, degrees] = numbers_in_braces(fields, name)?;
            let axis = Vector3::from([x, y, z].map(|n| n as Real));
            TransformStep::Rotate { axis, degrees }
        }
        _ => TransformStep::Matrix4f(numbers_in_braces(fields, name)?),
    })
}

/// Reads `{ numbers }`. After a mistake in it, it ends before its brace or before the next word.
fn numbers_in_braces<'a, const N: usize>(fields: &mut Fields<'a>, name: Token<'a>) -> Result<[f64; N], Error> {
    fields.open_brace(name)?;
    let numbers = fields.numbers(name.text).and_then(|numbers| {
        let token = fields.next_in_block()?;
        if token.text == "}" {
            return Ok(numbers);
        }
        let message =
            format!("expected '}}' after the {N} numbers of '{}', found '{}'", name.text, cut_short(token.text));
        Err(fields.error(token.span, message))
    });
    fields.close();
    if numbers.is_err() {
        fields.skip_numbers();
    }
    numbers
}
