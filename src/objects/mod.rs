//! Objects: the definition of a hit for every shape, in [`Real`](vecmath::Real), one ray at a time.
//!
//! These tests decide what is hit. Everything that is faster (`bvh`, `wide`) may only discard what they would discard
//! too. A ray is `origin + t * direction` with a direction of any length, and a hit has 0 < t < [`T_MAX`].
//!
//! Each shape has a file here and a line in each list below. Nothing here knows of trees or packets.

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
pub use sphere::{ExtremeSphere, Sphere};
pub use surface_point::SurfacePoint;
pub use transform::Transform;
pub(crate) use triangle::{Crossing, ShearAxes, box_interval};
pub use triangle::{Triangle, intersect_triangle};

use surface_point::NearestPoint;
use vecmath::{Matrix4, Real, Vector3, exponent, is_unusual};

/// A shape that formulas describe: a ray has one nearest t, a point has one normal.
///
/// A shape that implements this is rendered one ray at a time and in packets. No formula is written twice.
pub trait Surface {
    /// Whether [`gradient`](Self::gradient) must be normalised to give the normal.
    const NORMALIZES: bool;

    /// Returns the nearest t > 0 at which the ray meets the surface.
    fn intersect(&self, ray: &Ray) -> Option<Real>;

    /// Returns a vector perpendicular to the surface at one of its points, on the side of the normal.
    fn gradient(&self, point: Vector3) -> Vector3;

    /// Finds the point of the surface that is nearest to a given point; see [`SurfacePoint`].
    fn nearest_point(&self, near: Vector3) -> NearestPoint;

    /// Returns the box around the surface; `None` if the surface is infinite.
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
    ExtremeSphere(ExtremeSphere),
    Plane(Plane),
    Triangle(Triangle),
    /// Index into the scene's meshes.
    Mesh(u32),
}

/// Matches a shape. The first arm stands for every shape that is a [`Surface`].
macro_rules! match_surface {
    ($shape:expr, $surface:ident => $body:expr, $($rest:tt)*) => {
        match $shape {
            $crate::objects::Shape::Sphere($surface) => $body,
            $crate::objects::Shape::ExtremeSphere($surface) => $body,
            $crate::objects::Shape::Plane($surface) => $body,
            $($rest)*
        }
    };
}
pub(crate) use match_surface;

impl Shape {
    /// Returns the name of the shape's block in a scene file.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Sphere(_) | Self::ExtremeSphere(_) => "Sphere",
            Self::Plane(_) => "Plane",
            Self::Triangle(_) => "Triangle",
            Self::Mesh(_) => "TriangleMesh",
        }
    }

    /// Returns the bounds in object space; `None` for an infinite shape.
    pub fn bounds(&self, meshes: &[Mesh]) -> Option<Aabb> {
        match_surface!(self,
            surface => surface.bounds(),
            Self::Triangle(triangle) => Some(triangle.bounds()),
            Self::Mesh(mesh) => Some(*meshes[*mesh as usize].bounds()),
        )
    }

    /// Returns whether all normals used for shading have length 1, up to rounding.
    pub fn has_unit_normal(&self) -> bool {
        match self {
            Self::Plane(plane) => (plane.shading_normal.length() - 1.0).abs() < 4.0 * Real::EPSILON,
            _ => true,
        }
    }

    /// Returns the same shape in the space of the same matrix, or in a space of its own, so that no product in its test
    /// leaves the range of numbers, and points of a tiny sphere keep their digits. Powers of two change no bit of a hit.
    #[must_use]
    pub fn within_range(self, world_from_object: Option<Matrix4>) -> (Self, Option<Matrix4>) {
        match self {
            Self::Sphere(sphere) if sphere.is_near_rounding() => {
                let own = Matrix4::translation(sphere.center);
                let matrix = world_from_object.map_or(own, |matrix| matrix * own);
                Self::Sphere(Sphere { center: Vector3::ZERO, ..sphere }).within_range(Some(matrix))
            }
            Self::Sphere(sphere) => {
                let columns = world_from_object.map(|matrix| matrix.linear().columns);
                let is_scaled = columns.is_some_and(|columns| columns.iter().any(|c| is_unusual(c.max_abs())));
                let is_extreme = is_unusual(sphere.radius) || is_scaled;
                let shape = if is_extreme { Self::ExtremeSphere(ExtremeSphere(sphere)) } else { self };
                (shape, world_from_object)
            }
            Self::Triangle(Triangle { corners, .. }) => {
                let size = corners.iter().fold(0.0, |size: Real, corner| size.max(corner.max_abs()));
                if !is_unusual(size) {
                    return (self, world_from_object);
                }
                // Not so far that the inverse of the matrix overflows.
                let exponent = exponent(size).clamp(10 - Real::MAX_EXP, Real::MAX_EXP - 10);
                let own = Matrix4::scaling(Vector3::splat(1.0).scaled(exponent));
                let corners = corners.map(|corner| corner.scaled(-exponent));
                let matrix = world_from_object.map_or(own, |matrix| matrix * own);
                (Self::Triangle(Triangle::new(corners)), Some(matrix))
            }
            _ => (self, world_from_object),
        }
    }

    /// Returns the same shape, shaded with unit normals.
    #[must_use]
    pub fn with_unit_normal(self) -> Self {
        match self {
            Self::Plane(plane) => Self::Plane(plane.with_unit_normal()),
            shape => shape,
        }
    }
}
