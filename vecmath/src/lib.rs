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

/// Returns the exponent e of a number, with 2^(e - 1) <= |x| < 2^e. It is 0 for zero and for what is not finite.
pub fn exponent(x: Real) -> i32 {
    libm::frexp(x as f64).1
}

/// Returns x 2^exponent, without rounding where the result is in the normal range.
pub fn scaled(x: Real, exponent: i32) -> Real {
    libm::scalbn(x as f64, exponent) as Real
}

/// Returns whether a number other than zero is so large or small that its fourth power may leave the range of numbers.
pub fn is_unusual(x: Real) -> bool {
    /// Less than a quarter of the largest exponent, so that sums of a few fourth powers fit too.
    const LARGEST_USUAL: i32 = Real::MAX_EXP / 4 - 6;
    exponent(x).abs() > LARGEST_USUAL
}

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

/// Does the same by a choice, which is one instruction in a vectorised loop: there is no branch to avoid by hand.
#[inline(always)]
pub fn chosen_if(swap: bool, a: Real, b: Real) -> (Real, Real) {
    if swap { (b, a) } else { (a, b) }
}
