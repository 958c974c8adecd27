//! [`Ray`], and what is worth computing once per ray.

use super::run::Vectors;
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

/// A ray with the numbers that boxes ask it for. Most rays meet boxes and no triangle: see [`Shear`].
#[derive(Clone, Copy, Debug)]
pub struct PreparedRay {
    pub ray: Ray,
    /// 1 / direction, infinite where the direction is zero.
    pub inverse_direction: Vector3,
}

impl PreparedRay {
    pub fn new(ray: Ray) -> Self {
        Self { ray, inverse_direction: ray.direction.map(|d| 1.0 / d) }
    }
}

/// The axes in which a ray is sheared to lie along one of them (Woop, Benthin, Wald: Watertight Ray/Triangle
/// Intersection, JCGT 2013): `z` has the largest component of the direction, x and y follow it cyclically.
///
/// The paper swaps x and y for a negative direction to keep the winding; both sides count here.
#[derive(Clone, Copy, Debug)]
pub struct ShearAxes {
    pub x: usize,
    pub y: usize,
    pub z: usize,
}

impl ShearAxes {
    #[inline(always)]
    pub fn of(direction: Vector3) -> Self {
        let [x, y, z] = direction.map(Real::abs).to_array();
        Self::along(if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        })
    }

    #[inline(always)]
    pub fn along(z: usize) -> Self {
        Self { x: (z + 1) % 3, y: (z + 2) % 3, z: z % 3 }
    }

    /// A vector's components in the order of these axes.
    #[inline(always)]
    pub fn order(&self, vector: Vector3) -> Vector3 {
        let components = vector.to_array();
        Vector3::new(components[self.x], components[self.y], components[self.z])
    }

    /// The same of one vector of a run.
    #[inline(always)]
    pub fn pick(&self, vectors: &Vectors, number: usize) -> Vector3 {
        let [x, y, z] = [&vectors.0[self.x], &vectors.0[self.y], &vectors.0[self.z]];
        Vector3::new(x[number], y[number], z[number])
    }
}

/// The shear that lays a ray along the z axis of its [`ShearAxes`]. Everything here has its components in their order.
#[derive(Clone, Copy, Debug)]
pub struct Shear {
    /// Shear factors, and 1 / direction.z.
    factors: Vector3,
}

impl Shear {
    #[inline(always)]
    pub fn new(direction: Vector3, inverse_direction: Vector3) -> Self {
        let d = direction;
        Self { factors: Vector3::new(d.x / d.z, d.y / d.z, inverse_direction.z) }
    }

    /// `offset` (a point less the ray's origin) in the space in which the ray is the z axis; z is then t.
    #[inline(always)]
    pub fn apply(&self, offset: Vector3) -> Vector3 {
        let (f, z) = (self.factors, offset.z);
        Vector3::new(offset.x - f.x * z, offset.y - f.y * z, f.z * z)
    }
}
