//! Stream traversal: rays that have nothing in common, through a tree step by step, all of them at each step.
//!
//! A ray that is traversed alone branches at every box on what it meets, and the processor mispredicts most of these
//! branches. Here one step is done for all rays before the next one begins, without a branch on what a ray meets: each
//! ray has its pending boxes on a stack of its own, and lanes are written where they may be needed and counted if they
//! are. Every leaf that a ray may hit is visited, as in the other traversals.

use super::culling_packet::CullingPacket;
use super::leaf_visitor::{LeafVisitor, traverse_singly};
use super::node::{Bvh, Child, Node};
use super::prefetch::prefetch;
use super::single::DONE;
use crate::simd::packet::{PACKET, lanes_in};
use crate::simd::{
    Simd, WIDTH, bits_of, compress, compress_u32, f32x8, load, mask32x8, places_in, splat, vectorize,
};
use fearless_simd::prelude::*;
use std::hint::select_unpredictable;

/// Entries of a ray's stack. Where there is no room for eight more, the ray traverses a node alone.
const DEPTH: usize = 32;

/// What is pending for the rays of a packet.
pub struct Stream {
    /// For each ray, where it enters its pending boxes, and what is in them. The first entry stands for none.
    near: [[f32; DEPTH]; PACKET],
    child: [[u32; DEPTH]; PACKET],
    /// Pending boxes of each ray.
    height: [u32; PACKET],
    nodes: List,
    leaves: List,
    /// Items of leaves to be tested: for each its place in the leaf, and the place of the leaf in the list of leaves.
    item: [u8; PACKET * WIDTH],
    leaf: [u8; PACKET * WIDTH],
}

/// Rays, each with the node or the leaf that it visits next.
struct List {
    rays: [(u32, u32); PACKET],
    count: usize,
}

impl List {
    const EMPTY: Self = Self { rays: [(0, 0); PACKET], count: 0 };

    /// Adds a ray if `is_added`, without a branch.
    #[inline(always)]
    fn add_if(&mut self, is_added: bool, lane: usize, child: Child) {
        self.rays[self.count % PACKET] = (lane as u32, child.bits());
        self.count += usize::from(is_added);
    }

    #[inline(always)]
    fn get(&self, index: usize) -> (usize, Child) {
        let (ray, child) = self.rays[index % PACKET];
        (ray as usize % PACKET, Child::of_bits(child))
    }

    /// Empties the list and returns its length. [`get`](Self::get) still returns what was in it until as much is added.
    #[inline(always)]
    fn drain(&mut self) -> usize {
        std::mem::take(&mut self.count)
    }
}

impl Stream {
    pub const EMPTY: Self = Self {
        near: [[f32::NEG_INFINITY; DEPTH]; PACKET],
        child: [[u32::MAX; DEPTH]; PACKET],
        height: [0; PACKET],
        nodes: List::EMPTY,
        leaves: List::EMPTY,
        item: [0; PACKET * WIDTH],
        leaf: [0; PACKET * WIDTH],
    };

    /// Prefetches what is visited next; leaves by `prefetch_leaf`.
    #[inline(never)]
    fn prefetch_scheduled(&self, nodes: &[Node], prefetch_leaf: impl Fn(usize)) {
        for list in [&self.nodes, &self.leaves] {
            (0..list.count).for_each(|index| prefetch(nodes, list.get(index).1, &prefetch_leaf));
        }
    }

    /// Puts a ray on the list of what it visits next: `child`, entered at `near`, or what is pending if that is beyond
    /// the limit.
    #[inline(always)]
    fn schedule(&mut self, lane: usize, mut near: f32, mut child: u32, limit: f32) {
        let mut height = self.height[lane] as usize % DEPTH;
        while near > limit {
            (near, child) = (self.near[lane][height], self.child[lane][height]);
            height = height.saturating_sub(1);
        }
        self.height[lane] = height as u32;
        let child = Child::of_bits(child);
        let (is_some, is_leaf) = (child != Child::NONE, child.is_leaf());
        self.nodes.add_if(is_some & !is_leaf, lane, child);
        self.leaves.add_if(is_some & is_leaf, lane, child);
    }

    /// Intersects a ray with a node's eight boxes, pushes those that are met, and schedules the nearest. Returns false,
    /// having done nothing, if the ray's stack might overflow.
    #[inline(always)]
    fn visit_node<S: Simd>(&mut self, simd: S, node: &Node, lane: usize, packet: &CullingPacket) -> bool {
        let (is_met, near) = intersect_boxes(simd, packet, node, lane);
        let met = bits_of(is_met);
        let nearest = is_met.select(near, splat(simd, f32::INFINITY)).reduce_min();
        let first = (met & bits_of(near.simd_le(splat(simd, nearest)))).trailing_zeros() as usize % WIDTH;

        let height = self.height[lane] as usize % DEPTH;
        let pending = (self.near[lane][height], self.child[lane][height]);
        let room =
            (self.near[lane][height + 1..].first_chunk_mut(), self.child[lane][height + 1..].first_chunk_mut());
        let (Some(near_room), Some(child_room)) = room else { return false };
        compress(is_met, near, near_room);
        compress_u32(simd, is_met, &node.children.map(Child::bits), child_room);
        // The last one takes the place of the nearest, which is not pending.
        let place = (met & ((1 << first) - 1)).count_ones() as usize % WIDTH;
        let last = (met.count_ones() as usize).saturating_sub(1) % WIDTH;
        (near_room[place], child_room[place]) = (near_room[last], child_room[last]);

        let (left, more) = (height.saturating_sub(1), height + last);
        let is_any = met != 0;
        self.height[lane] = select_unpredictable(is_any, more, left) as u32;
        let near = f32::from_bits(select_unpredictable(is_any, nearest.to_bits(), pending.0.to_bits()));
        let child = select_unpredictable(is_any, node.children[first].bits(), pending.1);
        self.schedule(lane, near, child, packet.limit(lane));
        true
    }

