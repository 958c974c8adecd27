//! What a ray can hit. `sphere`, `plane`, `triangle`, `mesh` and, for all of them, this file hold the definition of a hit,
//! in [`Real`] and scalar: the truth that every faster test may only prepare, never replace. `many`, `mesh_many` and
//! `normals` ask these definitions for the rays of a [`run`] at once.
//!
//! Everywhere, a ray is `origin + t * direction` with `direction` of any length, and a hit has 0 < t < [`T_MAX`].

mod aabb;
mod hit_run;
mod many;
mod mesh;
mod mesh_many;
mod normals;
mod placement;
mod plane;
mod ray;
pub mod run;
mod sphere;
mod surface;
mod triangle;

pub use aabb::Aabb;
pub use hit_run::{HitRun, SurfaceRun};
pub use mesh::{Mesh, MeshHit};
pub use placement::Placement;
pub use plane::Plane;
pub use ray::{PreparedRay, Ray};
pub use sphere::Sphere;
pub use surface::SurfacePoint;
pub use triangle::{Triangle, TriangleHit, TriangleHits, triangle_hit};

use crate::render::robust::ROUNDING;
use surface::triangle_point;
use triangle::face_normal;
use vecmath::{Real, Vector3};

/// Hits are nearer than this: the starter begins its search for the nearest hit at the largest `f32`.
pub const T_MAX: Real = f32::MAX as Real;

/// The geometry of an [`Object`].
#[derive(Clone, Debug)]
pub enum Shape {
    Sphere(Sphere),
    Plane(Plane),
    Triangle(Triangle),
    /// Index into the scene's meshes.
    Mesh(u32),
}

impl Shape {
    /// The bounds in object space; `None` for a shape without end.
    pub fn bounds(&self, meshes: &[Mesh]) -> Option<Aabb> {
        match self {
            Self::Sphere(sphere) => Some(sphere.bounds()),
            Self::Plane(_) => None,
            Self::Triangle(triangle) => Some(triangle.bounds()),
            Self::Mesh(mesh) => Some(*meshes[*mesh as usize].bounds()),
        }
    }

    /// Whether every normal that shading sees has length 1, up to rounding.
    pub fn has_unit_normal(&self) -> bool {
        match self {
            Self::Plane(plane) => (plane.shading_normal.length() - 1.0).abs() < 4.0 * Real::EPSILON,
            _ => true,
        }
    }

    /// The same shape, shaded with unit normals.
    #[must_use]
    pub fn with_unit_normal(self) -> Self {
        match self {
            Self::Plane(plane) => Self::Plane(plane.with_unit_normal()),
            shape => shape,
        }
    }
}

/// A surface with a place and a material.
#[derive(Clone, Debug)]
pub struct Object {
    pub shape: Shape,
    pub placement: Option<Box<Placement>>,
    /// Index into the scene's materials.
    pub material: u32,
    /// What encloses the object in world space; `None` for a plane, which nothing encloses.
    pub bounds: Option<Aabb>,
    /// Rounding on the way to object space may move a ray sideways by this share of its origin's largest coordinate;
    /// `bounds` count as met by a ray that passes them so closely. Zero where there is no such way, for boxes allow
    /// for their own rounding; and for a sphere, which has no edge to share with a neighbour.
    pub spread: Real,
}

/// Of the largest coordinate of a ray's origin, times the condition number of the placement: taking the ray to object
/// space (4 u) and the test there (6 u), seen from world space.
const SPREAD_ROUNDINGS: Real = 16.0;
/// World bounds are larger than the objects by this share of their largest coordinate at least, so that no later
/// rounding of bounds needs to be thought of.
const BOUNDS_MARGIN: Real = 8192.0 * ROUNDING;

/// Where a ray meets an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectHit {
    pub t: Real,
    /// Index of the triangle, for a mesh.
    pub triangle: u32,
    /// Weights of the triangle's corners at the hit, for a mesh or a triangle.
    pub barycentric: [Real; 3],
}

impl ObjectHit {
    pub fn at(t: Real) -> Self {
        Self { t, triangle: 0, barycentric: [0.0; 3] }
    }
}

impl Object {
    /// An object of a shape with these bounds (`None`: without end) in object space.
    pub fn new(shape: Shape, placement: Option<Box<Placement>>, material: u32, bounds: Option<&Aabb>) -> Self {
        let bounds = bounds.map(|bounds| {
            let world = placement.as_ref().map_or(*bounds, |placement| placement.bounds_to_world(bounds));
            world.grown(world.max_abs() * BOUNDS_MARGIN)
        });
        let spread = match (&shape, &placement) {
            (Shape::Sphere(_), _) | (_, None) => 0.0,
            (_, Some(placement)) => SPREAD_ROUNDINGS * ROUNDING * placement.condition,
        };
        Self { shape, placement, material, bounds, spread }
    }

