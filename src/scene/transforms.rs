//! The matrices of a scene's transforms.

use crate::error::{Error, SourceText};
use crate::scene_file::{At, TransformStep};
use std::sync::Arc;
use vecmath::{Matrix4, Real, Vector3};

/// Multiplies the steps of a transform. A step multiplies from the right, so the first one is applied last; a
/// `Matrix4f` multiplies from the left, as in the starter.
pub(super) fn composed(source: &Arc<SourceText>, steps: &[At<TransformStep>]) -> Result<Matrix4, Error> {
    let mut product = Matrix4::IDENTITY;
    for step in steps {
        let matrix = step_matrix(&step.value).map_err(|message| source.error(step.span, message))?;
        if matrix.affine_inverse().is_err() {
            return Err(source.error(step.span, no_inverse("this transformation", &matrix)));
        }
        product = match step.value {
            TransformStep::Matrix4f(_) => matrix * product,
            _ => product * matrix,
        };
    }
    Ok(product)
}

/// Returns the message for a product of transforms without inverse.
pub(super) fn no_inverse_of_product(matrix: &Matrix4) -> String {
    let what = "the product of the transforms around this object";
    let columns = matrix.linear().columns;
    // Each factor has an inverse, so a column of zeros has underflowed.
    let has_left = columns.into_iter().any(|column| column == Vector3::ZERO || !column.is_finite());
    if has_left || !matrix.offset().is_finite() {
        return format!("{what} leaves the range of numbers");
    }
    no_inverse(what, matrix)
}

/// Returns the message for a matrix without inverse.
fn no_inverse(what: &str, matrix: &Matrix4) -> String {
    /// Matrices with a lower condition number have an inverse, if its entries are numbers.
    const REGULAR: Real = 1.0 / (64.0 * Real::EPSILON);
    let condition = matrix.linear().condition_number();
    if condition < REGULAR {
        return format!("the inverse of {what} is beyond the range of numbers");
    }
    format!("{what} squashes space flat: its matrix has no inverse (condition number {condition:.1e})")
}

/// Returns the matrix of one step, or the message for a mistake in it.
fn step_matrix(step: &TransformStep) -> Result<Matrix4, &'static str> {
    match *step {
        TransformStep::Translate(offset) => Ok(Matrix4::translation(offset)),
        TransformStep::Scale(factors) => Ok(Matrix4::scaling(factors)),
        TransformStep::Rotate { axis, degrees } => {
            let axis = axis.try_normalized().ok_or("the axis of this rotation has no length")?;
            Ok(Matrix4::rotation(axis, degrees.to_radians() as Real))
        }
        TransformStep::Matrix4f(numbers) => {
            let matrix = Matrix4::from_column_major(numbers.map(|number| number as Real));
            let last_row = "the last row of this matrix (its numbers 4, 8, 12 and 16) must be 0 0 0 1";
            matrix.is_affine().then_some(matrix).ok_or(last_row)
        }
    }
}
