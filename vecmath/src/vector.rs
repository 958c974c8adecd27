//! [`Vector2`], [`Vector3`] and [`Vector4`]: named components and their arithmetic.

use crate::{Real, exponent, greater, scaled};
use std::ops::{Add, AddAssign, Div, Index, Mul, MulAssign, Neg, Sub};

/// Implements the arithmetic that is the same, component by component, for every length.
macro_rules! componentwise {
    ($Vector:ident, $n:literal, $($c:ident = $i:literal),+) => {
        impl $Vector {
            /// All components zero.
            pub const ZERO: Self = Self { $($c: 0.0),+ };

            /// Makes a vector of these components.
            #[inline]
            pub const fn new($($c: Real),+) -> Self {
                Self { $($c),+ }
            }

            /// Makes a vector with every component equal to `value`.
            #[inline]
            pub const fn splat(value: Real) -> Self {
                Self { $($c: value),+ }
            }

            /// Returns the components in order.
            #[inline]
            pub const fn to_array(self) -> [Real; $n] {
                [$(self.$c),+]
            }

            /// Returns the scalar product.
            #[inline]
            pub fn dot(self, other: Self) -> Real {
                0.0 $(+ self.$c * other.$c)+
            }

            /// Returns the squared Euclidean length.
            #[inline]
            pub fn length_squared(self) -> Real {
                // Beside the scalar product this lacks a sum with 0, which would change the sign of -0; squares have none.
                -0.0 $(+ self.$c * self.$c)+
            }

            /// Returns the Euclidean length.
            #[inline]
            pub fn length(self) -> Real {
                self.length_squared().sqrt()
            }

            /// Returns the largest absolute component; ignores NaN.
            #[inline]
            pub fn max_abs(self) -> Real {
                let mut largest = 0.0;
                $(largest = greater(largest, self.$c.abs());)+
                largest
            }

            /// Returns whether no component is infinite or NaN.
            #[inline]
            pub fn is_finite(self) -> bool {
                true $(& self.$c.is_finite())+
            }

            /// Returns the component-wise product (of two colours, say).
            #[inline]
            pub fn scaled_by(self, other: Self) -> Self {
                Self { $($c: self.$c * other.$c),+ }
            }

            /// Returns the component-wise minimum.
            #[inline]
            pub fn min(self, other: Self) -> Self {
                Self { $($c: self.$c.min(other.$c)),+ }
            }

            /// Returns the component-wise maximum.
            #[inline]
            pub fn max(self, other: Self) -> Self {
                Self { $($c: self.$c.max(other.$c)),+ }
            }

            /// Returns the component-wise maximum; of NaN and another number, what `self` has. Fewer instructions than `max`.
            #[inline]
            pub fn greater(self, other: Self) -> Self {
                Self { $($c: greater(self.$c, other.$c)),+ }
            }

            /// Applies `f` to every component.
            #[inline]
            pub fn map(self, f: impl Fn(Real) -> Real) -> Self {
                Self { $($c: f(self.$c)),+ }
            }
        }

        impl From<[Real; $n]> for $Vector {
            #[inline]
            fn from(array: [Real; $n]) -> Self {
                Self { $($c: array[$i]),+ }
            }
        }

        impl Index<usize> for $Vector {
            type Output = Real;

            #[inline(always)]
            fn index(&self, axis: usize) -> &Real {
                match axis {
                    $($i => &self.$c,)+
                    _ => panic!("axis {axis} of a vector of {}", $n),
                }
            }
        }

        impl Add for $Vector {
            type Output = Self;
            #[inline]
            fn add(self, other: Self) -> Self {
                Self { $($c: self.$c + other.$c),+ }
            }
        }

        impl AddAssign for $Vector {
            #[inline]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }

        impl Sub for $Vector {
            type Output = Self;
            #[inline]
            fn sub(self, other: Self) -> Self {
                Self { $($c: self.$c - other.$c),+ }
            }
        }

        impl Neg for $Vector {
            type Output = Self;
            #[inline]
            fn neg(self) -> Self {
                Self { $($c: -self.$c),+ }
            }
        }

        impl Mul<Real> for $Vector {
            type Output = Self;
            #[inline]
            fn mul(self, factor: Real) -> Self {
                Self { $($c: self.$c * factor),+ }
            }
        }

        impl Mul<$Vector> for Real {
            type Output = $Vector;
            #[inline]
            fn mul(self, vector: $Vector) -> $Vector {
                vector * self
            }
        }

        impl MulAssign<Real> for $Vector {
            #[inline]
            fn mul_assign(&mut self, factor: Real) {
                *self = *self * factor;
            }
        }

        impl Div<Real> for $Vector {
            type Output = Self;
            #[inline]
            fn div(self, divisor: Real) -> Self {
                Self { $($c: self.$c / divisor),+ }
            }
        }
    };
}

/// Two numbers: a point of the picture plane, an offset within a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vector2 {
    pub x: Real,
    pub y: Real,
}

/// Three numbers: a point, a direction, a normal, or a colour (red, green, blue).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vector3 {
    pub x: Real,
    pub y: Real,
    pub z: Real,
}

