//! Vectors and matrices of a ray tracer: the part of the course's `vecmath` library that a scene can reach.
//!
//! Vectors are columns in a right-handed system; a matrix multiplies from the left (`matrix * vector`). All numbers
//! are [`Real`]. Quaternions, projections and 2 x 2 matrices are left out, because no scene needs them.
#![forbid(unsafe_code)]

mod matrix3;
mod matrix4;
mod vector;

pub use matrix3::Matrix3;
pub use matrix4::{Matrix4, SingularMatrix};
pub use vector::{Vector2, Vector3, Vector4};

/// The scalar of the whole program: `f64`, or `f32` with the cargo feature of that name (for comparison only).
#[cfg(not(feature = "f32"))]
pub type Real = f64;
/// The scalar of the whole program: `f64`, or `f32` with the cargo feature of that name (for comparison only).
#[cfg(feature = "f32")]
pub type Real = f32;

/// The unit roundoff u: the largest relative error of one rounding (Higham, Accuracy and Stability of Numerical
/// Algorithms, 2002, section 2.1).
pub const UNIT_ROUNDOFF: Real = Real::EPSILON / 2.0;

/// Returns the greater of two numbers, or `a` if one of them is NaN. Unlike `Real::max`, it is one instruction.
#[inline(always)]
pub fn greater(a: Real, b: Real) -> Real {
    if b > a { b } else { a }
}

/// Returns the lesser of two numbers, or `a` if one of them is NaN. Unlike `Real::min`, it is one instruction.
#[inline(always)]
pub fn lesser(a: Real, b: Real) -> Real {
    if b < a { b } else { a }
}

/// Returns (b, a) if `swap`, otherwise (a, b). It has no branch: use it where a branch could not be predicted.
#[inline(always)]
pub fn swapped_if(swap: bool, a: Real, b: Real) -> (Real, Real) {
    let (x, y) = (a.to_bits(), b.to_bits());
    let difference = if swap { x ^ y } else { 0 };
    (Real::from_bits(x ^ difference), Real::from_bits(y ^ difference))
}
