//! [`Matrix3`]: the linear part of a transformation.

use crate::{Real, Vector3};
use std::ops::Mul;

/// Three columns of three numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrix3 {
    pub columns: [Vector3; 3],
}

impl Matrix3 {
    /// A matrix of these columns.
    pub const fn from_columns(x: Vector3, y: Vector3, z: Vector3) -> Self {
        Self { columns: [x, y, z] }
    }

    /// Rows become columns.
    pub fn transposed(self) -> Self {
        let [a, b, c] = self.columns;
        Self::from_columns(Vector3::new(a.x, b.x, c.x), Vector3::new(a.y, b.y, c.y), Vector3::new(a.z, b.z, c.z))
    }

    /// The signed volume of the columns' parallelepiped.
    pub fn determinant(self) -> Real {
        let [a, b, c] = self.columns;
        a.dot(b.cross(c))
    }

    /// The inverse, or `None` where the matrix is singular to working precision or an entry would not be finite.
    ///
    /// Rows and columns are first scaled to largest component 1, so that units do not count. What is then left of the
    /// determinant carries an error of a few rounding units; below 16 of them it cannot be told from zero.
    pub fn inverse(self) -> Option<Self> {
        let column_scale = self.columns.map(Vector3::max_abs);
        let [a, b, c] = [0, 1, 2].map(|i| self.columns[i] / column_scale[i]);
        let rows = Self::from_columns(a, b, c).transposed();
        let row_scale = rows.columns.map(Vector3::max_abs);
        let [a, b, c] = [0, 1, 2].map(|i| rows.columns[i] / row_scale[i]);
        // With rows as columns, the cross products are the columns of the inverse.
        let cofactors = [b.cross(c), c.cross(a), a.cross(b)];
        let determinant = a.dot(cofactors[0]);
        if !(determinant.abs() > 16.0 * Real::EPSILON && determinant.is_finite()) {
            return None;
        }
        let column = |i: usize| {
            let scaled = cofactors[i] / determinant / row_scale[i];
            Vector3::new(scaled.x / column_scale[0], scaled.y / column_scale[1], scaled.z / column_scale[2])
        };
        let inverse = Self::from_columns(column(0), column(1), column(2));
        inverse.columns.iter().all(|c| c.is_finite()).then_some(inverse)
    }

    /// The largest sum of absolute values in a row: the norm that belongs to [`Vector3::max_abs`].
    pub fn row_sum_norm(self) -> Real {
        let [a, b, c] = self.columns.map(|column| column.map(Real::abs));
        (a + b + c).max_abs()
    }
}

impl Mul<Vector3> for Matrix3 {
    type Output = Vector3;

    fn mul(self, v: Vector3) -> Vector3 {
        let [a, b, c] = self.columns;
        a * v.x + b * v.y + c * v.z
    }
}

impl Mul for Matrix3 {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self { columns: other.columns.map(|column| self * column) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Matrix3 {
        Matrix3::from_columns(
            Vector3::new(2.0, 0.0, 1.0),
            Vector3::new(-1.0, 3.0, 0.5),
            Vector3::new(0.0, 4.0, -2.0),
        )
    }

    #[test]
    fn inverse_undoes_the_matrix() {
        let inverse = sample().inverse().unwrap();
        let v = Vector3::new(0.3, -7.0, 11.0);
        let back = inverse * (sample() * v);
        assert!((back - v).max_abs() < 1e3 * Real::EPSILON);
    }

    #[test]
    fn inverse_of_badly_scaled_units_is_exact() {
        let diagonal = Matrix3::from_columns(
            Vector3::new(2.0 as Real, 0.0, 0.0),
            Vector3::new(0.0, (2.0 as Real).powi(-30), 0.0),
            Vector3::new(0.0, 0.0, (2.0 as Real).powi(30)),
        );
        let inverse = diagonal.inverse().unwrap();
        assert_eq!(inverse.columns[1].y, (2.0 as Real).powi(30));
        assert_eq!(inverse.columns[2].z, (2.0 as Real).powi(-30));
    }

    #[test]
    fn singular_matrices_have_no_inverse() {
        let [a, b, _] = sample().columns;
        assert_eq!(Matrix3::from_columns(a, b, a).inverse(), None);
        assert_eq!(Matrix3::from_columns(a, b, Vector3::ZERO).inverse(), None);
    }

    #[test]
    fn transposing_twice_changes_nothing() {
        assert_eq!(sample().transposed().transposed(), sample());
        assert_eq!(sample().transposed().determinant(), sample().determinant());
    }
}
