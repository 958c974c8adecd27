//! Queries of a packet against one mesh: its tree culls, the exact test of a triangle decides.

use super::hit_packet::{HitPacket, is_nearer};
use super::triangle::TriangleHits;
use crate::bvh::{Bvh, CullingPacket, DONE, FEW, GROUPS, LeafVisitor, Shaft, TraversalScratch, TriangleBlock};
use crate::objects::{Mesh, ShearAxes, SurfaceHit, intersect_triangle};
use crate::simd::packet::{RayPacket, has_lane, is_dense, lanes_in, span};
use crate::simd::{Simd, WIDTH, load, vectorize};
use vecmath::{Real, Vector3};

/// A query of the active rays against a mesh, in the mesh's space: for the closest hit, or with `ANY` for any hit.
///
/// `hits.t` says how far each ray goes: below t for the closest hit, up to and including t for any. The closest hits are
/// put into `hits`. With `ANY` nothing but `t` is changed: to minus infinity, where something is hit.
pub struct MeshQuery<'a, const ANY: bool> {
    pub mesh: &'a Mesh,
    pub tree: Option<&'a Bvh<TriangleBlock>>,
    /// Prepared.
    pub rays: &'a RayPacket,
    pub active: u64,
    pub hits: &'a mut HitPacket,
    pub exact: &'a mut TriangleHits,
}

impl<'a, const ANY: bool> MeshQuery<'a, ANY> {
    /// Returns the lanes that have hit anything.
    pub fn run<S: Simd>(self, simd: S, scratch: &mut TraversalScratch) -> u64 {
        let Self { mesh, tree, active, rays, .. } = self;
        let mut unbounded = active;
        let mut run = Run { query: self, by_shear_axis: None, found: 0 };
        if let Some(tree) = tree {
            let entered;
            (entered, unbounded) = scratch.packet.enter(simd, &tree.space, rays, active, &run.query.hits.t);
            let mut visitor = BlockVisitor { tree, center: tree.space.scaled_center(), run: &mut run };
            tree.traverse_packet(simd, entered, scratch, &mut visitor);
        }
        for lane in lanes_in(unbounded) {
            for triangle in 0..mesh.triangle_count() as u32 {
                if run.query.hits.t[lane] > Real::NEG_INFINITY {
                    run.test_single(lane, triangle, mesh.corners(triangle));
                }
            }
        }
        run.found
    }
}

/// A query and what is known so far.
struct Run<'a, const ANY: bool> {
    query: MeshQuery<'a, ANY>,
    /// The active lanes by the axis along which their rays are sheared, once somebody needs it.
    by_shear_axis: Option<[u64; 3]>,
    /// The lanes that have hit something.
    found: u64,
}

impl<const ANY: bool> Run<'_, ANY> {
    /// Tests a triangle for one ray, perhaps not for the first time.
    fn test_single(&mut self, lane: usize, triangle: u32, corners: [Vector3; 3]) {
        let Some(hit) = intersect_triangle(&self.query.rays.get_prepared(lane), corners) else { return };
        let hits = &mut *self.query.hits;
        if ANY {
            if hit.t <= hits.t[lane] {
                hits.t[lane] = Real::NEG_INFINITY;
                self.found |= 1 << lane;
            }
        } else {
            let comes_first = has_lane(self.found, lane) & (triangle < hits.triangle[lane]);
            if is_nearer(hit.t, hits.t[lane], comes_first) {
                self.found |= 1 << lane;
                hits.set_surface(lane, SurfaceHit { triangle, ..hit });
            }
        }
    }

    /// Tests a triangle for the rays of a mask.
    #[inline(always)]
    fn test_packet<S: Simd>(&mut self, simd: S, mask: u64, triangle: u32, corners: [Vector3; 3]) {
        for axis in 0..3 {
            let MeshQuery { rays, active, .. } = self.query;
            let here = mask & self.by_shear_axis.get_or_insert_with(|| by_shear_axis(simd, rays, active))[axis];
            if here == 0 {
                continue;
            }
            self.query.exact.intersect(&ShearAxes::along(axis), rays, here, corners);
            let verdict = &self.query.exact.verdict;
            let mut undecided = 0;
            for lane in span(here) {
                undecided |= u64::from(verdict[lane] < 0.0) << lane;
            }
            undecided &= here;
            let decided = here & !undecided;
            if decided != 0 {
                if ANY { self.take_any(decided) } else { self.take_nearer(decided, triangle) }
            }
            lanes_in(undecided).for_each(|lane| self.test_single(lane, triangle, corners));
        }
    }

    #[inline(always)]
    fn take_any(&mut self, mask: u64) {
        let (exact, hits) = (&*self.query.exact, &mut *self.query.hits);
        for lane in lanes_in(mask) {
            if exact.verdict[lane] > 0.0 && exact.t[lane] <= hits.t[lane] {
                hits.t[lane] = Real::NEG_INFINITY;
                self.found |= 1 << lane;
            }
        }
    }

    #[inline(always)]
    fn take_nearer(&mut self, mask: u64, triangle: u32) {
        let (exact, hits) = (&*self.query.exact, &mut *self.query.hits);
        let found_before = self.found;
        let mut taken = 0;
        for lane in span(mask) {
            let (new, old, before) = (exact.t[lane], hits.t[lane], hits.triangle[lane]);
            let comes_first = has_lane(found_before, lane) & (triangle < before);
            let takes = (exact.verdict[lane] > 0.0) & is_nearer(new, old, comes_first) & has_lane(mask, lane);
            taken |= u64::from(takes) << lane;
            hits.t[lane] = if takes { new } else { old };
            hits.triangle[lane] = if takes { triangle } else { before };
            for corner in 0..3 {
                let weight = &mut hits.barycentric.0[corner][lane];
                *weight = if takes { exact.barycentric[corner][lane] } else { *weight };
            }
        }
        self.found |= taken;
    }
}

