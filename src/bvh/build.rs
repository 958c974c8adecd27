//! Boxes in, [`Bvh`] out: builds a binary tree by the surface area heuristic ([`sah`]), and collapses it to the cheapest
//! tree of eight boxes a node.
//!
//! The collapse is optimal for the whole tree: costs are computed from the leaves upwards (Ylitie, Karras, Laine:
//! Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, 2017, section 3). Subtrees are built in
//! parallel. The tree does not depend on the number of threads or on the instruction set.

use super::node::{Bvh, Child, Node};
use super::sah::{self, Enclosing, PARALLEL_ITEMS};
use super::space::{CullingSpace, Planes};
use crate::simd::{InstructionSet, Simd, WIDTH, with_simd};
use rayon::prelude::*;
use std::array::from_fn;

pub use super::sah::Item;

/// Below this depth every split halves the number of items, so that no tree is deeper than about this + 31.
const SAH_DEPTH: usize = 64;

/// Builds a tree whose leaves hold at most `LEAF_ITEMS` items; `leaf` makes a leaf of the numbers of its items. Items
/// must be in `space`.
pub fn build<const LEAF_ITEMS: usize, Leaf: Send>(
    space: CullingSpace,
    mut items: Vec<Item>,
    leaf: impl Fn(&[u32]) -> Leaf + Sync,
) -> Bvh<Leaf> {
    let mut collapse = Collapse { binary: Vec::new(), nodes: Vec::new(), leaves: Vec::new() };
    if !items.is_empty() {
        with_simd!(InstructionSet::detected(), simd => {
            let enclosing = Enclosing::of(simd, &items);
            build_range::<LEAF_ITEMS, _>(simd, &mut items, 0, &enclosing, 0, &mut collapse.binary);
        });
        collapse.add_node(0);
    }
    let Collapse { nodes, leaves, .. } = collapse;
    let numbers: Vec<u32> = items.par_iter().map(Item::number).collect();
    let leaf = |&(start, count): &(u32, u32)| leaf(&numbers[start as usize..(start + count) as usize]);
    let (leaves, ()) = rayon::join(|| leaves.par_iter().map(leaf).collect(), || drop(items));
    Bvh { space, nodes, leaves }
}

/// A node of the binary tree. Its first child is the next node.
struct Binary {
    planes: Planes,
    start: u32,
    count: u32,
    /// Distance from this node to its second child; 0 for a leaf.
    second: u32,
    /// For each number of boxes from 1 to 8, the cheapest division of the boxes between the children.
    shares: [Share; WIDTH],
}

/// Number of boxes for the first child and for the second, or [`WHOLE`].
type Share = (u8, u8);
/// One box for both children together.
const WHOLE: Share = (0, 0);

/// The least costs of a subtree of the binary tree if it becomes at most 1, 2, ... 7 boxes, in visits of nodes.
/// Leaves cost nothing, because they are visited in any case.
type Costs = [f32; WIDTH - 1];

/// Adds the binary tree of a range of items, which starts at `start`, to `nodes`.
fn build_range<const LEAF_ITEMS: usize, S: Simd>(
    simd: S,
    items: &mut [Item],
    start: u32,
    enclosing: &Enclosing,
    depth: usize,
    nodes: &mut Vec<Binary>,
) -> Costs {
    let (index, count) = (nodes.len(), items.len());
    let planes = enclosing.boxes.planes();
    nodes.push(Binary { planes, start, count: count as u32, second: 0, shares: [WHOLE; WIDTH] });
    if count <= LEAF_ITEMS {
        return [0.0; WIDTH - 1];
    }
    let (first, sides) = if depth < SAH_DEPTH {
        // A leaf is tested as a whole, so the cost of items is the number of leaves that they need.
        sah::split(simd, items, enclosing, |count| count.div_ceil(LEAF_ITEMS as u32) as f32)
    } else {
        sah::halve(simd, items)
    };
    let (left, right) = items.split_at_mut(first);
    let (middle, depth) = (start + first as u32, depth + 1);
    let costs = if count <= PARALLEL_ITEMS {
        let left = build_range::<LEAF_ITEMS, S>(simd, left, start, &sides[0], depth, nodes);
        nodes[index].second = (nodes.len() - index) as u32;
        [left, build_range::<LEAF_ITEMS, S>(simd, right, middle, &sides[1], depth, nodes)]
    } else {
        let mut below = Vec::new();
        let (left, right) = rayon::join(
            || build_range::<LEAF_ITEMS, S>(simd, left, start, &sides[0], depth, nodes),
            || build_range::<LEAF_ITEMS, S>(simd, right, middle, &sides[1], depth, &mut below),
        );
        nodes[index].second = (nodes.len() - index) as u32;
        nodes.append(&mut below);
        [left, right]
    };
    let (costs, shares) = cheapest_shares(&costs, enclosing.boxes.half_area());
    nodes[index].shares = shares;
    costs
}

/// Returns the costs of a node from the costs of its children, and the cheapest division of its boxes between them.
fn cheapest_shares([left, right]: &[Costs; 2], area: f32) -> (Costs, [Share; WIDTH]) {
    let mut shares = [WHOLE; WIDTH];
    let mut costs = [f32::INFINITY; WIDTH];
    for boxes in 2..=WIDTH {
        (costs[boxes - 1], shares[boxes - 1]) = (costs[boxes - 2], shares[boxes - 2]);
        for first in 1..boxes {
            let second = boxes - first;
            let cost = left[first - 1] + right[second - 1];
            if cost < costs[boxes - 1] {
                (costs[boxes - 1], shares[boxes - 1]) = (cost, (first as u8, second as u8));
            }
        }
    }
    let whole = costs[WIDTH - 1] + area;
    let costs = from_fn(|boxes| {
        if whole <= costs[boxes] {
            shares[boxes] = WHOLE;
        }
        whole.min(costs[boxes])
    });
    (costs, shares)
}

/// Collapses a binary tree to a tree of eight boxes a node.
struct Collapse {
    binary: Vec<Binary>,
    nodes: Vec<Node>,
    leaves: Vec<(u32, u32)>,
}

impl Collapse {
    /// Adds the wide node of a binary node, and all nodes below it.
    fn add_node(&mut self, of: usize) -> Child {
        let index = self.nodes.len();
        self.nodes.push(Node::EMPTY);
        let (mut boxes, mut used) = ([0; WIDTH], 0);
        self.collect_children(of, WIDTH, &mut boxes, &mut used);
        for (place, &inner) in boxes[..used].iter().enumerate() {
            let Binary { planes, start, count, second, .. } = self.binary[inner];
            let child = if second == 0 {
                self.leaves.push((start, count));
                Child::leaf(self.leaves.len() as u32 - 1)
            } else {
                self.add_node(inner)
            };
            self.nodes[index].set(place, &planes, child);
        }
        Child::node(index as u32)
    }

    /// Collects the roots of the at most `max_children` subtrees that become a node's children.
    fn collect_children(&self, of: usize, max_children: usize, found: &mut [usize; WIDTH], used: &mut usize) {
        let node = &self.binary[of];
        let (first, second) = node.shares[max_children - 1];
        if (first, second) == WHOLE {
            found[*used] = of;
            *used += 1;
        } else {
            self.collect_children(of + 1, first.into(), found, used);
            self.collect_children(of + node.second as usize, second.into(), found, used);
        }
    }
}
