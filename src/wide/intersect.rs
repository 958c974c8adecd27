//! Queries of a packet against the [`Geometry`]: [`Geometry::closest_hits`] and [`Geometry::any_hits`].
//!
//! They give each lane what [`Geometry::closest_hit`] and [`Geometry::any_hit`] give its ray.

use super::hit_packet::HitPacket;
use super::mesh::MeshQuery;
use super::triangle::TriangleHits;
use crate::bvh::{Bvh, CullingPacket, DONE, LeafVisitor, PacketBounds, Shaft, TraversalScratch};
use crate::objects::{Aabb, PreparedRay, Shape, Surface, Transform, match_surface};
use crate::scene::Geometry;
use crate::simd::packet::{PACKET, RayPacket, Scalars, lanes_in, span};
use crate::simd::{Simd, vectorize};
use vecmath::{Real, greater};

/// Scratch of queries. A tracer keeps one and lends it to every query. Each box is made by the first query that needs it,
/// because filling all that memory takes longer than rendering a small scene.
pub struct Scratch {
    bounds: PacketBounds,
    traversal: Option<Box<TraversalScratch>>,
    /// For queries of any hit: how far the rays still go.
    any: Option<Box<HitPacket>>,
    object: ObjectScratch,
}

/// Scratch of testing one object.
struct ObjectScratch {
    /// The rays in object space.
    rays: Option<Box<RayPacket>>,
    /// Where they meet the object.
    t: Scalars,
    mesh: Option<Box<MeshScratch>>,
}

/// Scratch of testing one mesh.
struct MeshScratch {
    hits: HitPacket,
    exact: TriangleHits,
    traversal: TraversalScratch,
}

impl MeshScratch {
    const EMPTY: Self =
        Self { hits: HitPacket::NONE, exact: TriangleHits::NONE, traversal: TraversalScratch::EMPTY };
}

impl Scratch {
    pub const EMPTY: Self = Self {
        bounds: PacketBounds::EMPTY,
        traversal: None,
        any: None,
        object: ObjectScratch { rays: None, t: [0.0; PACKET], mesh: None },
    };
}

impl Geometry {
    /// Finds the closest hits of the active rays. It is fastest for rays that lie side by side.
    pub fn closest_hits<S: Simd>(
        &self,
        simd: S,
        rays: &mut RayPacket,
        active: u64,
        scratch: &mut Scratch,
        hits: &mut HitPacket,
    ) {
        hits.clear();
        self.query::<S, false>(simd, rays, active, scratch, hits);
    }

    /// Returns the active rays that hit anything at a t up to and including their `t_max`.
    pub fn any_hits<S: Simd>(
        &self,
        simd: S,
        rays: &mut RayPacket,
        active: u64,
        scratch: &mut Scratch,
        t_max: &Scalars,
    ) -> u64 {
        let mut any = scratch.any.take().unwrap_or_else(|| Box::new(HitPacket::NONE));
        any.set_t_max(simd, active, t_max);
        let found = self.query::<S, true>(simd, rays, active, scratch, &mut any);
        scratch.any = Some(any);
        found
    }

    fn query<S: Simd, const ANY: bool>(
        &self,
        simd: S,
        rays: &mut RayPacket,
        active: u64,
        scratch: &mut Scratch,
        hits: &mut HitPacket,
    ) -> u64 {
        if active == 0 {
            return 0;
        }
        let Scratch { bounds, traversal, object, .. } = scratch;
        bounds.fill(simd, rays, active);
        let rays = QueryRays { packet: rays, active, is_prepared: false };
        let reach = bounds.origin_reach();
        let mut query = Query::<ANY> { geometry: self, rays, reach, scratch: object, hits, found: 0 };
        for &index in &self.object_tree.always {
            let object = &self.objects[index as usize];
            let mut open = active & !query.found;
            if let Some(object_bounds) = &object.bounds {
                open = bounds.intersect(simd, object_bounds, object.sideways_error, open);
            }
            query.test_object(simd, index, open);
        }
        if let Some(bvh) = &self.object_tree.bvh {
            let (around, error) = (bvh.space.bounds(), bvh.space.sideways_error());
            let open = bounds.intersect(simd, around, error, active & !query.found);
            let traversal = traversal.get_or_insert_with(|| Box::new(TraversalScratch::EMPTY));
            query.traverse(simd, bvh, open, traversal);
        }
        query.found
    }
}

