//! [`SurfacePoint`]: where on a surface a ray has ended, and how well that is known.
//!
//! The computed point `origin + t direction` is off by the rounding of a long way from the origin. The nearest point of
//! the surface itself is better known, and so is how far from it a point must be for every later test to agree on its
//! side. All bounds are worst cases to first order, in units of [`ROUNDING`] (u below); `n` is the surface's unit
//! normal and |n| . |p| the sum of |n_i p_i|: what an error of u in every coordinate moves across the surface.

use super::{Plane, Sphere};
use crate::render::robust::ROUNDING;
use vecmath::{Real, Vector3};

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    pub point: Vector3,
    /// Unit vector across the surface, to either side. Of a mesh: across the face, however that is shaded.
    pub normal: Vector3,
    /// Further than this from `point` along the normal, no test takes a point for one on the other side.
    pub gap: Real,
}

impl SurfacePoint {
    /// The point just off the surface on the side that `direction` goes to.
    pub fn beside(&self, direction: Vector3) -> Vector3 {
        let side = if self.normal.dot(direction) < 0.0 { -1.0 } else { 1.0 };
        self.point + self.normal * (side * self.gap)
    }
}

/// The surface near a point, in the space of the object.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearestPoint {
    pub point: Vector3,
    pub normal: Vector3,
    /// How far along `normal` the point may be from the surface that a later test sees, with the rounding of an
    /// offset point counted in.
    pub error: Real,
}

/// |n| . |p|
pub(super) fn across(normal: Vector3, p: Vector3) -> Real {
    normal.map(Real::abs).dot(p.map(Real::abs))
}

/// Of the radius. The unit vector to the point is 5 u too long or short at most (three squares, their sum, root,
/// division), times the radius 1 u more. The test of a ray from there takes |f|^2 - r^2 with f = origin - center: f has
/// 1 u, the squares and their sum 3 u of r^2, the radius' square and the difference 2 u more, together 7 u of r^2,
/// which is 3.5 u of r in height; the discriminant, by the nearest point to the centre, the same. 5 + 1 + 1 + 3.5 + 3.5.
const SPHERE_ROUNDINGS: Real = 16.0;
/// Of the coordinates: the sum of centre and radius, and the sum of point and offset.
const SUM_ROUNDINGS: Real = 2.0;

impl Sphere {
    pub(super) fn nearest_point(&self, near: Vector3) -> NearestPoint {
        let normal = self.normal(near);
        let point = self.center + normal * self.radius;
        let error = ROUNDING * (SPHERE_ROUNDINGS * self.radius + SUM_ROUNDINGS * across(normal, point));
        NearestPoint { point, normal, error }
    }
}

/// Of |n| . |p| and the plane's distance from the origin: normal . p - offset has 4 u (three products, three sums), the
/// division by the normal's length 1 u, the step to the plane 2 u, the sum of point and offset 1 u, and the test of a
/// ray from there 4 u again.
const PLANE_ROUNDINGS: Real = 12.0;

impl Plane {
    pub(super) fn nearest_point(&self, near: Vector3) -> NearestPoint {
        let length = self.normal.length();
        let normal = self.normal / length;
        let height = (self.normal.dot(near) - self.offset) / length;
        let point = near - normal * height;
        let coordinates = across(normal, near).max(across(normal, point));
        let error = ROUNDING * PLANE_ROUNDINGS * (coordinates + (self.offset / length).abs());
        NearestPoint { point, normal, error }
    }
}

/// Of |n| . |corners|: the weights sum to 1 within 3 u (two sums, one division), products and sums of corners have 3 u,
/// the sum of point and offset 2 u.
const CORNER_ROUNDINGS: Real = 8.0;
/// Of l^3 / A, with l the longest edge and A the area. A ray that leaves the triangle's inside looks at corners up to l
/// away. Moved to its origin and sheared they have 6 u of l, so an edge function, two products of numbers up to 2 l,
/// has 60 u of l^2; three of them, each times a depth up to l, are divided by 2 A.
const SHAPE_ROUNDINGS: Real = 90.0;
/// Of l: the depths themselves.
const DEPTH_ROUNDINGS: Real = 6.0;
/// Slivers of a larger l^2 / A than this are treated as if they had this one: a gap of a hundred thousandth of the
/// length, beyond which leaks would be the worse evil.
const LARGEST_SHAPE: Real = (1 << 30) as Real;

/// The point of a triangle with these weights. The weights sum to 1, so it lies in the triangle's plane even where t
/// has no digits, as for triangles seen edge-on.
pub(super) fn triangle_point(corners: [Vector3; 3], barycentric: [Real; 3], normal: Vector3) -> NearestPoint {
    let [a, b, c] = corners;
    let point = a * barycentric[0] + b * barycentric[1] + c * barycentric[2];
    let edges = [b - a, c - b, a - c];
    let longest = edges.into_iter().map(Vector3::length).fold(0.0, Real::max);
    let area = 0.5 * edges[0].cross(edges[2]).length();
    // An area of zero gives infinity or NaN, and `min` passes over either.
    let shape = (longest * longest / area).min(LARGEST_SHAPE);
    let corner = a.map(Real::abs).max(b.map(Real::abs)).max(c.map(Real::abs));
    let coordinates = CORNER_ROUNDINGS * across(normal, corner);
    let error = ROUNDING * (coordinates + (SHAPE_ROUNDINGS * shape + DEPTH_ROUNDINGS) * longest);
    NearestPoint { point, normal, error }
}