/// Four numbers: a column of a [`Matrix4`](crate::Matrix4).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vector4 {
    pub x: Real,
    pub y: Real,
    pub z: Real,
    pub w: Real,
}

componentwise!(Vector2, 2, x = 0, y = 1);
componentwise!(Vector3, 3, x = 0, y = 1, z = 2);
componentwise!(Vector4, 4, x = 0, y = 1, z = 2, w = 3);

impl Vector3 {
    /// Returns the vector product, by the right-hand rule.
    #[inline]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// Returns the unit vector of the same direction, or `None` where there is none: zero, infinite or NaN.
    ///
    /// It is divided by its largest component first, so that squares neither overflow nor underflow.
    pub fn try_normalized(self) -> Option<Self> {
        let largest = self.max_abs();
        if !(largest > 0.0 && self.is_finite()) {
            return None;
        }
        let scaled = self / largest;
        Some(scaled / scaled.length())
    }

    /// Returns the unit vector of the same direction; zero stays zero. A vector that is scaled by a power of two has the
    /// same one, to the last bit.
    #[inline]
    pub fn normalized(self) -> Self {
        match self.is_usual() {
            true => self / self.length(),
            false => self.direction_and_length().0,
        }
    }

    /// Returns the unit vector of the same direction and the length, also where squares of components leave the range of
    /// numbers. Zero, and what is not finite, has no direction: then both are zero.
    pub fn direction_and_length(self) -> (Self, Real) {
        if self.is_usual() {
            let length = self.length();
            return (self / length, length);
        }
        if !self.is_finite() || self == Self::ZERO {
            return (Self::ZERO, 0.0);
        }
        let exponent = exponent(self.max_abs());
        let vector = self.scaled(-exponent);
        let length = vector.length();
        (vector / length, scaled(length, exponent))
    }

    /// Returns the vector times 2^exponent, without rounding where the result is in the normal range.
    #[must_use]
    pub fn scaled(self, exponent: i32) -> Self {
        self.map(|component| scaled(component, exponent))
    }

    /// Returns whether the squared length stays in the normal range, so that the vector can be normalised without
    /// being scaled first.
    #[inline(always)]
    pub fn is_usual(self) -> bool {
        let length_squared = self.length_squared();
        (length_squared > Real::MIN_POSITIVE * 1e8) & (length_squared < Real::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: Vector3 = Vector3::new(1.0, 0.0, 0.0);
    const Y: Vector3 = Vector3::new(0.0, 1.0, 0.0);

    #[test]
    fn cross_is_right_handed() {
        assert_eq!(X.cross(Y), Vector3::new(0.0, 0.0, 1.0));
        assert_eq!(Y.cross(X), Vector3::new(0.0, 0.0, -1.0));
    }

    #[test]
    fn arithmetic_is_componentwise() {
        let a = Vector3::new(1.0, 2.0, 3.0);
        let b = Vector3::new(4.0, -5.0, 6.0);
        assert_eq!(a + b, Vector3::new(5.0, -3.0, 9.0));
        assert_eq!(a - b, Vector3::new(-3.0, 7.0, -3.0));
        assert_eq!(a.scaled_by(b), Vector3::new(4.0, -10.0, 18.0));
        assert_eq!(2.0 * a, a + a);
        assert_eq!(a.dot(b), 12.0);
        assert_eq!(b.max_abs(), 6.0);
        assert_eq!((a[0], a[1], a[2]), (1.0, 2.0, 3.0));
        assert_eq!(Vector2::new(3.0, 4.0).length(), 5.0);
        assert_eq!(Vector4::splat(1.0).length(), 2.0);
    }

    #[test]
    fn normalizing_survives_every_magnitude() {
        let tiny = Real::MIN_POSITIVE;
        let huge = Real::MAX / 2.0;
        for scale in [tiny, 1e-30, 1.0, 1e30, huge] {
            let unit = Vector3::new(scale, -scale, scale).normalized();
            assert!((unit.length() - 1.0).abs() < 4.0 * Real::EPSILON, "{scale}");
        }
    }

    #[test]
    fn a_power_of_two_changes_no_bit_of_a_unit_vector() {
        let vector = Vector3::new(0.3, -0.7, 0.2);
        let (unit, length) = (vector.normalized(), vector.length());
        let far = Real::MAX_EXP - 8;
        for exponent in [-far, -far / 2, 0, far / 2, far] {
            let (direction, scaled_length) = vector.scaled(exponent).direction_and_length();
            assert_eq!((direction, scaled_length), (unit, scaled(length, exponent)), "2^{exponent}");
            assert_eq!(vector.scaled(exponent).normalized(), unit, "2^{exponent}");
        }
    }

    #[test]
    fn vectors_without_direction_are_not_normalized() {
        assert_eq!(Vector3::ZERO.normalized(), Vector3::ZERO);
        assert_eq!(Vector3::ZERO.try_normalized(), None);
        assert_eq!(Vector3::new(Real::NAN, 1.0, 0.0).try_normalized(), None);
        assert_eq!(Vector3::new(Real::INFINITY, 1.0, 0.0).try_normalized(), None);
    }
}
