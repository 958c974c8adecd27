//! [`Ray`], along which light is followed backwards.

use vecmath::{Real, Vector3};

/// The points `origin + t * direction`, t > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    pub origin: Vector3,
    /// Of any length but zero.
    pub direction: Vector3,
}

impl Ray {
    /// Returns the point at `t`.
    pub fn at(&self, t: Real) -> Vector3 {
        self.origin + self.direction * t
    }
}

/// A ray with the reciprocals of its direction, which every test of a box needs. Computing them once saves divisions.
#[derive(Clone, Copy, Debug)]
pub struct PreparedRay {
    pub ray: Ray,
    /// 1 / direction, component by component; infinite where the direction is zero.
    pub inverse_direction: Vector3,
}

impl PreparedRay {
    #[inline]
    pub fn new(ray: Ray) -> Self {
        Self { ray, inverse_direction: ray.direction.map(|d| 1.0 / d) }
    }
}