    /// The nearest hit with t < `t_max`.
    ///
    /// A hit counts only where the ray meets [`bounds`](Self::bounds), and is never nearer than the place where it
    /// enters them. That is part of the definition: whoever skips objects by their bounds changes nothing.
    pub fn closest_hit(&self, meshes: &[Mesh], world: &PreparedRay, t_max: Real) -> Option<ObjectHit> {
        let near = self.entry(world, t_max)?;
        let mut hit = match &self.shape {
            Shape::Sphere(sphere) => sphere.hit(&self.ray_to_object(&world.ray)).map(ObjectHit::at),
            Shape::Plane(plane) => plane.hit(&self.ray_to_object(&world.ray)).map(ObjectHit::at),
            Shape::Triangle(triangle) => {
                let found = self.in_object_space(world, |ray| triangle.hit(ray));
                found.map(|hit| ObjectHit { t: hit.t, triangle: 0, barycentric: hit.barycentric })
            }
            Shape::Mesh(mesh) => {
                let found = self.in_object_space(world, |ray| meshes[*mesh as usize].closest_hit(ray, t_max));
                found.map(|found| ObjectHit {
                    t: found.hit.t,
                    triangle: found.triangle,
                    barycentric: found.hit.barycentric,
                })
            }
        }?;
        hit.t = hit.t.max(near);
        (hit.t < t_max).then_some(hit)
    }

    /// Whether anything is hit at a t up to and including `t_max`: the same answer as [`closest_hit`](Self::closest_hit)
    /// gives, sooner.
    pub fn any_hit(&self, meshes: &[Mesh], world: &PreparedRay, t_max: Real) -> bool {
        if self.entry(world, t_max).is_none() {
            return false;
        }
        let t = match &self.shape {
            Shape::Sphere(sphere) => sphere.hit(&self.ray_to_object(&world.ray)),
            Shape::Plane(plane) => plane.hit(&self.ray_to_object(&world.ray)),
            Shape::Triangle(triangle) => self.in_object_space(world, |ray| triangle.hit(ray)).map(|hit| hit.t),
            Shape::Mesh(mesh) => {
                return self.in_object_space(world, |ray| meshes[*mesh as usize].any_hit(ray, t_max));
            }
        };
        t.is_some_and(|t| t <= t_max)
    }

    /// See [`Aabb::entry`].
    #[inline(always)]
    fn entry(&self, world: &PreparedRay, t_max: Real) -> Option<Real> {
        match &self.bounds {
            Some(bounds) => bounds.entry(world, self.margin(world), t_max),
            None => Some(0.0),
        }
    }

    /// See [`Aabb::meets`].
    #[inline(always)]
    fn meets(&self, world: &PreparedRay, t_max: Real) -> (bool, Real) {
        match &self.bounds {
            Some(bounds) if self.spread == 0.0 => bounds.meets(world, 0.0, t_max),
            Some(bounds) => bounds.meets(world, self.margin(world), t_max),
            None => (true, 0.0),
        }
    }

    /// The bounds are grown by so much for a ray.
    #[inline(always)]
    fn margin(&self, world: &PreparedRay) -> Real {
        if self.spread == 0.0 { 0.0 } else { self.spread * world.ray.origin.max_abs() }
    }

    fn ray_to_object(&self, world: &Ray) -> Ray {
        self.placement.as_ref().map_or(*world, |placement| placement.ray_to_object(world))
    }

    fn in_object_space<T>(&self, world: &PreparedRay, f: impl FnOnce(&PreparedRay) -> T) -> T {
        match &self.placement {
            None => f(world),
            Some(placement) => f(&PreparedRay::new(placement.ray_to_object(&world.ray))),
        }
    }

    /// The unit normal at a hit, or what the file gave as the normal of a plane that stands in no transform.
    pub fn normal(&self, meshes: &[Mesh], ray: &Ray, hit: &ObjectHit) -> Vector3 {
        let in_object_space = |ray: &Ray| match &self.shape {
            Shape::Sphere(sphere) => sphere.normal(ray.at(hit.t)),
            Shape::Plane(plane) => plane.shading_normal,
            Shape::Triangle(triangle) => triangle.normal,
            Shape::Mesh(mesh) => meshes[*mesh as usize].normal(hit.triangle, hit.barycentric),
        };
        match &self.placement {
            None => in_object_space(ray),
            Some(placement) => placement.normal_to_world(in_object_space(&placement.ray_to_object(ray))),
        }
    }

    /// The point of the surface that a ray has hit, as well as it can be known.
    pub fn surface_point(&self, meshes: &[Mesh], ray: &Ray, hit: &ObjectHit) -> SurfacePoint {
        let on_triangle = |corners: [Vector3; 3]| {
            // Across a triangle without area there is no direction; towards the eye is as good as any.
            let normal = face_normal(corners);
            let normal = if normal == Vector3::ZERO { -ray.direction.normalized() } else { normal };
            triangle_point(corners, hit.barycentric, normal)
        };
        let find = |near: Vector3| match &self.shape {
            Shape::Sphere(sphere) => sphere.nearest_point(near),
            Shape::Plane(plane) => plane.nearest_point(near),
            Shape::Triangle(triangle) => on_triangle(triangle.corners),
            Shape::Mesh(mesh) => on_triangle(meshes[*mesh as usize].corners(hit.triangle)),
        };
        let near = ray.at(hit.t);
        match &self.placement {
            None => {
                let found = find(near);
                SurfacePoint { point: found.point, normal: found.normal, gap: found.error }
            }
            Some(placement) => placement.surface_point(near, find),
        }
    }
}
