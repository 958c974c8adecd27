//! [`Plane`].

use super::Ray;
use vecmath::{Real, Vector3};

/// The points with `normal . point = offset`.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// As the file gives it: of any length, and never turned towards the eye.
    pub normal: Vector3,
    pub offset: Real,
}

impl Plane {
    /// t of the ray's point on the plane, if t > 0. A parallel ray gives an infinite or NaN t: a miss.
    pub fn hit(&self, ray: &Ray) -> Option<Real> {
        let t = (self.offset - self.normal.dot(ray.origin)) / self.normal.dot(ray.direction);
        (t > 0.0).then_some(t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hit(normal: [Real; 3], offset: Real, direction: [Real; 3]) -> Option<Real> {
        let origin = Vector3::new(0.0, 3.0, 0.0);
        Plane { normal: normal.into(), offset }.hit(&Ray { origin, direction: direction.into() })
    }

    #[test]
    fn the_offset_is_along_the_normal_as_given() {
        assert_eq!(hit([0.0, 1.0, 0.0], -2.0, [0.0, -1.0, 0.0]), Some(5.0));
        assert_eq!(hit([0.0, 2.0, 0.0], -2.0, [0.0, -1.0, 0.0]), Some(4.0));
    }

    #[test]
    fn behind_is_missed_and_parallel_is_beyond_every_limit() {
        assert_eq!(hit([0.0, 1.0, 0.0], -2.0, [0.0, 1.0, 0.0]), None);
        assert!(hit([0.0, 1.0, 0.0], -2.0, [1.0, 0.0, 0.0]).is_none_or(|t| t == Real::INFINITY));
        assert_eq!(hit([0.0, 1.0, 0.0], 3.0, [1.0, 0.0, 0.0]), None);
    }
}
