//! [`SurfacePoint`]: the point of a surface that a ray has hit, and the error bound of it.
//!
//! The computed point `origin + t direction` carries the rounding of a long way from the origin. The nearest point of
//! the surface itself is known better. So is the distance from it beyond which every later test agrees on the side.
//! Each shape derives its error bounds beside its `nearest_point`. All are worst cases to first order, in units of
//! [`UNIT_ROUNDOFF`](vecmath::UNIT_ROUNDOFF) (u). With the surface's unit normal n, the term |n| . |p| is the sum of
//! |n_i p_i|: what an error of u in every coordinate moves a point across the surface.

use vecmath::{Real, Vector3};

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    pub point: Vector3,
    /// Unit vector across the surface, to either side. On a mesh it is the normal of the face, whatever the shading.
    pub normal: Vector3,
    /// Error bound: farther than this from `point` along the normal, no test takes a point for one on the other side.
    pub gap: Real,
}

impl SurfacePoint {
    /// Returns the point just off the surface, on the side to which `direction` leads.
    pub fn beside(&self, direction: Vector3) -> Vector3 {
        let side = if self.normal.dot(direction) < 0.0 { -1.0 } else { 1.0 };
        self.point + self.normal * (side * self.gap)
    }
}

/// The surface near a point, in the space of the object.
#[derive(Clone, Copy, Debug)]
pub struct NearestPoint {
    pub point: Vector3,
    pub normal: Vector3,
    /// How far along `normal` the point may be from the surface that a later test sees, with the rounding of an
    /// offset point counted in.
    pub error: Real,
}

/// Returns |n| . |p|.
pub(super) fn across(normal: Vector3, p: Vector3) -> Real {
    normal.map(Real::abs).dot(p.map(Real::abs))
}
