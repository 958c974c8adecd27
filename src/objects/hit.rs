//! [`Hit`]: where a ray meets an object.

use vecmath::Real;

/// Upper limit of t, exclusive: infinity, of a ray along a plane, is a miss.
pub const T_MAX: Real = Real::MAX;

/// Where a ray meets one surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    pub t: Real,
    /// Index of the triangle in its mesh; 0 for other shapes.
    pub triangle: u32,
    /// Barycentric coordinates of the point: weights of the triangle's three corners, with sum 1. Zeros for a sphere
    /// or a plane.
    pub barycentric: [Real; 3],
}

impl SurfaceHit {
    /// Makes a hit on a shape that has no triangles.
    pub fn at(t: Real) -> Self {
        Self { t, triangle: 0, barycentric: [0.0; 3] }
    }
}

/// A hit on an object of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index into the scene's objects.
    pub object: u32,
    pub surface: SurfaceHit,
}
