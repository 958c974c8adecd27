//! [`Ray`], and what is worth computing once per ray.

use vecmath::{Real, Vector3};

/// The points `origin + t * direction`, t > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    pub origin: Vector3,
    /// Of any length but zero.
    pub direction: Vector3,
}

impl Ray {
    pub fn at(&self, t: Real) -> Vector3 {
        self.origin + self.direction * t
    }
}

/// A ray with the numbers that boxes ask it for. Most rays meet boxes and no triangle: see [`ShearedRay`].
#[derive(Clone, Copy, Debug)]
pub struct PreparedRay {
    pub ray: Ray,
    /// 1 / direction, infinite where the direction is zero.
    pub inverse_direction: Vector3,
}

impl PreparedRay {
    /// Stands where no ray is.
    pub const NONE: Self =
        Self { ray: Ray { origin: Vector3::ZERO, direction: Vector3::ZERO }, inverse_direction: Vector3::ZERO };

    pub fn new(ray: Ray) -> Self {
        Self { ray, inverse_direction: ray.direction.map(|d| 1.0 / d) }
    }
}

/// The shear that lays a ray along an axis (Woop, Benthin, Wald: Watertight Ray/Triangle Intersection, JCGT 2013).
#[derive(Clone, Copy, Debug)]
pub struct ShearedRay {
    /// Axes: `z` has the largest component of the direction, x and y follow it cyclically.
    pub x: usize,
    pub y: usize,
    pub z: usize,
    /// Shear factors and 1 / direction\[z\].
    pub shear: Vector3,
}

impl ShearedRay {
    #[inline]
    pub fn new(ray: &PreparedRay) -> Self {
        let d = ray.ray.direction;
        let z = if d.x.abs() >= d.y.abs() && d.x.abs() >= d.z.abs() {
            0
        } else if d.y.abs() >= d.z.abs() {
            1
        } else {
            2
        };
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        // The paper swaps x and y for a negative direction to keep the winding; both sides count here.
        Self { x, y, z, shear: Vector3::new(d[x] / d[z], d[y] / d[z], ray.inverse_direction[z]) }
    }

    /// `offset` (a point less the ray's origin) in the space in which the ray is the z axis; z is then t.
    #[inline]
    pub fn apply(&self, offset: Vector3) -> Vector3 {
        let z = offset[self.z];
        Vector3::new(offset[self.x] - self.shear.x * z, offset[self.y] - self.shear.y * z, self.shear.z * z)
    }
}
