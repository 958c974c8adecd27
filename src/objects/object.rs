//! [`Object`]: a shape with a transform and a material.

use super::triangle::{face_normal, nearest_point_of_triangle};
use super::{
    Aabb, Mesh, PreparedRay, Ray, Shape, Surface as _, SurfaceHit, SurfacePoint, Transform, match_surface,
};
use vecmath::{Real, UNIT_ROUNDOFF, Vector3};

/// An instance of a shape: the shape with a place in the world and a material.
#[derive(Clone, Debug)]
pub struct Object {
    pub shape: Shape,
    /// `None`: object space is world space.
    pub transform: Option<Box<Transform>>,
    /// Index into the scene's materials.
    pub material: u32,
    /// The box around the object in world space, always finite; `None` for a plane, and where it would overflow.
    pub bounds: Option<Aabb>,
    /// Error bound of taking a ray to object space: rounding may move the ray sideways by this share of its origin's
    /// largest coordinate. So a ray that passes [`bounds`](Self::bounds) within this distance counts as entering
    /// them. Zero without a transform, because tests of boxes allow for their own rounding. Zero for a sphere,
    /// because it shares no edge with a neighbour.
    pub sideways_error: Real,
}

/// Roundings by which a ray may move sideways: 4 u when it is taken to object space, 6 u in the test there. The unit
/// is the largest coordinate of the ray's origin, times the condition number of the transform.
const SIDEWAYS_ROUNDINGS: Real = 16.0;
/// Share of their largest coordinate by which world bounds are larger than the objects, so that later code need not
/// think of the rounding of bounds.
const BOUNDS_MARGIN: Real = 8192.0 * UNIT_ROUNDOFF;

/// Roundings of a hit's place without a transform, in units of the coordinates: 32 in the test of its triangle's box,
/// and a few of t and of the planes.
const HIT_ROUNDINGS: Real = 64.0;

impl Object {
    /// Makes an object of a shape. `bounds` is the box around the shape in object space; `None` if it is infinite.
    pub fn new(shape: Shape, transform: Option<Box<Transform>>, material: u32, bounds: Option<&Aabb>) -> Self {
        let bounds = bounds.map(|bounds| {
            let world = transform.as_ref().map_or(*bounds, |transform| transform.bounds_to_world(bounds));
            world.grown(world.max_abs() * BOUNDS_MARGIN)
        });
        // Bounds that overflow would not be the same box to every test of them.
        let bounds = bounds.filter(|bounds| bounds.min.is_finite() && bounds.max.is_finite());
        let sideways_error = match (&shape, &transform) {
            (Shape::Sphere(_), _) | (_, None) => 0.0,
            (_, Some(transform)) => SIDEWAYS_ROUNDINGS * UNIT_ROUNDOFF * transform.condition,
        };
        Self { shape, transform, material, bounds, sideways_error }
    }

    /// Finds the closest hit with t < `t_max`. `mesh` is called for a shape that is a mesh: it takes the mesh's index
    /// and the ray in object space, and returns the mesh's closest hit with t < `t_max`.
    ///
    /// By definition, only a ray that enters [`bounds`](Self::bounds) has a hit, and the hit is never nearer than the
    /// entry. So skipping objects by their bounds changes no hit.
    pub fn closest_hit(
        &self,
        world: &PreparedRay,
        t_max: Real,
        mesh: impl FnOnce(u32, &PreparedRay) -> Option<SurfaceHit>,
    ) -> Option<SurfaceHit> {
        let entry = self.entry(world, t_max)?;
        let mut hit = self.intersect(world, mesh)?;
        hit.t = hit.t.max(entry);
        (hit.t < t_max).then_some(hit)
    }

    /// Returns whether the object is hit at a t up to and including `t_max`. Here `mesh` returns any hit up to
    /// `t_max`.
    pub fn any_hit(
        &self,
        world: &PreparedRay,
        t_max: Real,
        mesh: impl FnOnce(u32, &PreparedRay) -> Option<SurfaceHit>,
    ) -> bool {
        self.entry(world, t_max).is_some() && self.intersect(world, mesh).is_some_and(|hit| hit.t <= t_max)
    }

    /// Intersects the ray with the shape, in object space.
    fn intersect(
        &self,
        world: &PreparedRay,
        mesh: impl FnOnce(u32, &PreparedRay) -> Option<SurfaceHit>,
    ) -> Option<SurfaceHit> {
        match_surface!(&self.shape,
            surface => surface.intersect(&self.ray_to_object(&world.ray)).map(SurfaceHit::at),
            Shape::Triangle(triangle) => triangle.intersect(&self.prepared_in_object_space(world)),
            Shape::Mesh(index) => mesh(*index, &self.prepared_in_object_space(world)),
        )
    }