/// A query for the closest hit, or with `ANY` for any hit. `hits.t` says how far each ray still goes; with `ANY`, minus
/// infinity where something is hit.
struct Query<'a, const ANY: bool> {
    geometry: &'a Geometry,
    rays: QueryRays<'a>,
    /// At least the largest coordinate of an origin.
    reach: Real,
    scratch: &'a mut ObjectScratch,
    hits: &'a mut HitPacket,
    /// With `ANY`, the lanes that have hit something: their query is answered.
    found: u64,
}

/// The rays of a query. Many packets meet no box, and need no reciprocals.
struct QueryRays<'a> {
    packet: &'a mut RayPacket,
    active: u64,
    is_prepared: bool,
}

impl QueryRays<'_> {
    fn prepared<S: Simd>(&mut self, simd: S) -> &RayPacket {
        if !self.is_prepared {
            self.packet.prepare(simd, self.active);
            self.is_prepared = true;
        }
        self.packet
    }
}

impl<const ANY: bool> Query<'_, ANY> {
    /// Tests the objects of a tree for the rays of a mask.
    fn traverse<S: Simd>(&mut self, simd: S, bvh: &Bvh<u32>, mask: u64, traversal: &mut TraversalScratch) {
        if mask == 0 {
            return;
        }
        let rays = self.rays.prepared(simd);
        let (entered, unbounded) = traversal.packet.enter(simd, &bvh.space, rays, mask, &self.hits.t);
        bvh.traverse_packet(simd, entered, traversal, &mut ObjectVisitor { objects: &bvh.leaves, query: self });
        for &index in &bvh.leaves {
            let open = unbounded & !self.found;
            if open == 0 {
                break;
            }
            self.test_object(simd, index, open);
        }
    }

    /// Tests one object for the rays of a mask.
    fn test_object<S: Simd>(&mut self, simd: S, index: u32, mask: u64) {
        if mask == 0 {
            return;
        }
        if mask.is_power_of_two() {
            return self.test_singly(simd, index, mask);
        }
        let geometry = self.geometry;
        let object = &geometry.objects[index as usize];
        match_surface!(&object.shape,
            surface => match &object.bounds {
                Some(_) if object.sideways_error != 0.0 => self.test_singly(simd, index, mask),
                bounds => self.test_surface(simd, surface, bounds.as_ref(), index, mask),
            },
            Shape::Triangle(_) => self.test_singly(simd, index, mask),
            Shape::Mesh(mesh) => self.test_mesh(simd, *mesh, index, mask),
        );
    }

    /// Tests an object for one ray after the other.
    fn test_singly<S: Simd>(&mut self, simd: S, index: u32, mask: u64) {
        for lane in lanes_in(mask) {
            let ray = PreparedRay::new(self.rays.packet.get(lane));
            if ANY {
                let is_hit = self.geometry.any_hit_of_object(simd, index, &ray, self.hits.t[lane], &());
                self.take_any(u64::from(is_hit) << lane);
            } else {
                let limit = self.hits.limit(lane, index);
                if let Some(hit) = self.geometry.closest_hit_of_object(simd, index, &ray, limit, &()) {
                    self.hits.object[lane] = index;
                    self.hits.set_surface(lane, hit);
                }
            }
        }
    }

    fn take_any(&mut self, found: u64) {
        for lane in lanes_in(found) {
            self.hits.t[lane] = Real::NEG_INFINITY;
        }
        self.found |= found;
    }

    /// Tests a shape that a formula describes.
    fn test_surface<S: Simd>(
        &mut self,
        simd: S,
        surface: &impl Surface,
        bounds: Option<&Aabb>,
        index: u32,
        mask: u64,
    ) {
        let ObjectScratch { rays: own_rays, t, .. } = &mut *self.scratch;
        let transform = self.geometry.objects[index as usize].transform.as_deref();
        let rays = match transform {
            None => &*self.rays.packet,
            Some(transform) => to_object_space(simd, transform, self.rays.packet, mask, own_rays),
        };
        intersect_surface(simd, surface, rays, mask, t);
        if let Some(bounds) = bounds {
            clip_to_bounds(simd, bounds, self.rays.prepared(simd), mask, &self.hits.t, t);
        }
        if ANY {
            let found = self.hits.reached(simd, mask, t);
            self.take_any(found);
        } else {
            self.hits.take_nearer(simd, index, mask, t);
        }
    }

    fn test_mesh<S: Simd>(&mut self, simd: S, mesh: u32, index: u32, mask: u64) {
        let object = &self.geometry.objects[index as usize];
        let ObjectScratch { rays: own_rays, mesh: scratch, .. } = &mut *self.scratch;
        let scratch = scratch.get_or_insert_with(|| Box::new(MeshScratch::EMPTY));
        let MeshScratch { hits: mesh_hits, exact, traversal } = &mut **scratch;
        if ANY {
            mesh_hits.t = self.hits.t;
        } else {
            self.hits.limits(simd, index, mask, &mut mesh_hits.t);
        }
        let rays = match &object.transform {
            None => self.rays.prepared(simd),
            Some(transform) => {
                let rays = to_object_space(simd, transform, self.rays.packet, mask, own_rays);
                rays.prepare(simd, mask);
                rays
            }
        };
        let (mesh, tree) = self.geometry.mesh_and_tree(mesh);
        let query = MeshQuery::<ANY> { mesh, tree, rays, active: mask, hits: mesh_hits, exact };
        let found = query.run(simd, traversal);
        if found == 0 {
            return;
        }
        if object.encloses_hits(self.reach) {
            if ANY {
                return self.take_any(found);
            }
            return self.hits.take_nearer_in_mesh(
                simd,
                index,
                found,
                mesh_hits,
                #[inline(always)]
                |_, _| (true, 0.0),
            );
        }
        let rays = self.rays.prepared(simd);
        if ANY {
            let found = self.hits.entering(simd, object, rays, found);
            return self.take_any(found);
        }
        self.hits.take_nearer_in_mesh(
            simd,
            index,
            found,
            mesh_hits,
            #[inline(always)]
            |lane, t_max| object.entry_branchless(&rays.get_prepared(lane), t_max),
        );
    }
}