    /// Drops pending boxes beyond a limit, unless there are many: [`schedule`](Self::schedule) drops these one by one.
    #[inline(always)]
    fn drop_beyond<S: Simd>(&mut self, simd: S, lane: usize, limit: f32) {
        let height = self.height[lane] as usize;
        let pending = (self.near[lane][1..].first_chunk_mut(), self.child[lane][1..].first_chunk_mut());
        if let (Some(nears), Some(children), 0..=WIDTH) = (pending.0, pending.1, height) {
            let near = load(simd, nears);
            let is_within = near.simd_le(splat(simd, limit));
            compress(is_within, near, nears);
            compress_u32(simd, is_within, &{ *children }, children);
            // What lies above the height is not pending, and stays behind what is.
            self.height[lane] = (bits_of(is_within) & ((1 << height) - 1)).count_ones();
        }
    }

    /// Tests the leaves of the list for their rays, and returns how many there were.
    #[inline(always)]
    fn visit_leaves<S: Simd>(
        &mut self,
        simd: S,
        packet: &mut CullingPacket,
        visitor: &mut impl LeafVisitor<S>,
    ) -> usize {
        let (count, mut items) = (self.leaves.drain(), 0);
        for index in 0..count {
            let (lane, child) = self.leaves.get(index);
            let candidates = visitor.candidates(simd, child.index(), lane, packet);
            self.item[items..items + WIDTH].copy_from_slice(&places_in(candidates));
            self.leaf[items..items + WIDTH].copy_from_slice(&[index as u8; WIDTH]);
            items += candidates.count_ones() as usize;
        }
        for item in 0..items {
            let (lane, child) = self.leaves.get(self.leaf[item].into());
            if packet.limit(lane) > DONE {
                visitor.test(simd, child.index(), self.item[item].into(), lane, packet);
                self.drop_beyond(simd, lane, packet.limit(lane));
            }
        }
        count
    }
}

/// Intersects one ray with a node's eight boxes: which ones it meets at a t up to its limit, and where it enters.
#[inline(always)]
fn intersect_boxes<S: Simd>(simd: S, packet: &CullingPacket, node: &Node, lane: usize) -> (mask32x8<S>, f32x8<S>) {
    let (mut near, mut far) = (splat(simd, 0.0), splat(simd, packet.limit(lane)));
    for axis in 0..3 {
        let inverse = splat(simd, packet.inverse[axis].as_flattened()[lane]);
        let product = splat(simd, packet.origin_times_inverse[axis].as_flattened()[lane]);
        let lower = load(simd, &node.planes[axis]).mul_sub(inverse, product);
        let upper = load(simd, &node.planes[axis + 3]).mul_sub(inverse, product);
        near = near.max(lower.min(upper));
        far = far.min(lower.max(upper));
    }
    (near.simd_le(far), near)
}

/// Has `visitor` test every leaf below `start` whose box an active ray may meet at a t up to its limit.
pub fn traverse<S: Simd, Leaf>(
    simd: S,
    tree: &Bvh<Leaf>,
    start: Child,
    active: u64,
    packet: &mut CullingPacket,
    stream: &mut Stream,
    visitor: &mut impl LeafVisitor<S>,
) {
    let (nodes, is_large) = (&tree.nodes, tree.is_large());
    vectorize!(simd, {
        for lane in lanes_in(active) {
            stream.height[lane] = 0;
            stream.schedule(lane, 0.0, start.bits(), packet.limit(lane));
        }
        while stream.nodes.count + stream.leaves.count != 0 {
            if is_large {
                stream.prefetch_scheduled(nodes, |leaf| visitor.prefetch(leaf));
            }
            for index in 0..stream.nodes.drain() {
                let (lane, child) = stream.nodes.get(index);
                if !stream.visit_node(simd, &nodes[child.index()], lane, packet) {
                    traverse_singly(simd, nodes, child, 1 << lane, packet, visitor);
                    stream.schedule(lane, f32::INFINITY, 0, packet.limit(lane));
                }
            }
            for index in 0..stream.visit_leaves(simd, packet, visitor) {
                let (lane, _) = stream.leaves.get(index);
                stream.schedule(lane, f32::INFINITY, 0, packet.limit(lane));
            }
        }
    });
}
