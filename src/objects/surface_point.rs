//! [`SurfacePoint`]: the point of a surface that a ray has hit, and its error bound.
//!
//! The computed point `origin + t direction` has an error that grows with t. The point of the surface that is nearest
//! to it is known better. The error bound is the distance from that point beyond which every later test finds the
//! right side of the surface.
//!
//! Each shape derives its error bounds beside its `nearest_point`. All are worst cases to first order, in units of
//! [`UNIT_ROUNDOFF`](vecmath::UNIT_ROUNDOFF) (u). With n the unit normal of the surface, |n| . |p| is the sum of
//! |n_i p_i|: it says how far an error of u in every coordinate moves the point p off the surface.

use vecmath::{Real, Vector3};

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    pub point: Vector3,
    /// Unit normal of the surface, on either side. On a mesh it is the normal of the face, not the smooth one.
    pub normal: Vector3,
    /// Error bound: a point farther than this from `point` along the normal is on the right side for every test.
    pub error_bound: Real,
}

impl SurfacePoint {
    /// Returns the point just off the surface, on the side that `direction` points to.
    pub fn beside(&self, direction: Vector3) -> Vector3 {
        let side = if self.normal.dot(direction) < 0.0 { -1.0 } else { 1.0 };
        self.point + self.normal * (side * self.error_bound)
    }
}

/// The surface near a point, in the space of the object.
#[derive(Clone, Copy, Debug)]
pub struct NearestPoint {
    pub point: Vector3,
    pub normal: Vector3,
    /// Error bound: how far along `normal` the point may be from the surface that a later test sees. The rounding of
    /// an offset point is included.
    pub error: Real,
}

/// Returns |n| . |p|.
pub(super) fn across(normal: Vector3, p: Vector3) -> Real {
    normal.map(Real::abs).dot(p.map(Real::abs))
}
