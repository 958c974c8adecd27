//! What many rays hit of one object: the definitions of [`Object`], asked for the rays of a run at once.

use super::run::{Numbers, Prepare, PreparedRun, RUN, RayRun, Vectors, WorldRun, around, is_dense, numbers_in};
use super::{Aabb, Mesh, Object, ObjectHit, Placement, Plane, PreparedRay, Shape, Sphere, TriangleHits};
use super::{HitRun, SurfaceRun};
use crate::accel::kept::Kept;
use crate::accel::simd::{Lanes, Level, Task};
use vecmath::{Real, greater};

/// What a thread needs room for while it asks an object.
struct Scratch {
    /// Rays in object space.
    rays: RayRun,
    inverse_direction: Vectors,
    /// Places where rays meet a sphere or a plane.
    t: Numbers,
    in_mesh: SurfaceRun,
    triangle_hits: TriangleHits,
}

impl Default for Scratch {
    fn default() -> Self {
        let HitRun { at: in_mesh, .. } = HitRun::NONE;
        Self {
            rays: RayRun::NONE,
            inverse_direction: Vectors::ZERO,
            t: [0.0; RUN],
            in_mesh,
            triangle_hits: TriangleHits::NONE,
        }
    }
}

thread_local! {
    static SCRATCH: Kept<Scratch> = const { Kept::new(None) };
}

