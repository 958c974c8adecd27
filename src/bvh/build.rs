//! Boxes in, [`Bvh`] out: builds a binary tree by the surface area heuristic ([`sah`]), and collapses it to the cheapest
//! tree of eight boxes a node ([`collapse`](super::collapse)).
//!
//! Subtrees are built and collapsed in parallel. The tree does not depend on the number of threads or on the instruction
//! set.

use super::collapse::{Binary, Costs, NO_COSTS, Tree, WHOLE_ALWAYS, cheapest_shares};
use super::item::{Enclosing, PARALLEL_ITEMS};
use super::node::Bvh;
use super::sah;
use super::space::CullingSpace;
use crate::simd::{InstructionSet, Simd, with_simd};
use rayon::prelude::*;

pub use super::item::Item;

/// Below this depth every split halves the number of items, so that no tree is deeper than about this + 31.
const SAH_DEPTH: usize = 64;

/// Builds a tree whose leaves hold at most `LEAF_ITEMS` items; `leaf` makes a leaf of the numbers of its items. Items
/// must be in `space`.
pub fn build<const LEAF_ITEMS: usize, Leaf: Send>(
    space: CullingSpace,
    mut items: Vec<Item>,
    leaf: impl Fn(&[u32]) -> Leaf + Sync,
) -> Bvh<Leaf> {
    if items.is_empty() {
        return Bvh { space, nodes: Vec::new(), leaves: Vec::new() };
    }
    let (tree, _) = with_simd!(InstructionSet::detected(), simd => {
        let enclosing = Enclosing::of(simd, &items);
        build_tree::<LEAF_ITEMS, _>(simd, &mut items, 0, &enclosing, 0)
    });
    let (nodes, leaves) = tree.collapsed();
    let numbers: Vec<u32> = items.par_iter().map(Item::number).collect();
    let leaf = |&(start, count): &(u32, u32)| leaf(&numbers[start as usize..(start + count) as usize]);
    let (leaves, ()) = rayon::join(|| leaves.par_iter().map(leaf).collect(), || drop((items, tree)));
    Bvh { space, nodes, leaves }
}

/// Builds the binary tree of a range of items, which starts at `start`; both sides of a long range in parallel.
fn build_tree<const LEAF_ITEMS: usize, S: Simd>(
    simd: S,
    items: &mut [Item],
    start: u32,
    enclosing: &Enclosing,
    depth: usize,
) -> (Tree, Costs) {
    if items.len() <= PARALLEL_ITEMS {
        let mut nodes = Vec::new();
        let costs = add_range::<LEAF_ITEMS, S>(simd, items, start, enclosing, depth, &mut nodes);
        return (Tree::Few(nodes), costs);
    }
    let (first, sides) = split::<LEAF_ITEMS, S>(simd, items, enclosing, depth);
    let (left, right) = items.split_at_mut(first);
    let (middle, depth) = (start + first as u32, depth + 1);
    let ((left, left_costs), (right, right_costs)) = rayon::join(
        || build_tree::<LEAF_ITEMS, S>(simd, left, start, &sides[0], depth),
        || build_tree::<LEAF_ITEMS, S>(simd, right, middle, &sides[1], depth),
    );
    let (costs, shares) = cheapest_shares(&[left_costs, right_costs], enclosing.boxes.half_area());
    let planes = enclosing.boxes.planes();
    (Tree::Many { planes, shares, children: Box::new([left, right]) }, costs)
}

/// Adds the binary tree of a range of items, which starts at `start`, to `nodes`.
fn add_range<const LEAF_ITEMS: usize, S: Simd>(
    simd: S,
    items: &mut [Item],
    start: u32,
    enclosing: &Enclosing,
    depth: usize,
    nodes: &mut Vec<Binary>,
) -> Costs {
    let (index, count) = (nodes.len(), items.len());
    let planes = enclosing.boxes.planes();
    nodes.push(Binary { planes, start, count: count as u32, second: 0, shares: WHOLE_ALWAYS });
    if count <= LEAF_ITEMS {
        return NO_COSTS;
    }
    let (first, sides) = split::<LEAF_ITEMS, S>(simd, items, enclosing, depth);
    let (left, right) = items.split_at_mut(first);
    let (middle, depth) = (start + first as u32, depth + 1);
    let left = add_range::<LEAF_ITEMS, S>(simd, left, start, &sides[0], depth, nodes);
    nodes[index].second = (nodes.len() - index) as u32;
    let right = add_range::<LEAF_ITEMS, S>(simd, right, middle, &sides[1], depth, nodes);
    let (costs, shares) = cheapest_shares(&[left, right], enclosing.boxes.half_area());
    nodes[index].shares = shares;
    costs
}

/// Sorts items into two parts. Returns the length of the first part and the boxes around each part.
fn split<const LEAF_ITEMS: usize, S: Simd>(
    simd: S,
    items: &mut [Item],
    enclosing: &Enclosing,
    depth: usize,
) -> (usize, [Enclosing; 2]) {
    if depth >= SAH_DEPTH {
        return sah::halve(simd, items);
    }
    // A leaf is tested as a whole, so the cost of items is the number of leaves that they need.
    sah::split(simd, items, enclosing, |count| count.div_ceil(LEAF_ITEMS as u32) as f32)
}
