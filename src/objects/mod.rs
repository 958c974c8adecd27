//! What a ray can hit. Each file holds one object's definition of a hit, in [`Real`] and scalar: the truth that every
//! faster test may only prepare, never replace.
//!
//! Everywhere, a ray is `origin + t * direction` with `direction` of any length, and a hit has 0 < t < [`T_MAX`].

mod aabb;
mod mesh;
mod placement;
mod plane;
mod ray;
mod sphere;
mod surface;
mod triangle;

pub use aabb::Aabb;
pub use mesh::{Mesh, MeshHit, MeshSearch};
pub use placement::Placement;
pub use plane::Plane;
pub use ray::{PreparedRay, Ray, ShearedRay};
pub use sphere::Sphere;
pub use surface::SurfacePoint;
pub use triangle::{Triangle, TriangleHit, triangle_hit};

use crate::accel::beam::{BEAM_RAYS, numbers_in};
use crate::accel::kept::Kept;
use crate::render::robust::ROUNDING;
use surface::triangle_point;
use triangle::face_normal;
use vecmath::{Real, Vector3};

/// Hits are nearer than this: the starter begins its search for the nearest hit at the largest `f32`.
pub const T_MAX: Real = f32::MAX as Real;

thread_local! {
    static OBJECT_RAYS: Kept<[PreparedRay; BEAM_RAYS]> = const { Kept::new(None) };
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

    /// [`closest_hit`](Self::closest_hit) of those of at most 64 rays that are in `mask`, for an object that is `mesh`.
    /// `found` is told about every hit with t below the ray's `t_max`.
    pub fn closest_mesh_hits(
        &self,
        mesh: &Mesh,
        world: &[PreparedRay],
        mask: u64,
        t_max: &[Real; BEAM_RAYS],
        mut found: impl FnMut(usize, ObjectHit),
    ) {
        let mut near = [0.0; BEAM_RAYS];
        let mut met = 0;
        for number in numbers_in(mask) {
            if let Some(entry) = self.entry(&world[number], t_max[number]) {
                near[number] = entry;
                met |= 1 << number;
            }
        }
        if met == 0 {
            return;
        }
        let mut searches = t_max.map(|t_max| MeshSearch { t_max, closest: None });
        self.many_in_object_space(world, met, &near, |rays, near| {
            mesh.closest_hits(rays, met, near, t_max, &mut searches);
        });
        for number in numbers_in(met) {
            let Some(MeshHit { triangle, hit }) = searches[number].closest else { continue };
            let t = hit.t.max(near[number]);
            if t < t_max[number] {
                found(number, ObjectHit { t, triangle, barycentric: hit.barycentric });
            }
        }
    }

    /// [`any_hit`](Self::any_hit) of those of at most 64 rays that are in `mask`, for an object that is `mesh`; as a
    /// mask.
    pub fn any_mesh_hits(&self, mesh: &Mesh, world: &[PreparedRay], mask: u64, t_max: &[Real]) -> u64 {
        let mut near = [0.0; BEAM_RAYS];
        let (mut met, mut found) = (0, 0);
        for number in numbers_in(mask) {
            if let Some(entry) = self.entry(&world[number], t_max[number]) {
                near[number] = entry;
                met |= 1 << number;
            }
        }
        if met != 0 {
            self.many_in_object_space(world, met, &near, |rays, near| {
                found = mesh.any_hits(rays, met, near, t_max);
            });
        }
        found
    }

    /// Hands over the rays of a mask in object space, and `near` if it holds there as well.
    fn many_in_object_space(
        &self,
        world: &[PreparedRay],
        mask: u64,
        near: &[Real; BEAM_RAYS],
        f: impl FnOnce(&[PreparedRay], Option<&[Real; BEAM_RAYS]>),
    ) {
        let Some(placement) = &self.placement else {
            return f(world, Some(near));
        };
        let mut rays = OBJECT_RAYS.take().unwrap_or_else(|| Box::new([PreparedRay::NONE; BEAM_RAYS]));
        for number in numbers_in(mask) {
            rays[number] = PreparedRay::new(placement.ray_to_object(&world[number].ray));
        }
        f(&*rays, None);
        OBJECT_RAYS.set(Some(rays));
    }

    fn entry(&self, world: &PreparedRay, t_max: Real) -> Option<Real> {
        match &self.bounds {
            Some(bounds) if self.spread == 0.0 => bounds.entry(world, 0.0, t_max),
            Some(bounds) => bounds.entry(world, self.spread * world.ray.origin.max_abs(), t_max),
            None => Some(0.0),
        }
    }

    fn ray_to_object(&self, world: &Ray) -> Ray {
        self.placement.as_ref().map_or(*world, |placement| placement.ray_to_object(world))
    }

    /// Of those of at most 64 rays that are in `mask`, tells `found` the hits of an object that is a plane, with t below
    /// [`T_MAX`]. A plane has no bounds, so rays need no preparation.
    pub fn plane_hits(&self, plane: &Plane, world: &[Ray], mask: u64, mut found: impl FnMut(usize, Real)) {
        for number in numbers_in(mask) {
            if let Some(t) = plane.hit(&self.ray_to_object(&world[number])).filter(|&t| t < T_MAX) {
                found(number, t);
            }
        }
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
