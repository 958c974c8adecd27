//! [`LeafVisitor`]: what packet and stream traversals do at the leaves, and how they go on with one ray.

use super::culling_packet::CullingPacket;
use super::node::{Child, Node};
use super::shaft::Shaft;
use super::single::{DONE, EMPTY_STACK, traverse_from};
use crate::simd::Simd;
use crate::simd::packet::lanes_in;

/// What is done at the leaves. Everything here is `#[inline(always)]`, because it uses lanes.
pub trait LeafVisitor<S: Simd> {
    /// Tests the items of a leaf for the active rays, and lowers their limits. If there is a shaft, it is around them all.
    fn visit(&mut self, simd: S, leaf: usize, active: u64, shaft: Option<&Shaft>, packet: &mut CullingPacket);

    /// Returns which of the up to eight items of a leaf one ray may hit.
    fn candidates(&self, simd: S, leaf: usize, lane: usize, packet: &CullingPacket) -> u32;

    /// Tests one item of a leaf for one ray, and lowers the ray's limit.
    fn test(&mut self, simd: S, leaf: usize, item: u32, lane: usize, packet: &mut CullingPacket);

    /// Prefetches a leaf, if that pays.
    #[inline(always)]
    fn prefetch(&self, _leaf: usize) {}

    /// Tests the items of a leaf for one ray, and lowers its limit.
    #[inline(always)]
    fn visit_single(&mut self, simd: S, leaf: usize, lane: usize, packet: &mut CullingPacket) {
        let mut candidates = self.candidates(simd, leaf, lane, packet);
        while candidates != 0 && packet.limit(lane) > DONE {
            self.test(simd, leaf, candidates.trailing_zeros(), lane, packet);
            candidates &= candidates - 1;
        }
    }
}

/// Traverses what is below a node for the active rays, one after the other.
#[inline(always)]
pub fn traverse_singly<S: Simd>(
    simd: S,
    nodes: &[Node],
    start: Child,
    active: u64,
    packet: &mut CullingPacket,
    visitor: &mut impl LeafVisitor<S>,
) {
    let mut stack = EMPTY_STACK;
    for lane in lanes_in(active) {
        let (ray, limit) = (packet.ray(lane), packet.limit(lane));
        traverse_from(
            simd,
            nodes,
            start,
            &ray,
            limit,
            &mut stack,
            &mut |_: &Node| {},
            #[inline(always)]
            |leaf, _| {
                visitor.visit_single(simd, leaf, lane, packet);
                packet.limit(lane)
            },
        );
    }
}
