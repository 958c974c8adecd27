//! Exact rational arithmetic on the program's numbers: every `f64` is a fraction.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive};
use vecmath::Vector3;

pub type Q = BigRational;
pub type V = [Q; 3];

pub fn q(x: f64) -> Q {
    BigRational::from_float(x).unwrap_or_else(|| panic!("{x} is no fraction"))
}

pub fn v(x: Vector3) -> V {
    x.to_array().map(|x| q(f64::from(x)))
}

pub fn dot(a: &V, b: &V) -> Q {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

pub fn sub(a: &V, b: &V) -> V {
    [0, 1, 2].map(|i| &a[i] - &b[i])
}

pub fn cross(a: &V, b: &V) -> V {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| &a[i] * &b[j] - &a[j] * &b[i])
}

/// Returns origin + t direction, without rounding.
pub fn at(origin: &V, direction: &V, t: &Q) -> V {
    [0, 1, 2].map(|i| &origin[i] + &direction[i] * t)
}

/// Returns the square root of x >= 0 to 90 digits.
pub fn sqrt(x: &Q) -> Q {
    let scale = BigInt::from(10).pow(200);
    // Numbers as small as 1e-40 still have 80 digits then.
    let scaled: BigInt = (x * Q::from(scale)).to_integer();
    Q::new(scaled.sqrt(), BigInt::from(10).pow(100))
}

pub fn length(a: &V) -> Q {
    sqrt(&dot(a, a))
}

pub fn f(x: &Q) -> f64 {
    x.to_f64().unwrap()
}

/// Returns |x| as an f64.
pub fn size(x: &Q) -> f64 {
    f(&x.abs())
}