/// How an object is best asked about some rays.
enum Way<'a> {
    Mesh(&'a Mesh),
    Smooth(Smooth<'a>),
    OneByOne,
}

/// What is hit in a place that a formula gives.
#[derive(Clone, Copy)]
enum Smooth<'a> {
    Plane(&'a Plane),
    Sphere(&'a Sphere, &'a Aabb),
}

impl Object {
    fn way<'a>(&'a self, meshes: &'a [Mesh], mask: u64) -> Way<'a> {
        match (&self.shape, &self.bounds) {
            _ if mask.is_power_of_two() => Way::OneByOne,
            (Shape::Mesh(mesh), _) => Way::Mesh(&meshes[*mesh as usize]),
            (Shape::Plane(plane), None) => Way::Smooth(Smooth::Plane(plane)),
            (Shape::Sphere(sphere), Some(bounds)) if self.spread == 0.0 => {
                Way::Smooth(Smooth::Sphere(sphere, bounds))
            }
            _ => Way::OneByOne,
        }
    }

    /// Replaces the nearest hits of the rays of a mask where those of this object, which has this `index`, are nearer.
    pub fn closest_hits(
        &self,
        index: u32,
        meshes: &[Mesh],
        level: Level,
        world: &mut WorldRun,
        mask: u64,
        hits: &mut HitRun,
    ) {
        let mut scratch = SCRATCH.take().unwrap_or_default();
        let Scratch { rays, inverse_direction, t, in_mesh, triangle_hits } = &mut *scratch;
        match self.way(meshes, mask) {
            Way::Mesh(mesh) => {
                level.run(SetLimits { index, mask, hits, limits: &mut in_mesh.t });
                let rays = self.prepared(level, world, mask, rays, inverse_direction);
                let hit = mesh.closest_hits(rays, mask, triangle_hits, in_mesh);
                if is_dense(hit, 2) {
                    level.run(KeepNearestInMesh { object: self, index, world, mask: hit, in_mesh, hits });
                } else {
                    numbers_in(hit).for_each(|number| self.keep_nearest(index, world, number, in_mesh, hits));
                }
            }
            Way::Smooth(smooth) => {
                self.distances(smooth, level, world, mask, &hits.at.t, rays, t);
                level.run(KeepNearest { index, mask, t, hits });
            }
            Way::OneByOne => {
                for number in numbers_in(mask) {
                    let ray = PreparedRay::new(world.rays().get(number));
                    if let Some(hit) = self.closest_hit(meshes, &ray, hits.limit(number, index)) {
                        hits.object[number] = index;
                        hits.at.set(number, hit);
                    }
                }
            }
        }
        SCRATCH.set(Some(scratch));
    }

    /// Those rays of a mask that hit this object at a t up to and including their `t_max`.
    pub fn any_hits(
        &self,
        meshes: &[Mesh],
        level: Level,
        world: &mut WorldRun,
        mask: u64,
        t_max: &Numbers,
    ) -> u64 {
        let mut scratch = SCRATCH.take().unwrap_or_default();
        let Scratch { rays, inverse_direction, t, triangle_hits, .. } = &mut *scratch;
        let mut found = 0;
        match self.way(meshes, mask) {
            Way::Mesh(mesh) => {
                let rays = self.prepared(level, world, mask, rays, inverse_direction);
                let met = mesh.any_hits(rays, mask, triangle_hits, t_max);
                if met != 0 {
                    found = level.run(Entering { object: self, world, mask: met, t_max });
                }
            }
            Way::Smooth(smooth) => {
                self.distances(smooth, level, world, mask, t_max, rays, t);
                for number in numbers_in(mask) {
                    found |= u64::from(t[number] <= t_max[number]) << number;
                }
            }
            Way::OneByOne => {
                for number in numbers_in(mask) {
                    let ray = PreparedRay::new(world.rays().get(number));
                    found |= u64::from(self.any_hit(meshes, &ray, t_max[number])) << number;
                }
            }
        }
        SCRATCH.set(Some(scratch));
        found
    }

    /// Replaces the hit of a ray by a nearer one on this mesh.
    #[inline(always)]
    fn keep_nearest(&self, index: u32, world: &WorldRun, number: usize, in_mesh: &SurfaceRun, hits: &mut HitRun) {
        let limit = hits.limit(number, index);
        let Some(near) = self.entry(&world.get(number), limit) else { return };
        let hit = in_mesh.get(number);
        let t = greater(hit.t, near);
        if t < limit {
            hits.object[number] = index;
            hits.at.set(number, ObjectHit { t, ..hit });
        }
    }

    /// The rays of a mask in object space; `rays` and `inverse_direction` are room for them.
    fn prepared<'a>(
        &self,
        level: Level,
        world: &'a mut WorldRun,
        mask: u64,
        rays: &'a mut RayRun,
        inverse_direction: &'a mut Vectors,
    ) -> PreparedRun<'a> {
        let Some(placement) = &self.placement else { return world.prepared(level) };
        level.run(ToObject { placement, world: world.rays(), mask, rays });
        level.run(Prepare { rays, mask, inverse_direction });
        PreparedRun { rays, inverse_direction }
    }

    /// The places where rays of a mask meet a smooth shape, at a t up to and including `t_max` or not much beyond;
    /// infinite where they do not. `rays` is room for the rays in object space.
    #[expect(clippy::too_many_arguments)]
    fn distances(
        &self,
        smooth: Smooth,
        level: Level,
        world: &mut WorldRun,
        mask: u64,
        t_max: &Numbers,
        rays: &mut RayRun,
        t: &mut Numbers,
    ) {
        if let Some(placement) = &self.placement {
            level.run(ToObject { placement, world: world.rays(), mask, rays });
        }
        match smooth {
            Smooth::Plane(plane) => {
                let rays = if self.placement.is_some() { rays } else { world.rays() };
                level.run(PlaneHits { plane, rays, mask, t });
            }
            Smooth::Sphere(sphere, bounds) => {
                let world = world.prepared(level);
                let rays = if self.placement.is_some() { rays } else { world.rays };
                level.run(SphereHits { sphere, bounds, world, rays, mask, t_max, t });
            }
        }
    }
}

/// Takes the rays of a mask to object space.
struct ToObject<'a> {
    placement: &'a Placement,
    world: &'a RayRun,
    mask: u64,
    rays: &'a mut RayRun,
}

