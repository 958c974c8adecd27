//! [`Matrix3`]: the linear part of a transformation.

use crate::{Real, Vector3};
use std::ops::Mul;

/// Three columns of three numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrix3 {
    pub columns: [Vector3; 3],
}

impl Matrix3 {
    /// Changes nothing.
    pub const IDENTITY: Self =
        Self::from_columns(Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.0, 0.0, 1.0));

    /// Makes a matrix of these columns.
    pub const fn from_columns(x: Vector3, y: Vector3, z: Vector3) -> Self {
        Self { columns: [x, y, z] }
    }

    /// Swaps rows and columns.
    #[inline]
    pub fn transposed(self) -> Self {
        let [a, b, c] = self.columns;
        Self::from_columns(Vector3::new(a.x, b.x, c.x), Vector3::new(a.y, b.y, c.y), Vector3::new(a.z, b.z, c.z))
    }

    /// Returns the signed volume of the columns' parallelepiped.
    pub fn determinant(self) -> Real {
        let [a, b, c] = self.columns;
        a.dot(b.cross(c))
    }

    /// Returns the inverse, or `None` if the matrix is singular to working precision or an entry would not be finite.
    ///
    /// Rows and columns are first scaled to largest component 1, so that units make no difference. The usual formula
    /// by cofactors loses as many digits as the determinant has lost. Where these are many, elimination is used
    /// instead: it loses no more than the [condition number](Self::condition_number) says.
    pub fn inverse(self) -> Option<Self> {
        const REGULAR: Real = 1e-3;
        let column_scale = self.columns.map(Vector3::max_abs);
        let [a, b, c] = [0, 1, 2].map(|i| self.columns[i] / column_scale[i]);
        let rows = Self::from_columns(a, b, c).transposed();
        let row_scale = rows.columns.map(Vector3::max_abs);
        let [a, b, c] = [0, 1, 2].map(|i| rows.columns[i] / row_scale[i]);
        // With rows as columns, the cross products are the columns of the inverse.
        let cofactors = [b.cross(c), c.cross(a), a.cross(b)];
        let determinant = a.dot(cofactors[0]);
        if determinant.is_nan() {
            return None;
        }
        let scaled = match determinant.abs() > REGULAR {
            true => cofactors.map(|cofactor| cofactor / determinant),
            false => Self::from_columns(a, b, c).transposed().eliminated()?.columns,
        };
        let column = |i: usize| {
            let column = scaled[i] / row_scale[i];
            Vector3::new(column.x / column_scale[0], column.y / column_scale[1], column.z / column_scale[2])
        };
        let inverse = Self::from_columns(column(0), column(1), column(2));
        let regular = self.condition_with(inverse) < 1.0 / (64.0 * Real::EPSILON);
        (regular && inverse.columns.iter().all(|c| c.is_finite())).then_some(inverse)
    }

    /// Returns the inverse by Gauss-Jordan elimination with full pivoting; `None` if a pivot is zero.
    fn eliminated(self) -> Option<Self> {
        let entries = self.transposed().columns.map(Vector3::to_array);
        let mut left = entries;
        let mut right = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut pivot_of_column = [0; 3];
        let mut done = [false; 3];
        for _ in 0..3 {
            let places = (0..9).map(|i| (i / 3, i % 3)).filter(|&(row, _)| !done[row]);
            let (row, column) = places.max_by(|a, b| left[a.0][a.1].abs().total_cmp(&left[b.0][b.1].abs()))?;
            let pivot: Real = left[row][column];
            if pivot == 0.0 {
                return None;
            }
            (done[row], pivot_of_column[column]) = (true, row);
            for other in (0..3).filter(|&other| other != row) {
                let factor = left[other][column] / pivot;
                for k in 0..3 {
                    left[other][k] -= factor * left[row][k];
                    right[other][k] -= factor * right[row][k];
                }
                left[other][column] = 0.0;
            }
            left[row] = left[row].map(|x| x / pivot);
            right[row] = right[row].map(|x| x / pivot);
        }
        let [x, y, z] = pivot_of_column.map(|row| Vector3::from(right[row]));
        Some(Self::from_columns(x, y, z).transposed())
    }

    /// Returns the absolute values of the entries. Bounds of rounding errors need them.
    #[inline]
    pub fn abs(self) -> Self {
        Self { columns: self.columns.map(|column| column.map(Real::abs)) }
    }

    /// Returns the condition number of Bauer and Skeel: the largest row sum of |M| |M^-1|, which says how much an
    /// inverse amplifies errors. It is 1 for any scaling along the axes, a little more for rotations, and infinite
    /// for a singular matrix.
    pub fn condition_number(self) -> Real {
        let scale = self.columns.map(Vector3::max_abs);
        let [a, b, c] = [0, 1, 2].map(|i| self.columns[i] / scale[i]);
        let unscaled = Self::from_columns(a, b, c);
        unscaled.eliminated().map_or(Real::INFINITY, |inverse| unscaled.condition_with(inverse))
    }

    fn condition_with(self, inverse: Self) -> Real {
        let condition = (self.abs() * inverse.abs()).row_sum_norm();
        // NaN, or an inverse that has left the range of numbers.
        if condition > 0.5 { condition.max(1.0) } else { Real::INFINITY }
    }

    /// Returns the largest sum of absolute values in a row: the norm that belongs to [`Vector3::max_abs`].
    pub fn row_sum_norm(self) -> Real {
        let [a, b, c] = self.columns.map(|column| column.map(Real::abs));
        (a + b + c).max_abs()
    }
}

impl Mul<Vector3> for Matrix3 {
    type Output = Vector3;

    #[inline]
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
    fn inverse_loses_what_the_condition_number_says() {
        // Columns at small angles to one another, times uneven units: determinants far below the rounding of 1.
        for tilt in [1e-2, 1e-4, 1e-6] {
            let tilt = tilt * if Real::EPSILON > 1e-10 { 100.0 } else { 1.0 };
            let m = Matrix3::from_columns(
                Vector3::new(1.0, 2.0, 3.0) * 1e6,
                Vector3::new(1.0, 2.0 + tilt, 3.0 - 0.3 * tilt),
                Vector3::new(1.0 + tilt * 0.7, 2.0, 3.0 + tilt * tilt) * 1e-6,
            );
            let product = m * m.inverse().unwrap();
            let error = Matrix3::IDENTITY.columns.iter().zip(product.columns).map(|(a, b)| (*a - b).max_abs());
            let condition = m.condition_number();
            assert!(error.fold(0.0, Real::max) < 8.0 * condition * Real::EPSILON, "{tilt}: {product:?}");
        }
    }

    #[test]
    fn condition_numbers_ignore_units_and_see_singular_matrices() {
        let [a, b, c] = Matrix3::IDENTITY.columns;
        assert_eq!(Matrix3::from_columns(a * 1e9, b, c * 1e-9).condition_number(), 1.0);
        assert_eq!(Matrix3::from_columns(a, b, Vector3::ZERO).condition_number(), Real::INFINITY);
        assert!(sample().condition_number() < 10.0);
        let nearly = Matrix3::from_columns(a, b + c, b + c * (1.0 + 64.0 * Real::EPSILON));
        assert!(nearly.condition_number() > 0.01 / Real::EPSILON);
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