/// Sorts the active lanes by the axis along which their rays are sheared.
fn by_shear_axis<S: Simd>(simd: S, rays: &RayPacket, active: u64) -> [u64; 3] {
    vectorize!(simd, {
        let mut axes = [0; 3];
        for lane in span(active) {
            let z = ShearAxes::of(rays.direction.get(lane)).z;
            for (axis, lanes) in axes.iter_mut().enumerate() {
                *lanes |= u64::from(z == axis) << lane;
            }
        }
        axes.map(|lanes| lanes & active)
    })
}

/// Visits the leaves of a mesh's tree.
struct BlockVisitor<'a, 'b, const ANY: bool> {
    tree: &'a Bvh<TriangleBlock>,
    /// See [`scaled_center`](crate::bvh::CullingSpace::scaled_center).
    center: [f32; 3],
    run: &'a mut Run<'b, ANY>,
}

impl<const ANY: bool> BlockVisitor<'_, '_, ANY> {
    #[inline(always)]
    fn corners(&self, block: &TriangleBlock, place: u32) -> [Vector3; 3] {
        let corners = block.exact_corners(&self.tree.space, place);
        corners.unwrap_or_else(|| self.run.query.mesh.corners(block.index(place)))
    }

    /// Culls all active rays against one triangle, and tests what is left over.
    #[inline(always)]
    fn visit_triangle<S: Simd>(
        &mut self,
        simd: S,
        block: &TriangleBlock,
        place: u32,
        active: u64,
        packet: &mut CullingPacket,
    ) {
        let mut candidates = 0;
        let triangle = block.splat_triangle(simd, self.center, place);
        for group in 0..GROUPS {
            let here = active >> (WIDTH * group) & 0xff;
            if here != 0 {
                let limit = load(simd, &packet.limit[group]);
                let bits = block.may_hit(simd, triangle, packet.load_group(simd, group), limit);
                candidates |= (here & u64::from(bits)) << (WIDTH * group);
            }
        }
        // Lanes between the candidates are tested too, to no purpose.
        if is_dense(candidates, 4) {
            self.run.test_packet(simd, candidates, block.index(place), self.corners(block, place));
            return packet.set_t_maxes(candidates, &self.run.query.hits.t);
        }
        for lane in lanes_in(candidates) {
            if packet.limit(lane) > DONE {
                self.run.test_single(lane, block.index(place), self.corners(block, place));
                packet.set_t_max(lane, self.run.query.hits.t[lane]);
            }
        }
    }
}

impl<S: Simd, const ANY: bool> LeafVisitor<S> for BlockVisitor<'_, '_, ANY> {
    #[inline(always)]
    fn visit(&mut self, simd: S, leaf: usize, active: u64, shaft: Option<&Shaft>, packet: &mut CullingPacket) {
        let block = &self.tree.leaves[leaf];
        let mut places = block.all();
        if let (Some(shaft), true) = (shaft, active.count_ones() > FEW) {
            (places, ..) = shaft.intersect(simd, &block.boxes(simd, self.center), packet.largest_limit(simd));
            places &= block.all();
            // Either all triangles for each ray, or all rays, in groups of eight, for each triangle: whichever is less.
            let groups = active | active >> 1 | active >> 2 | active >> 3;
            let groups = ((groups | groups >> 4) & 0x0101_0101_0101_0101).count_ones();
            if places.count_ones() * groups < active.count_ones() {
                while places != 0 {
                    self.visit_triangle(simd, block, places.trailing_zeros(), active, packet);
                    places &= places - 1;
                }
                return;
            }
        }
        if places != 0 {
            for lane in lanes_in(active) {
                self.visit_single(simd, leaf, lane, packet);
            }
        }
    }

    #[inline(always)]
    fn prefetch(&self, leaf: usize) {
        self.tree.leaves[leaf].prefetch();
    }

    #[inline(always)]
    fn candidates(&self, simd: S, leaf: usize, lane: usize, packet: &CullingPacket) -> u32 {
        let ray = packet.splat_ray(simd, lane);
        self.tree.leaves[leaf].candidates(simd, self.center, ray, packet.limit(lane))
    }

    #[inline(always)]
    fn test(&mut self, _: S, leaf: usize, item: u32, lane: usize, packet: &mut CullingPacket) {
        let block = &self.tree.leaves[leaf];
        self.run.test_single(lane, block.index(item), self.corners(block, item));
        packet.set_t_max(lane, self.run.query.hits.t[lane]);
    }
}