    /// Returns the t at which the ray enters the bounds, if it is at most `t_max`; see [`Aabb::entry`].
    #[inline(always)]
    pub fn entry(&self, world: &PreparedRay, t_max: Real) -> Option<Real> {
        match &self.bounds {
            Some(bounds) => bounds.entry(world, self.margin(world), t_max),
            None => Some(0.0),
        }
    }

    /// Does the same without branches, for loops over many rays; see [`Aabb::entry_branchless`].
    #[inline(always)]
    pub fn entry_branchless(&self, world: &PreparedRay, t_max: Real) -> (bool, Real) {
        match &self.bounds {
            Some(bounds) if self.sideways_error == 0.0 => bounds.entry_branchless(world, 0.0, t_max),
            Some(bounds) => bounds.entry_branchless(world, self.margin(world), t_max),
            None => (true, 0.0),
        }
    }

    /// Returns whether every hit on a triangle certainly lies in the bounds, not before the entry, for rays whose origins
    /// have no coordinate beyond `reach`. Then the rule of [`closest_hit`](Self::closest_hit) changes no hit.
    ///
    /// A hit lies in the box of its triangle, up to rounding: of the ray's way to object space, which the sideways error
    /// bounds, of the test (twice that, in the same unit), and of t and the box's planes. [`HIT_ROUNDINGS`] are more.
    pub fn encloses_hits(&self, reach: Real) -> bool {
        self.bounds.as_ref().is_none_or(|bounds| {
            let size = bounds.max_abs();
            let rounding = (4.0 * self.sideways_error + HIT_ROUNDINGS * UNIT_ROUNDOFF) * (reach + size);
            rounding <= 0.5 * BOUNDS_MARGIN * size
        })
    }

    /// Returns by how much the bounds must grow for a ray.
    #[inline(always)]
    fn margin(&self, world: &PreparedRay) -> Real {
        if self.sideways_error == 0.0 { 0.0 } else { self.sideways_error * world.ray.origin.max_abs() }
    }

    fn ray_to_object(&self, world: &Ray) -> Ray {
        self.transform.as_ref().map_or(*world, |transform| transform.ray_to_object(world))
    }

    fn prepared_in_object_space(&self, world: &PreparedRay) -> PreparedRay {
        match &self.transform {
            None => *world,
            Some(transform) => PreparedRay::new(transform.ray_to_object(&world.ray)),
        }
    }

    /// Returns the normal at a hit. It is a unit vector, except on a plane without a transform, whose normal has the
    /// length that the file gives it.
    pub fn normal(&self, meshes: &[Mesh], ray: &Ray, hit: &SurfaceHit) -> Vector3 {
        let in_object_space = |ray: &Ray| {
            match_surface!(&self.shape,
                surface => surface.normal(ray.at(hit.t)),
                Shape::Triangle(triangle) => triangle.normal,
                Shape::Mesh(mesh) => meshes[*mesh as usize].normal(hit.triangle, hit.barycentric),
            )
        };
        match &self.transform {
            None => in_object_space(ray),
            Some(transform) => transform.normal_to_world(in_object_space(&transform.ray_to_object(ray))),
        }
    }

    /// Finds the point of the surface that a ray has hit, and its error bound.
    pub fn surface_point(&self, meshes: &[Mesh], ray: &Ray, hit: &SurfaceHit) -> SurfacePoint {
        let on_triangle = |corners: [Vector3; 3]| {
            // A triangle without area has no normal, so any direction will do: this one leads towards the eye.
            let normal = face_normal(corners);
            let normal = if normal == Vector3::ZERO { -ray.direction.normalized() } else { normal };
            nearest_point_of_triangle(corners, hit.barycentric, normal)
        };
        let find = |near: Vector3| {
            match_surface!(&self.shape,
                surface => surface.nearest_point(near),
                Shape::Triangle(triangle) => on_triangle(triangle.corners),
                Shape::Mesh(mesh) => on_triangle(meshes[*mesh as usize].corners(hit.triangle)),
            )
        };
        let near = ray.at(hit.t);
        match &self.transform {
            None => {
                let found = find(near);
                SurfacePoint { point: found.point, normal: found.normal, error_bound: found.error }
            }
            Some(transform) => transform.surface_point(near, find),
        }
    }
}
