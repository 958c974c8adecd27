//! [`Matrix4`]: affine transformations (last row 0 0 0 1) and their inverse.

use crate::{Matrix3, Real, Vector3, Vector4};
use std::ops::Mul;

/// Four columns of four numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrix4 {
    pub columns: [Vector4; 4],
}

/// The matrix has no inverse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingularMatrix;

impl Matrix4 {
    /// Changes nothing.
    pub const IDENTITY: Self = Self::affine(Matrix3::IDENTITY, Vector3::ZERO);

    /// Returns the map p -> `linear` p + `offset`.
    pub const fn affine(linear: Matrix3, offset: Vector3) -> Self {
        const fn column(v: Vector3, w: Real) -> Vector4 {
            Vector4::new(v.x, v.y, v.z, w)
        }
        let [x, y, z] = linear.columns;
        Self { columns: [column(x, 0.0), column(y, 0.0), column(z, 0.0), column(offset, 1.0)] }
    }

    /// Makes a matrix of 16 numbers, column by column.
    pub fn from_column_major(numbers: [Real; 16]) -> Self {
        let column = |i: usize| {
            let n = &numbers[4 * i..4 * i + 4];
            Vector4::new(n[0], n[1], n[2], n[3])
        };
        Self { columns: [column(0), column(1), column(2), column(3)] }
    }

    /// Makes a translation by `offset`.
    pub fn translation(offset: Vector3) -> Self {
        Self::affine(Self::IDENTITY.linear(), offset)
    }

    /// Makes a scaling along the axes.
    pub fn scaling(factors: Vector3) -> Self {
        Self::affine(
            Matrix3::from_columns(
                Vector3::new(factors.x, 0.0, 0.0),
                Vector3::new(0.0, factors.y, 0.0),
                Vector3::new(0.0, 0.0, factors.z),
            ),
            Vector3::ZERO,
        )
    }

    /// Makes a rotation about `axis` (a unit vector) by `angle_radians`, counter-clockwise seen from the axis' tip
    /// (Rodrigues' formula).
    pub fn rotation(axis: Vector3, angle_radians: Real) -> Self {
        // libm gives the same bits on every machine; the system's sine and cosine may not.
        let sin = libm::sin(angle_radians as f64) as Real;
        let cos = libm::cos(angle_radians as f64) as Real;
        let one_minus_cos = 1.0 - cos;
        let turned = |unit: Vector3| unit * cos + axis.cross(unit) * sin + axis * (axis.dot(unit) * one_minus_cos);
        let [x, y, z] = Self::IDENTITY.linear().columns;
        Self::affine(Matrix3::from_columns(turned(x), turned(y), turned(z)), Vector3::ZERO)
    }

    /// Returns the upper left 3 x 3 block, which transforms directions.
    #[inline]
    pub fn linear(&self) -> Matrix3 {
        let [x, y, z, _] = self.columns.map(|c| Vector3::new(c.x, c.y, c.z));
        Matrix3::from_columns(x, y, z)
    }

    /// Returns the last column: the image of the origin.
    #[inline]
    pub fn offset(&self) -> Vector3 {
        let c = self.columns[3];
        Vector3::new(c.x, c.y, c.z)
    }

    /// Returns whether the last row is 0 0 0 1.
    pub fn is_affine(&self) -> bool {
        self.columns.map(|c| c.w) == [0.0, 0.0, 0.0, 1.0]
    }

    /// Returns the image of a point, for an affine matrix.
    #[inline]
    pub fn transform_point(&self, point: Vector3) -> Vector3 {
        self.linear() * point + self.offset()
    }

    /// Returns the image of a direction, for an affine matrix.
    #[inline]
    pub fn transform_direction(&self, direction: Vector3) -> Vector3 {
        self.linear() * direction
    }

    /// Returns the inverse of an affine matrix.
    ///
    /// # Errors
    /// [`SingularMatrix`] if the linear part has no inverse, or an entry of the inverse is not finite.
    pub fn affine_inverse(&self) -> Result<Self, SingularMatrix> {
        let linear = self.linear().inverse().ok_or(SingularMatrix)?;
        let offset = -(linear * self.offset());
        if offset.is_finite() { Ok(Self::affine(linear, offset)) } else { Err(SingularMatrix) }
    }
}

impl Mul<Vector4> for Matrix4 {
    type Output = Vector4;

    fn mul(self, v: Vector4) -> Vector4 {
        let [a, b, c, d] = self.columns;
        a * v.x + b * v.y + c * v.z + d * v.w
    }
}

impl Mul for Matrix4 {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self { columns: other.columns.map(|column| self * column) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Vector3, b: Vector3) -> bool {
        (a - b).max_abs() < 16.0 * Real::EPSILON
    }

    #[test]
    fn rotations_are_right_handed() {
        let quarter = (std::f64::consts::PI / 2.0) as Real;
        let [x, y, z] = Matrix4::IDENTITY.linear().columns;
        assert!(near(Matrix4::rotation(z, quarter).transform_point(x), y));
        assert!(near(Matrix4::rotation(x, quarter).transform_point(y), z));
        assert!(near(Matrix4::rotation(y, quarter).transform_point(z), x));
    }

    #[test]
    fn products_apply_the_right_factor_first() {
        let move_then_stretch =
            Matrix4::scaling(Vector3::splat(2.0)) * Matrix4::translation(Vector3::new(1.0, 0.0, 0.0));
        assert_eq!(move_then_stretch.transform_point(Vector3::ZERO), Vector3::new(2.0, 0.0, 0.0));
        assert_eq!(
            move_then_stretch.transform_direction(Vector3::new(1.0, 0.0, 0.0)),
            Vector3::new(2.0, 0.0, 0.0)
        );
    }

    #[test]
    fn inverse_undoes_an_affine_map() {
        let axis = Vector3::new(1.0, 2.0, -0.5).normalized();
        let m = Matrix4::translation(Vector3::new(3.0, -4.0, 5.0))
            * Matrix4::rotation(axis, 0.7)
            * Matrix4::scaling(Vector3::new(2.0, 0.25, -1.5));
        let p = Vector3::new(0.1, 0.2, 0.3);
        let back = m.affine_inverse().unwrap().transform_point(m.transform_point(p));
        assert!((back - p).max_abs() < 200.0 * Real::EPSILON);
    }

    #[test]
    fn flat_maps_are_singular() {
        let flat = Matrix4::scaling(Vector3::new(1.0, 0.0, 1.0));
        assert_eq!(flat.affine_inverse(), Err(SingularMatrix));
    }

    #[test]
    fn columns_come_first_in_sixteen_numbers() {
        let mut numbers = [0.0; 16];
        for (i, n) in numbers.iter_mut().enumerate() {
            *n = i as Real;
        }
        let m = Matrix4::from_column_major(numbers);
        assert_eq!(m.columns[1], Vector4::new(4.0, 5.0, 6.0, 7.0));
        assert_eq!(m.offset(), Vector3::new(12.0, 13.0, 14.0));
        assert!(!m.is_affine());
        assert!(Matrix4::IDENTITY.is_affine());
    }
}
