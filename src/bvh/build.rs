//! Boxes in, [`Tree`] out: a binary tree by [`split`], and the cheapest tree of eight boxes a node that can be made
//! from it.
//!
//! Which nodes of the binary tree remain is decided from the leaves upwards for all at once (Ylitie, Karras, Laine:
//! Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, 2017, section 3). Subtrees are built in
//! parallel; the tree does not depend on how many threads there are.

use super::frame::Planes;
use super::simd::WIDTH;
use super::split::{self, Around, Item, PARALLEL_ITEMS};
use super::tree::{Child, Node, Tree};
use rayon::prelude::*;
use std::array::from_fn;

/// Below this depth ranges are halved by number alone, so that no tree is deeper than about this + 31.
const SAH_DEPTH: usize = 64;

/// A tree and what its leaves hold.
pub struct Built {
    pub tree: Tree,
    /// A leaf's first place in `numbers`, and how many items it has.
    pub leaves: Vec<(u32, u32)>,
    /// Item numbers in the order of the leaves' places.
    pub numbers: Vec<u32>,
}

/// Builds a tree whose leaves hold at most `LEAF_ITEMS` items.
pub fn build<const LEAF_ITEMS: usize>(mut items: Vec<Item>) -> Built {
    let mut collapse = Collapse { binary: Vec::new(), nodes: Vec::new(), leaves: Vec::new() };
    if !items.is_empty() {
        let around = Around::of(&items);
        part::<LEAF_ITEMS>(&mut items, 0, &around, 0, &mut collapse.binary);
        collapse.node(0);
    }
    let Collapse { nodes, leaves, .. } = collapse;
    Built { tree: Tree { nodes }, leaves, numbers: items.par_iter().map(Item::number).collect() }
}

/// A node of the binary tree. Its first child is the next node.
struct Binary {
    planes: Planes,
    start: u32,
    count: u32,
    /// How many nodes further its second child is; 0 for a leaf.
    second: u32,
    /// How up to 1, 2, ... 8 boxes around its items are best shared out.
    shares: [Share; WIDTH],
}

/// Boxes for the first child and for the second, or [`WHOLE`].
type Share = (u8, u8);
/// One box for both children together.
const WHOLE: Share = (0, 0);

/// The least costs of having a part of the binary tree in up to 1, 2, ... 7 boxes, in visits of nodes. Leaves cost nothing:
/// they are visited in any case.
type Costs = [f32; WIDTH - 1];

/// Adds the binary tree of a range of items, which starts at `start`, to `nodes`.
fn part<const LEAF_ITEMS: usize>(
    items: &mut [Item],
    start: u32,
    around: &Around,
    depth: usize,
    nodes: &mut Vec<Binary>,
) -> Costs {
    let (index, count) = (nodes.len(), items.len());
    let planes = around.boxes.planes();
    nodes.push(Binary { planes, start, count: count as u32, second: 0, shares: [WHOLE; WIDTH] });
    if count <= LEAF_ITEMS {
        return [0.0; WIDTH - 1];
    }
    let (first, sides) = if depth < SAH_DEPTH {
        // Leaves are tested whole, so what counts is how many of them are needed.
        split::split(items, around, |count| count.div_ceil(LEAF_ITEMS as u32) as f32)
    } else {
        split::halve(items)
    };
    let (left, right) = items.split_at_mut(first);
    let (middle, depth) = (start + first as u32, depth + 1);
    let costs = if count <= PARALLEL_ITEMS {
        let left = part::<LEAF_ITEMS>(left, start, &sides[0], depth, nodes);
        nodes[index].second = (nodes.len() - index) as u32;
        [left, part::<LEAF_ITEMS>(right, middle, &sides[1], depth, nodes)]
    } else {
        let mut below = Vec::new();
        let (left, right) = rayon::join(
            || part::<LEAF_ITEMS>(left, start, &sides[0], depth, nodes),
            || part::<LEAF_ITEMS>(right, middle, &sides[1], depth, &mut below),
        );
        nodes[index].second = (nodes.len() - index) as u32;
        nodes.append(&mut below);
        [left, right]
    };
    let (costs, shares) = shared_out(&costs, around.boxes.half_area());
    nodes[index].shares = shares;
    costs
}

/// The costs of a node from those of its children, and how its boxes are shared out.
fn shared_out([left, right]: &[Costs; 2], area: f32) -> (Costs, [Share; WIDTH]) {
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

/// The binary tree on its way to a wide one.
struct Collapse {
    binary: Vec<Binary>,
    nodes: Vec<Node>,
    leaves: Vec<(u32, u32)>,
}

impl Collapse {
    /// Adds the node of a binary node, and everything below it.
    fn node(&mut self, of: usize) -> Child {
        let index = self.nodes.len();
        self.nodes.push(Node::EMPTY);
        let (mut boxes, mut used) = ([0; WIDTH], 0);
        self.boxes(of, WIDTH, &mut boxes, &mut used);
        for (place, &inner) in boxes[..used].iter().enumerate() {
            let Binary { planes, start, count, second, .. } = self.binary[inner];
            let child = if second == 0 {
                self.leaves.push((start, count));
                Child::leaf(self.leaves.len() as u32 - 1)
            } else {
                self.node(inner)
            };
            self.nodes[index].set(place, &planes, child);
        }
        Child::node(index as u32)
    }

    /// What of the binary tree up to `most` boxes for a part of it are around.
    fn boxes(&self, of: usize, most: usize, found: &mut [usize; WIDTH], used: &mut usize) {
        let node = &self.binary[of];
        let (first, second) = node.shares[most - 1];
        if (first, second) == WHOLE {
            found[*used] = of;
            *used += 1;
        } else {
            self.boxes(of + 1, first.into(), found, used);
            self.boxes(of + node.second as usize, second.into(), found, used);
        }
    }
}