impl Task for ToObject<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        for number in around(self.mask) {
            self.rays.set(number, self.placement.ray_to_object(&self.world.get(number)));
        }
    }
}

/// Where rays meet a plane.
struct PlaneHits<'a> {
    plane: &'a Plane,
    rays: &'a RayRun,
    mask: u64,
    t: &'a mut Numbers,
}

impl Task for PlaneHits<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        for number in around(self.mask) {
            self.t[number] = self.plane.hit(&self.rays.get(number)).unwrap_or(Real::INFINITY);
        }
    }
}

/// Where rays meet a sphere.
struct SphereHits<'a> {
    sphere: &'a Sphere,
    bounds: &'a Aabb,
    world: PreparedRun<'a>,
    /// In object space.
    rays: &'a RayRun,
    mask: u64,
    t_max: &'a Numbers,
    t: &'a mut Numbers,
}

impl Task for SphereHits<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        for number in around(self.mask) {
            let (meets, near) = self.bounds.meets(&self.world.get(number), 0.0, self.t_max[number]);
            let t = self.sphere.hit(&self.rays.get(number)).unwrap_or(Real::INFINITY);
            self.t[number] = if meets { greater(t, near) } else { Real::INFINITY };
        }
    }
}

/// Replaces hits by nearer ones.
struct KeepNearest<'a> {
    index: u32,
    mask: u64,
    t: &'a Numbers,
    hits: &'a mut HitRun,
}

impl Task for KeepNearest<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { index, mask, t, hits } = self;
        for number in around(mask) {
            let (new, old, before) = (t[number], hits.at.t[number], hits.object[number]);
            let nearer = new < old || (new == old && index < before);
            let takes = nearer && mask >> number & 1 == 1;
            hits.at.t[number] = if takes { new } else { old };
            hits.object[number] = if takes { index } else { before };
        }
    }
}

/// Says below which t hits of an object count.
struct SetLimits<'a> {
    index: u32,
    mask: u64,
    hits: &'a HitRun,
    limits: &'a mut Numbers,
}

impl Task for SetLimits<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        for number in around(self.mask) {
            self.limits[number] = self.hits.limit(number, self.index);
        }
    }
}

/// Replaces hits by nearer ones on a mesh, of those rays that have one there.
struct KeepNearestInMesh<'a> {
    object: &'a Object,
    index: u32,
    world: &'a WorldRun<'a>,
    mask: u64,
    in_mesh: &'a SurfaceRun,
    hits: &'a mut HitRun,
}

impl Task for KeepNearestInMesh<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { object, index, world, mask, in_mesh, hits } = self;
        for number in around(mask) {
            let (old, before) = (hits.at.t[number], hits.object[number]);
            let (meets, near) = object.meets(&world.get(number), old);
            let new = greater(in_mesh.t[number], near);
            let is_nearer = (new < old) | ((new == old) & (index < before));
            let takes = meets & is_nearer & (mask >> number & 1 == 1);
            hits.at.t[number] = if takes { new } else { old };
            hits.object[number] = if takes { index } else { before };
            let (triangle, kept) = (in_mesh.triangle[number], hits.at.triangle[number]);
            hits.at.triangle[number] = if takes { triangle } else { kept };
            let (weights, kept) = (in_mesh.barycentric.get(number), hits.at.barycentric.get(number));
            hits.at.barycentric.set(number, if takes { weights } else { kept });
        }
    }
}

/// Tells those rays of a mask that meet the bounds of an object within their `t_max`.
struct Entering<'a> {
    object: &'a Object,
    world: &'a WorldRun<'a>,
    mask: u64,
    t_max: &'a Numbers,
}

impl Task for Entering<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> u64 {
        let mut met = 0;
        for number in around(self.mask) {
            let (meets, _) = self.object.meets(&self.world.get(number), self.t_max[number]);
            met |= u64::from(meets) << number;
        }
        met & self.mask
    }
}
