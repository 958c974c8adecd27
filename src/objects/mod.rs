//! What a ray can hit: the definition of a hit for every shape, in [`Real`](vecmath::Real), one ray at a time.
//!
//! This is the truth. Everything that is faster (`bvh`, `wide`) may only discard what these tests would discard too.
//! A ray is `origin + t * direction` with a direction of any length, and a hit has 0 < t < [`T_MAX`].
//!
//! A shape is one file here and a line in each list below. This folder knows nothing of trees and packets.

mod aabb;
mod hit;
mod mesh;
mod object;
mod plane;
mod ray;
mod sphere;
mod surface_point;
mod transform;
mod triangle;

pub use aabb::Aabb;
pub use hit::{Hit, SurfaceHit, T_MAX};
pub use mesh::Mesh;
pub use object::Object;
pub use plane::Plane;
pub use ray::{PreparedRay, Ray};
pub use sphere::Sphere;
pub use surface_point::SurfacePoint;
pub use transform::Transform;
pub(crate) use triangle::{Crossing, ShearAxes, box_interval};
pub use triangle::{Triangle, intersect_triangle};

use surface_point::NearestPoint;
use vecmath::{Real, Vector3};

/// A shape that a formula describes: one t for a ray, one normal for a point.
///
/// A shape that implements this is rendered one ray at a time and in packets; nothing is written twice.
pub trait Surface {
    /// Whether [`gradient`](Self::gradient) has to be normalised before it is a normal.
    const NORMALIZES: bool;

    /// Returns the nearest t > 0 at which the ray meets the surface.
    fn intersect(&self, ray: &Ray) -> Option<Real>;

    /// Returns a vector across the surface at one of its points, on the side of the normal.
    fn gradient(&self, point: Vector3) -> Vector3;

    /// Finds the point of the surface nearest to a point beside it; see [`SurfacePoint`].
    fn nearest_point(&self, near: Vector3) -> NearestPoint;

    /// Returns the box around the surface; `None` if it has no end.
    fn bounds(&self) -> Option<Aabb>;

    /// Returns the normal at one of the surface's points.
    fn normal(&self, point: Vector3) -> Vector3 {
        let gradient = self.gradient(point);
        if Self::NORMALIZES { gradient.normalized() } else { gradient }
    }
}

/// The geometry of an [`Object`].
#[derive(Clone, Debug)]
pub enum Shape {
    Sphere(Sphere),
    Plane(Plane),
    Triangle(Triangle),
    /// Index into the scene's meshes.
    Mesh(u32),
}

/// Matches a shape: the first arm stands for every shape that is a [`Surface`].
macro_rules! match_surface {
    ($shape:expr, $surface:ident => $body:expr, $($rest:tt)*) => {
        match $shape {
            $crate::objects::Shape::Sphere($surface) => $body,
            $crate::objects::Shape::Plane($surface) => $body,
            $($rest)*
        }
    };
}
pub(crate) use match_surface;

impl Shape {
    /// Returns the bounds in object space; `None` for a shape without end.
    pub fn bounds(&self, meshes: &[Mesh]) -> Option<Aabb> {
        match_surface!(self,
            surface => surface.bounds(),
            Self::Triangle(triangle) => Some(triangle.bounds()),
            Self::Mesh(mesh) => Some(*meshes[*mesh as usize].bounds()),
        )
    }

    /// Returns whether every normal that is shaded has length 1, up to rounding.
    pub fn has_unit_normal(&self) -> bool {
        match self {
            Self::Plane(plane) => (plane.shading_normal.length() - 1.0).abs() < 4.0 * Real::EPSILON,
            _ => true,
        }
    }

    /// Makes the same shape, shaded with unit normals.
    #[must_use]
    pub fn with_unit_normal(self) -> Self {
        match self {
            Self::Plane(plane) => Self::Plane(plane.with_unit_normal()),
            shape => shape,
        }
    }
}
