//! [`Plane`].

use super::surface_point::{NearestPoint, across};
use super::{Aabb, Ray, Surface};
use vecmath::{Real, UNIT_ROUNDOFF, Vector3};

/// The points with `normal . point = offset`.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// Of any length. It is never flipped towards the eye.
    pub normal: Vector3,
    pub offset: Real,
    /// The normal that shading and pictures of normals use.
    pub shading_normal: Vector3,
}

impl Plane {
    /// Makes a plane that is shaded with its normal as given, as the starter does.
    ///
    /// A normal so long or short that products with it would overflow or underflow is scaled by a power of two, and
    /// the offset with it: the plane is the same, to the last bit.
    pub fn new(normal: Vector3, offset: Real) -> Self {
        const USUAL: std::ops::RangeInclusive<Real> = 1e-30..=1e30;
        let longest = normal.max_abs();
        if USUAL.contains(&longest) || longest == 0.0 {
            return Self { normal, offset, shading_normal: normal };
        }
        // In two steps, because the whole power of two may be too large.
        let half = (2.0 as Real).powi((longest.log2() / -2.0).round() as i32);
        Self { normal: normal * half * half, offset: offset * half * half, shading_normal: normal }
    }

    /// Returns the same plane, shaded with the unit vector of its normal.
    #[must_use]
    pub fn with_unit_normal(self) -> Self {
        Self { shading_normal: self.shading_normal.normalized(), ..self }
    }
}

/// Roundings of a surface point, in units of |n| . |p| and of the plane's distance from the origin: normal . p -
/// offset has 4 u (three products, three sums), the division by the normal's length 1 u, the step to the plane 2 u,
/// the sum of point and offset 1 u, and the test of a ray that starts there 4 u again.
const PLANE_ROUNDINGS: Real = 12.0;

impl Surface for Plane {
    /// The starter shades with the normal as the file gives it.
    const NORMALIZES: bool = false;

    /// Intersects a ray with the plane. For a parallel ray t is infinite or NaN, which is a miss.
    #[inline(always)]
    fn intersect(&self, ray: &Ray) -> Option<Real> {
        let t = (self.offset - self.normal.dot(ray.origin)) / self.normal.dot(ray.direction);
        (t > 0.0).then_some(t)
    }

    #[inline(always)]
    fn gradient(&self, _: Vector3) -> Vector3 {
        self.shading_normal
    }

    fn nearest_point(&self, near: Vector3) -> NearestPoint {
        let length = self.normal.length();
        let normal = self.normal / length;
        let height = (self.normal.dot(near) - self.offset) / length;
        let point = near - normal * height;
        let coordinates = across(normal, near).max(across(normal, point));
        let error = UNIT_ROUNDOFF * PLANE_ROUNDINGS * (coordinates + (self.offset / length).abs());
        NearestPoint { point, normal, error }
    }

    fn bounds(&self) -> Option<Aabb> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hit(normal: [Real; 3], offset: Real, direction: [Real; 3]) -> Option<Real> {
        let origin = Vector3::new(0.0, 3.0, 0.0);
        Plane::new(normal.into(), offset).intersect(&Ray { origin, direction: direction.into() })
    }

    #[test]
    fn the_offset_is_along_the_normal_as_given() {
        assert_eq!(hit([0.0, 1.0, 0.0], -2.0, [0.0, -1.0, 0.0]), Some(5.0));
        assert_eq!(hit([0.0, 2.0, 0.0], -2.0, [0.0, -1.0, 0.0]), Some(4.0));
    }

    #[test]
    fn the_length_of_the_normal_may_be_anything() {
        for power in [-140, -60, 0, 60, 120] {
            let scale = (2.0 as Real).powi(power);
            let found = hit([0.0, scale, 0.5 * scale], -2.0 * scale, [0.0, -1.0, 0.25]);
            assert_eq!(found, hit([0.0, 1.0, 0.5], -2.0, [0.0, -1.0, 0.25]), "2^{power}");
        }
    }

    #[test]
    fn a_unit_normal_changes_only_the_shading() {
        let normal = Vector3::new(0.0, 4.0, 0.0);
        let (given, unit) = (Plane::new(normal, 8.0), Plane::new(normal, 8.0).with_unit_normal());
        assert_eq!((given.shading_normal, unit.shading_normal), (normal, normal / 4.0));
        assert_eq!((unit.normal, unit.offset), (given.normal, given.offset));
    }

    #[test]
    fn planes_behind_are_missed_and_parallel_ones_are_infinitely_far() {
        assert_eq!(hit([0.0, 1.0, 0.0], -2.0, [0.0, 1.0, 0.0]), None);
        assert!(hit([0.0, 1.0, 0.0], -2.0, [1.0, 0.0, 0.0]).is_none_or(|t| t == Real::INFINITY));
        assert_eq!(hit([0.0, 1.0, 0.0], 3.0, [1.0, 0.0, 0.0]), None);
    }
}