/// Visits the leaves of the tree of objects.
struct ObjectVisitor<'a, 'b, const ANY: bool> {
    objects: &'a [u32],
    query: &'a mut Query<'b, ANY>,
}

impl<S: Simd, const ANY: bool> LeafVisitor<S> for ObjectVisitor<'_, '_, ANY> {
    #[inline(always)]
    fn visit(&mut self, simd: S, leaf: usize, active: u64, _: Option<&Shaft>, packet: &mut CullingPacket) {
        self.query.test_object(simd, self.objects[leaf], active);
        for lane in lanes_in(active) {
            if packet.limit(lane) > DONE {
                packet.set_t_max(lane, self.query.hits.t[lane]);
            }
        }
    }

    #[inline(always)]
    fn candidates(&self, _: S, _: usize, _: usize, _: &CullingPacket) -> u32 {
        1
    }

    #[inline(always)]
    fn test(&mut self, simd: S, leaf: usize, _: u32, lane: usize, packet: &mut CullingPacket) {
        self.visit(simd, leaf, 1 << lane, None, packet);
    }
}

/// Takes the active rays to object space. They are put into `scratch`.
fn to_object_space<'a, S: Simd>(
    simd: S,
    transform: &Transform,
    world: &RayPacket,
    active: u64,
    scratch: &'a mut Option<Box<RayPacket>>,
) -> &'a mut RayPacket {
    let rays = &mut **scratch.get_or_insert_with(|| Box::new(RayPacket::NONE));
    vectorize!(simd, {
        for lane in span(active) {
            rays.set(lane, transform.ray_to_object(&world.get(lane)));
        }
        rays
    })
}

/// Intersects the active rays with a surface; t is infinite where they miss it.
fn intersect_surface<S: Simd>(simd: S, surface: &impl Surface, rays: &RayPacket, active: u64, t: &mut Scalars) {
    vectorize!(simd, {
        for lane in span(active) {
            t[lane] = surface.intersect(&rays.get(lane)).unwrap_or(Real::INFINITY);
        }
    });
}

/// Makes hits count only where the rays enter the object's bounds, and no nearer than there.
fn clip_to_bounds<S: Simd>(
    simd: S,
    bounds: &Aabb,
    world: &RayPacket,
    active: u64,
    t_max: &Scalars,
    t: &mut Scalars,
) {
    vectorize!(simd, {
        for lane in span(active) {
            let (meets, entry) = bounds.entry_branchless(&world.get_prepared(lane), 0.0, t_max[lane]);
            t[lane] = if meets { greater(t[lane], entry) } else { Real::INFINITY };
        }
    });
}
