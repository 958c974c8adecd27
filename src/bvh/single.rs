//! Single traversal: one ray through a tree, near leaves first.

use super::node::{Bvh, Child, Node};
use super::space::CullingRay;
use crate::simd::{Simd, WIDTH, bits_of, f32x8, load, splat, splat3, vectorize};
use fearless_simd::prelude::*;

/// A limit below every t: the query is answered.
pub const DONE: f32 = -1.0;

/// Pending boxes on the stack of a ray. Where it is full, the traversal calls itself.
const STACK: usize = 64;

/// Pending boxes: where the ray enters them, and what is in them.
pub type Stack = [(f32, Child); STACK];

pub const EMPTY_STACK: Stack = [(0.0, Child::NONE); STACK];

impl<Leaf> Bvh<Leaf> {
    /// Calls `visit` with every leaf that the ray may meet at a t up to `limit`. `visit` gets the limit, and returns the
    /// new one: lower after a hit, [`DONE`] to end the traversal. It must be `#[inline(always)]` if it uses lanes. `test`
    /// is told of each node whose boxes are tested.
    #[inline]
    pub fn traverse<S: Simd>(
        &self,
        simd: S,
        ray: &CullingRay,
        limit: f32,
        mut test: impl FnMut(&Node),
        mut visit: impl FnMut(&Leaf, f32) -> f32,
    ) {
        if !self.nodes.is_empty() {
            traverse_from(
                simd,
                &self.nodes,
                Child::node(0),
                ray,
                limit,
                &mut { EMPTY_STACK },
                &mut test,
                #[inline(always)]
                |leaf, limit| visit(&self.leaves[leaf], limit),
            );
        }
    }
}

/// Traverses what is below `start`, and returns the last limit. `visit` gets the leaf's index.
#[expect(clippy::too_many_arguments)]
pub fn traverse_from<S: Simd>(
    simd: S,
    nodes: &[Node],
    start: Child,
    ray: &CullingRay,
    limit: f32,
    stack: &mut Stack,
    test: &mut impl FnMut(&Node),
    mut visit: impl FnMut(usize, f32) -> f32,
) -> f32 {
    vectorize!(simd, {
        let lanes = RayLanes::new(simd, ray);
        let (mut limit, mut height, mut current) = (limit, 0, start);
        loop {
            if current.is_leaf() {
                limit = visit(current.index(), limit);
                if limit < 0.0 {
                    return limit;
                }
            } else {
                let node = &nodes[current.index()];
                test(node);
                let (mut met, near) = lanes.intersect(simd, node, limit);
                if met != 0 {
                    let first = met.trailing_zeros() as usize;
                    met &= met - 1;
                    current = node.children[first % WIDTH];
                    if met == 0 {
                        continue;
                    }
                    let mut distances = [0.0; WIDTH];
                    near.store_array(&mut distances);
                    if height + WIDTH <= STACK {
                        current = push_all_but_nearest(node, first, met, &distances, stack, &mut height);
                        continue;
                    }
                    let met = met | 1 << first;
                    limit = traverse_children(
                        simd,
                        nodes,
                        node,
                        met,
                        &distances,
                        ray,
                        limit,
                        test,
                        &mut |leaf, limit| {
                            simd.vectorize(
                                #[inline(always)]
                                || visit(leaf, limit),
                            )
                        },
                    );
                    if limit < 0.0 {
                        return limit;
                    }
                }
            }
            match pop(stack, &mut height, limit) {
                Some(child) => current = child,
                None => return limit,
            }
        }
    })
}

/// Pops boxes until one is within the limit.
#[inline(always)]
fn pop(stack: &Stack, height: &mut usize, limit: f32) -> Option<Child> {
    while *height > 0 {
        *height -= 1;
        let (near, child) = stack[*height];
        if near <= limit {
            return Some(child);
        }
    }
    None
}

/// Traverses the children of a node that are met, one by one: for want of room on the stack. `visit` is `dyn`, because
/// the traversals call each other.
#[expect(clippy::too_many_arguments)]
#[cold]
fn traverse_children<S: Simd>(
    simd: S,
    nodes: &[Node],
    node: &Node,
    mut met: u32,
    distances: &[f32; WIDTH],
    ray: &CullingRay,
    mut limit: f32,
    test: &mut dyn FnMut(&Node),
    visit: &mut dyn FnMut(usize, f32) -> f32,
) -> f32 {
    while met != 0 && limit >= 0.0 {
        let place = met.trailing_zeros() as usize % WIDTH;
        met &= met - 1;
        if distances[place] <= limit {
            let (start, stack) = (node.children[place], &mut { EMPTY_STACK });
            limit =
                traverse_from(simd, nodes, start, ray, limit, stack, &mut |node: &Node| test(node), &mut *visit);
        }
    }
    limit
}

/// A ray in registers, each number in all lanes.
struct RayLanes<S: Simd> {
    inverse: [f32x8<S>; 3],
    origin_times_inverse: [f32x8<S>; 3],
    /// Index of the lower or upper plane that the ray meets first, axis by axis.
    first: [usize; 3],
    /// Index of the other one.
    second: [usize; 3],
}

impl<S: Simd> RayLanes<S> {
    #[inline(always)]
    fn new(simd: S, ray: &CullingRay) -> Self {
        let first = |axis: usize| if ray.inverse[axis] < 0.0 { axis + 3 } else { axis };
        Self {
            inverse: splat3(simd, ray.inverse),
            origin_times_inverse: splat3(simd, ray.origin_times_inverse()),
            first: [first(0), first(1), first(2)],
            second: [3 - first(0), 5 - first(1), 7 - first(2)],
        }
    }

    /// Returns t of a plane of each of a node's boxes.
    #[inline(always)]
    fn planes(&self, simd: S, node: &Node, axis: usize, index: usize) -> f32x8<S> {
        load(simd, &node.planes[index % 6]).mul_sub(self.inverse[axis], self.origin_times_inverse[axis])
    }

    /// Intersects the ray with a node's eight boxes: which ones it meets at a t from 0 to `limit`, and where it enters.
    #[inline(always)]
    fn intersect(&self, simd: S, node: &Node, limit: f32) -> (u32, f32x8<S>) {
        let [x, y, z] = self.first;
        let near = self
            .planes(simd, node, 0, x)
            .max(self.planes(simd, node, 1, y))
            .max(self.planes(simd, node, 2, z).max(splat(simd, 0.0)));
        let [x, y, z] = self.second;
        let far = self
            .planes(simd, node, 0, x)
            .min(self.planes(simd, node, 1, y))
            .min(self.planes(simd, node, 2, z).min(splat(simd, limit)));
        (bits_of(near.simd_le(far)), near)
    }
}

/// Pushes all children that are met but the nearest, farthest first, and returns the nearest.
#[inline(always)]
fn push_all_but_nearest(
    node: &Node,
    first: usize,
    mut met: u32,
    distances: &[f32; WIDTH],
    stack: &mut Stack,
    height: &mut usize,
) -> Child {
    let mut nearest = (distances[first % WIDTH], node.children[first % WIDTH]);
    let bottom = *height;
    while met != 0 {
        let place = met.trailing_zeros() as usize % WIDTH;
        met &= met - 1;
        let mut next = (distances[place], node.children[place]);
        if next.0 < nearest.0 {
            std::mem::swap(&mut next, &mut nearest);
        }
        let mut at = *height;
        *height += 1;
        while at > bottom && stack[at - 1].0 < next.0 {
            stack[at] = stack[at - 1];
            at -= 1;
        }
        stack[at] = next;
    }
    nearest.1
}
