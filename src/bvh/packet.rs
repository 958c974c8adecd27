//! Packet traversal: up to 64 rays that lie side by side, through a tree together.
//!
//! A node's boxes are first tested against a [`Shaft`] around all rays, eight boxes at once. What the shaft meets is
//! tested against the rays, eight rays at once. Where few rays are left, each goes on alone; rays that have no direction
//! in common go on as a [`stream`](super::stream). How rays share their work depends on their order. What they hit does
//! not: every leaf that a ray may hit is visited.

use super::culling_packet::{CullingPacket, intersect_box};
use super::leaf_visitor::{LeafVisitor, traverse_singly};
use super::node::{Bvh, Child};
use super::prefetch::prefetch_children;
use super::shaft::Shaft;
use super::stream::{self, Stream};
use crate::simd::{Simd, WIDTH, load, vectorize};
use fearless_simd::prelude::*;

/// So few rays of a packet are traversed one by one.
pub const FEW: u32 = 4;
/// Boxes that may be pending; where there is no room for more, the rays go on as a stream.
const STACK: usize = 96;

/// A box that is pending.
#[derive(Clone, Copy)]
struct Pending {
    /// Its node, and place there.
    node: u32,
    place: u32,
    /// The rays that have met the node.
    active: u64,
    /// How far along it is.
    near: f32,
    /// Whether the shaft stays within it, so that testing single rays would be in vain.
    is_within: bool,
}

impl Pending {
    const NONE: Self = Self { node: 0, place: 0, active: 0, near: 0.0, is_within: false };
}

/// Scratch of packet and stream traversals. A thread keeps it for its next packet.
pub struct TraversalScratch {
    pub packet: CullingPacket,
    pending: [Pending; STACK],
    /// Made for the first rays that need it.
    stream: Option<Box<Stream>>,
}

impl TraversalScratch {
    pub const EMPTY: Self = Self { packet: CullingPacket::EMPTY, pending: [Pending::NONE; STACK], stream: None };
}

impl<Leaf> Bvh<Leaf> {
    /// Has `visitor` visit every leaf whose box an active ray of `scratch.packet` may meet at a t up to its limit.
    pub fn traverse_packet<S: Simd>(
        &self,
        simd: S,
        active: u64,
        scratch: &mut TraversalScratch,
        visitor: &mut impl LeafVisitor<S>,
    ) {
        if active == 0 || self.nodes.is_empty() {
            return;
        }
        let TraversalScratch { packet, pending, stream } = scratch;
        let is_large = self.is_large();
        vectorize!(simd, {
            let shaft = Shaft::around(simd, packet, active);
            let mut height = 0;
            let mut current = Some((Child::node(0), active));
            loop {
                if let Some((child, active)) = current.take() {
                    if child.is_leaf() {
                        visitor.visit(simd, child.index(), active, shaft.as_ref(), packet);
                    } else if active.count_ones() <= FEW {
                        traverse_singly(simd, &self.nodes, child, active, packet, visitor);
                    } else if shaft.is_none() || height + WIDTH > STACK {
                        let stream = stream.get_or_insert_with(|| Box::new(Stream::EMPTY));
                        stream::traverse(simd, self, child, active, packet, stream, visitor);
                    } else if let Some(shaft) = &shaft {
                        let node = &self.nodes[child.index()];
                        let [a, b, c, d, e, f] = &node.planes;
                        let load = |plane| load(simd, plane);
                        let planes = [load(a), load(b), load(c), load(d), load(e), load(f)];
                        let (met, within, enter) = shaft.intersect(simd, &planes, packet.largest_limit(simd));
                        let mut distances = [0.0; WIDTH];
                        enter.store_array(&mut distances);
                        push(pending, &mut height, child.index() as u32, [met, within], active, &distances);
                        if is_large {
                            prefetch_children(&self.nodes, node, met, |leaf| visitor.prefetch(leaf));
                        }
                    }
                }
                if height == 0 {
                    return;
                }
                height -= 1;
                let Pending { node, place, mut active, near, is_within } = pending[height];
                let (node, place) = (&self.nodes[node as usize], place as usize % WIDTH);
                if !is_within {
                    active = intersect_box(
                        simd,
                        [&packet.inverse, &packet.origin_times_inverse],
                        &node.planes_of(place),
                        active,
                        #[inline(always)]
                        |group| load(simd, &packet.limit[group]),
                    );
                } else if shaft.as_ref().is_some_and(|shaft| near > shaft.end(packet.largest_limit(simd))) {
                    continue;
                }
                if active != 0 {
                    current = Some((node.children[place], active));
                }
            }
        });
    }
}

/// Pushes the boxes that are met, the farthest first.
#[inline(always)]
fn push(
    stack: &mut [Pending; STACK],
    height: &mut usize,
    node: u32,
    [mut met, within]: [u32; 2],
    active: u64,
    distances: &[f32; WIDTH],
) {
    let bottom = *height;
    while met != 0 {
        let place = met.trailing_zeros();
        met &= met - 1;
        let near = distances[place as usize % WIDTH];
        let next = Pending { node, place, active, near, is_within: within >> place & 1 == 1 };
        let mut at = *height;
        *height += 1;
        while at > bottom && stack[at - 1].near < next.near {
            stack[at] = stack[at - 1];
            at -= 1;
        }
        stack[at] = next;
    }
}
