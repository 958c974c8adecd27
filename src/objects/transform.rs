//! [`Transform`]: the matrices between world and object space, and the error bounds of going there and back.
//!
//! By definition, the surface of a transformed object is the set of world points that `object_from_world` takes to
//! the shape. That rounded matrix decides every hit; `world_from_object` only says where to look.

use super::surface_point::{NearestPoint, across};
use super::{Aabb, Ray, SurfacePoint};
use vecmath::{Matrix3, Matrix4, Real, SingularMatrix, UNIT_ROUNDOFF, Vector3};

/// The matrices between world space and the space of an object.
#[derive(Clone, Debug)]
pub struct Transform {
    pub object_from_world: Matrix4,
    world_from_object: Matrix4,
    /// Takes normals from object to world space: the transpose of the linear part of `object_from_world`.
    normal_to_world: Matrix3,
    /// Error bound: going to world space and back moves a point p of object space by at most `round_trip` |p| +
    /// `round_trip_offset`.
    round_trip: Matrix3,
    round_trip_offset: Vector3,
    /// Condition number: by how much a rounding error in object space grows on the way to world space. It is the
    /// largest row sum of |world_from_object| |object_from_world| (Bauer and Skeel; 1 for any scaling along the
    /// axes).
    pub condition: Real,
}

/// Roundings of a sum of three products and an offset, in units of the terms' absolute values.
const TRANSFORM_ROUNDINGS: Real = 4.0;
/// Roundings of a point that is taken to object space twice (4 u each), once to find its surface point and once when
/// a ray starts there, and that is rounded in world space (2 u).
const WORLD_POINT_ROUNDINGS: Real = 2.0 * TRANSFORM_ROUNDINGS + 2.0;
/// Roundings of a shape's own test, in units of the shape's coordinates; generous.
const SHAPE_ROUNDINGS: Real = 64.0;

impl Transform {
    /// Makes a transform of its matrix from object to world space.
    ///
    /// # Errors
    /// [`SingularMatrix`] if `world_from_object` has no inverse to working precision.
    pub fn new(world_from_object: &Matrix4) -> Result<Self, SingularMatrix> {
        let object_from_world = world_from_object.affine_inverse()?;
        let (back, there) = (object_from_world.linear(), world_from_object.linear());
        let [x, y, z] = (back * there).columns;
        let [i, j, k] = Matrix4::IDENTITY.linear().columns;
        let residual = Matrix3::from_columns(x - i, y - j, z - k).abs();
        let rounding = back.abs() * there.abs();
        let [r, s, t] = residual.columns;
        let [u, v, w] = rounding.columns.map(|column| column * (TRANSFORM_ROUNDINGS * UNIT_ROUNDOFF));
        let round_trip = Matrix3::from_columns(r + u, s + v, t + w);
        let offset = world_from_object.offset();
        let terms = back.abs() * offset.map(Real::abs) + object_from_world.offset().map(Real::abs);
        let round_trip_offset = object_from_world.transform_point(offset).map(Real::abs)
            + terms * (TRANSFORM_ROUNDINGS * UNIT_ROUNDOFF);
        // Up to here the true inverse of `object_from_world` is within a factor of 2 of `world_from_object`, by the
        // series of (1 + round_trip)^-1.
        if !(round_trip.row_sum_norm() < 0.5) {
            return Err(SingularMatrix);
        }
        Ok(Self {
            object_from_world,
            world_from_object: *world_from_object,
            normal_to_world: back.transposed(),
            round_trip,
            round_trip_offset,
            condition: (there.abs() * back.abs()).row_sum_norm(),
        })
    }

    /// Returns the matrix of which all others are computed.
    pub fn world_from_object(&self) -> &Matrix4 {
        &self.world_from_object
    }

    /// Takes a ray to object space. Its direction is not normalised, so that t means the same in both spaces.
    #[inline(always)]
    pub fn ray_to_object(&self, ray: &Ray) -> Ray {
        Ray {
            origin: self.object_from_world.transform_point(ray.origin),
            direction: self.object_from_world.transform_direction(ray.direction),
        }
    }

    /// Takes a normal to world space, as a unit vector.
    pub fn normal_to_world(&self, normal: Vector3) -> Vector3 {
        self.normal_direction_to_world(normal).normalized()
    }

    /// Takes a normal to world space without normalising it.
    #[inline(always)]
    pub fn normal_direction_to_world(&self, normal: Vector3) -> Vector3 {
        self.normal_to_world * normal
    }

    /// Returns the box in world space around all points that rays can hit on a shape inside `bounds`.
    ///
    /// Let a world point have the rounded image p in object space. It lies where `world_from_object` takes p, up to
    /// the error bound of a round trip and the roundings of p, both seen from world space.
    pub fn bounds_to_world(&self, bounds: &Aabb) -> Aabb {
        let world = bounds.transformed(&self.world_from_object);
        let (p, x) = (bounds.corner_reach(), world.corner_reach());
        let terms = self.object_from_world.linear().abs() * x + self.object_from_world.offset().map(Real::abs);
        let moved = self.round_trip * p
            + self.round_trip_offset
            + terms * (2.0 * TRANSFORM_ROUNDINGS * UNIT_ROUNDOFF)
            + p * (SHAPE_ROUNDINGS * UNIT_ROUNDOFF);
        let there = self.world_from_object.linear().abs();
        let rounding = there * p + self.world_from_object.offset().map(Real::abs);
        world.grown_by(there * moved * 2.0 + rounding * (TRANSFORM_ROUNDINGS * UNIT_ROUNDOFF))
    }

    /// Finds the surface point near a world point; `find` does so in object space.
    pub(super) fn surface_point(&self, near: Vector3, find: impl FnOnce(Vector3) -> NearestPoint) -> SurfacePoint {
        let image = self.object_from_world.transform_point(near);
        let found = find(image);
        // The step is short, so the errors of the matrix that transforms it are small twice over.
        let step = found.point - image;
        let point = near + self.world_from_object.transform_direction(step);
        let (normal, per_world_unit) = (self.normal_to_world * found.normal).direction_and_length();
        let terms = self.object_from_world.linear().abs() * point.map(Real::abs)
            + self.object_from_world.offset().map(Real::abs);
        let error = found.error
            + WORLD_POINT_ROUNDINGS * UNIT_ROUNDOFF * across(found.normal, terms)
            + across(found.normal, self.round_trip * step.map(Real::abs));
        SurfacePoint { point, normal, error_bound: error / per_world_unit }
    }
}
