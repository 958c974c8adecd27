//! [`Aabb`]: an axis-aligned box, and the slab test of a ray against it.

use super::{PreparedRay, T_MAX};
use vecmath::{Matrix4, Real, Vector3, chosen_if, greater, lesser, swapped_if};

/// The points between two corners, faces included. `min > max` means empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    pub min: Vector3,
    pub max: Vector3,
}

/// Relative error bound of a distance to a plane of a box: four roundings at most (two subtractions, reciprocal,
/// product). Distances are widened by this share, after Ize, Robust BVH Ray Traversal (JCGT 2013).
const SLAB_ERROR: Real = 8.0 * Real::EPSILON;

impl Aabb {
    pub const EMPTY: Self = Self { min: Vector3::splat(Real::INFINITY), max: Vector3::splat(Real::NEG_INFINITY) };

    pub fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }

    pub fn of_points(points: impl IntoIterator<Item = Vector3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, point| bounds.union(&Self { min: point, max: point }))
    }

    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    pub fn center(&self) -> Vector3 {
        self.min * 0.5 + self.max * 0.5
    }

    pub fn size(&self) -> Vector3 {
        self.max - self.min
    }

    /// Returns the largest distance of a point of the box from the origin, in the maximum norm.
    pub fn max_abs(&self) -> Real {
        self.min.max_abs().max(self.max.max_abs())
    }

    /// Returns the largest distance of a point of the box from the origin, axis by axis.
    pub fn corner_reach(&self) -> Vector3 {
        self.min.map(Real::abs).max(self.max.map(Real::abs))
    }

    /// Returns the box, larger by `margin` on every side.
    pub fn grown(&self, margin: Real) -> Self {
        self.grown_by(Vector3::splat(margin))
    }

    /// Returns the box, larger by a margin for each axis.
    pub fn grown_by(&self, margin: Vector3) -> Self {
        Self { min: self.min - margin, max: self.max + margin }
    }

    pub fn corners(&self) -> [Vector3; 8] {
        std::array::from_fn(|corner| {
            let pick = |axis: usize| if corner >> axis & 1 == 0 { self.min[axis] } else { self.max[axis] };
            Vector3::new(pick(0), pick(1), pick(2))
        })
    }

    /// Returns a box around the image of this one.
    pub fn transformed(&self, matrix: &Matrix4) -> Self {
        Self::of_points(self.corners().map(|corner| matrix.transform_point(corner)))
    }

    /// Returns the t at which the ray enters the box, grown by `margin`; `None` if it does not enter at a t from 0 to
    /// `t_max`. A ray that starts inside enters at 0.
    ///
    /// It never misses a box that the exact ray meets. A ray in the plane of a face (0 * infinity, NaN) meets the
    /// box.
    #[inline(always)]
    pub fn entry(&self, ray: &PreparedRay, margin: Real, t_max: Real) -> Option<Real> {
        let (meets, near) = self.interval(ray, margin, t_max, swapped_if);
        meets.then_some(near)
    }

    /// Returns whether there is an [`entry`](Self::entry), and its t. It has no branches, so that loops over rays
    /// vectorise.
    #[inline(always)]
    pub fn entry_branchless(&self, ray: &PreparedRay, margin: Real, t_max: Real) -> (bool, Real) {
        self.interval(ray, margin, t_max, chosen_if)
    }

    /// Runs the slab test that both share; `swapped_if` swaps two numbers if its first argument is true.
    #[inline(always)]
    fn interval(
        &self,
        ray: &PreparedRay,
        margin: Real,
        t_max: Real,
        swapped_if: impl Fn(bool, Real, Real) -> (Real, Real),
    ) -> (bool, Real) {
        let (mut near, mut far) = (0.0 as Real, t_max);
        for axis in 0..3 {
            let origin = ray.ray.origin[axis];
            let inverse = ray.inverse_direction[axis];
            let a = (self.min[axis] - origin - margin) * inverse;
            let b = (self.max[axis] - origin + margin) * inverse;
            let (enter, leave) = swapped_if(inverse < 0.0, a, b);
            // NaN changes nothing here.
            near = greater(near, enter * (1.0 - SLAB_ERROR));
            far = lesser(far, leave * (1.0 + SLAB_ERROR));
        }
        // A negative `leave` was widened the wrong way. But its sign is exact: the box is behind the ray.
        ((near <= far) & (near < T_MAX), near)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objects::Ray;

    fn unit() -> Aabb {
        Aabb { min: Vector3::splat(-1.0), max: Vector3::splat(1.0) }
    }

    fn entry(origin: [Real; 3], direction: [Real; 3]) -> Option<Real> {
        let ray = Ray { origin: origin.into(), direction: direction.into() };
        unit().entry(&PreparedRay::new(ray), 0.0, T_MAX)
    }

    #[test]
    fn enters_in_front_and_not_behind() {
        let near = entry([0.0, 0.0, 5.0], [0.0, 0.0, -1.0]).unwrap();
        assert!((near - 4.0).abs() < 64.0 * Real::EPSILON);
        assert_eq!(entry([0.0, 0.0, 5.0], [0.0, 0.0, 1.0]), None);
        assert_eq!(entry([0.0, 0.0, 0.0], [0.3, 0.2, 0.1]), Some(0.0));
        assert_eq!(entry([0.0, 3.0, 5.0], [0.0, 0.0, -1.0]), None);
    }

    #[test]
    fn a_ray_in_the_plane_of_a_face_meets_the_box() {
        for x in [-1.0, 1.0] {
            for zero in [0.0, -0.0] {
                assert!(entry([x, 0.0, 5.0], [zero, 0.0, -1.0]).is_some(), "{x} {zero}");
            }
        }
    }

    #[test]
    fn the_image_of_a_box_encloses_the_images_of_its_points() {
        let turn = Matrix4::rotation(Vector3::new(0.6, 0.8, 0.0), 0.5);
        let image = unit().transformed(&turn);
        let p = turn.transform_point(Vector3::new(1.0, -1.0, 1.0));
        assert_eq!(image.union(&Aabb { min: p, max: p }), image);
    }
}
