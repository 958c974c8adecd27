//! What a ray can hit: the definition of a hit for every shape, in [`Real`](vecmath::Real), one ray at a time.
//!
//! This is the truth. Everything that is faster (`bvh`, `wide`) may only discard what these tests would discard too.
//! A ray is `origin + t * direction` with a direction of any length, and a hit has 0 < t < [`T_MAX`].
//!
//! A shape is one file here and one line in the list of [`object`]. This folder knows nothing of trees and packets.

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
pub(crate) use object::match_surface;
pub use object::{Object, Shape, Surface};
pub use plane::Plane;
pub use ray::{PreparedRay, Ray};
pub use sphere::Sphere;
pub use surface_point::SurfacePoint;
pub use transform::Transform;
pub(crate) use triangle::{Crossing, ShearAxes, box_interval};
pub use triangle::{Triangle, intersect_triangle};
