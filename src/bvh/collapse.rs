//! Collapses a binary [`Tree`] to the cheapest tree of eight boxes a node.
//!
//! The result is optimal for the whole tree: costs are computed from the leaves upwards (Ylitie, Karras, Laine:
//! Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, 2017, section 3). What becomes of a node's
//! children is decided from the root downwards.

use super::node::{Child, Node};
use super::space::Planes;
use crate::simd::WIDTH;
use rayon::prelude::*;
use std::array::from_fn;

/// A binary tree.
pub enum Tree {
    /// Of few items: its nodes, each before those below it.
    Few(Vec<Binary>),
    /// Of many items.
    Many { planes: Planes, shares: [Share; WIDTH], children: Box<[Tree; 2]> },
}

/// A node of the binary tree of few items. Its first child is the next node.
pub struct Binary {
    pub planes: Planes,
    /// Of its items.
    pub start: u32,
    pub count: u32,
    /// Distance from this node to its second child; 0 for a leaf.
    pub second: u32,
    /// For each number of boxes from 1 to 8, the cheapest division of the boxes between the children.
    pub shares: [Share; WIDTH],
}

/// Number of boxes for the first child and for the second, or [`WHOLE`].
pub type Share = (u8, u8);
/// One box for both children together.
const WHOLE: Share = (0, 0);
/// The shares of a leaf.
pub const WHOLE_ALWAYS: [Share; WIDTH] = [WHOLE; WIDTH];

/// The least costs of a subtree of the binary tree if it becomes at most 1, 2, ... 7 boxes, in visits of nodes.
/// Leaves cost nothing, because they are visited in any case.
pub type Costs = [f32; WIDTH - 1];
/// The costs of a leaf.
pub const NO_COSTS: Costs = [0.0; WIDTH - 1];

/// Returns the costs of a node from the costs of its children, and the cheapest division of its boxes between them.
pub fn cheapest_shares([left, right]: &[Costs; 2], area: f32) -> (Costs, [Share; WIDTH]) {
    let mut shares = WHOLE_ALWAYS;
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

/// The items of a leaf: the first one, and their number.
type Range = (u32, u32);

impl Tree {
    /// Returns nodes and leaves of the collapsed tree. Subtrees of few items are collapsed in parallel; they come last.
    pub fn collapsed(&self) -> (Vec<Node>, Vec<Range>) {
        if let Self::Few(nodes) = self {
            let mut wide = Wide::default();
            wide.add_node(Subtree::Few(nodes), &leaf);
            return (wide.nodes, wide.leaves);
        }
        // Of the upper part, each subtree of few items is a leaf.
        let mut upper = Wide::default();
        upper.add_node(Subtree::of(self), &|subtree| match subtree {
            Subtree::Few(nodes) => Some(nodes),
            Subtree::Many(..) => None,
        });
        let lower = |nodes: &&[Binary]| {
            let mut wide = Wide::default();
            (wide.add(Subtree::Few(nodes), &leaf), wide)
        };
        let lower: Vec<_> = upper.leaves.par_iter().map(lower).collect();
        joined(upper.nodes, lower)
    }
}

/// Returns the items of a subtree that is a leaf.
fn leaf(subtree: Subtree) -> Option<Range> {
    match subtree {
        Subtree::Few([Binary { second: 0, start, count, .. }, ..]) => Some((*start, *count)),
        _ => None,
    }
}

/// Joins the upper nodes of a tree, whose leaves are the numbers of the lower parts, and these parts. Each has its root.
fn joined(mut nodes: Vec<Node>, lower: Vec<(Child, Wide<Range>)>) -> (Vec<Node>, Vec<Range>) {
    let (mut starts, mut end) = (Vec::with_capacity(lower.len()), (nodes.len(), 0));
    for (_, wide) in &lower {
        starts.push(end);
        end = (end.0 + wide.nodes.len(), end.1 + wide.leaves.len());
    }
    for child in nodes.iter_mut().flat_map(|node| &mut node.children) {
        if child.is_leaf() && *child != Child::NONE {
            let part = child.index();
            *child = lower[part].0.moved(starts[part]);
        }
    }
    let upper_nodes = nodes.len();
    nodes.resize(end.0, Node::EMPTY);
    let (mut rest, mut places) = (&mut nodes[upper_nodes..], Vec::with_capacity(lower.len()));
    for ((_, wide), start) in lower.iter().zip(starts) {
        let (place, after) = rest.split_at_mut(wide.nodes.len());
        places.push((place, &wide.nodes, start));
        rest = after;
    }
    places.into_par_iter().for_each(|(place, nodes, start)| {
        for (place, node) in place.iter_mut().zip(nodes) {
            *place = Node { planes: node.planes, children: node.children.map(|child| child.moved(start)) };
        }
    });
    let leaves = lower.into_iter().flat_map(|(_, wide)| wide.leaves).collect();
    (nodes, leaves)
}

/// A part of a binary tree.
#[derive(Clone, Copy)]
enum Subtree<'a> {
    Few(&'a [Binary]),
    Many(&'a Planes, &'a [Share; WIDTH], &'a [Tree; 2]),
}

impl<'a> Subtree<'a> {
    fn of(tree: &'a Tree) -> Self {
        match tree {
            Tree::Few(nodes) => Self::Few(nodes),
            Tree::Many { planes, shares, children } => Self::Many(planes, shares, children),
        }
    }

    fn planes(self) -> &'a Planes {
        match self {
            Self::Few(nodes) => &nodes[0].planes,
            Self::Many(planes, ..) => planes,
        }
    }

    /// Collects the at most `most` subtrees that become a node's children.
    fn collect_children(self, most: usize, found: &mut [Self; WIDTH], used: &mut usize) {
        let shares = match self {
            Self::Few(nodes) => &nodes[0].shares,
            Self::Many(_, shares, _) => shares,
        };
        let (first, second) = shares[most - 1];
        if (first, second) == WHOLE {
            found[*used] = self;
            *used += 1;
            return;
        }
        let [left, right] = match self {
            Self::Few(nodes) => [Self::Few(&nodes[1..]), Self::Few(&nodes[nodes[0].second as usize..])],
            Self::Many(.., [left, right]) => [Self::of(left), Self::of(right)],
        };
        left.collect_children(first.into(), found, used);
        right.collect_children(second.into(), found, used);
    }
}

/// A tree of eight boxes a node.
struct Wide<Leaf> {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
}

impl<Leaf> Default for Wide<Leaf> {
    fn default() -> Self {
        Self { nodes: Vec::new(), leaves: Vec::new() }
    }
}

impl<Leaf> Wide<Leaf> {
    /// Adds a node for the root of a subtree, and what is below it. `leaf` makes leaves of the subtrees that become one.
    fn add_node<'a>(&mut self, of: Subtree<'a>, leaf: &impl Fn(Subtree<'a>) -> Option<Leaf>) -> Child {
        let index = self.nodes.len();
        self.nodes.push(Node::EMPTY);
        let (mut children, mut used) = ([of; WIDTH], 0);
        of.collect_children(WIDTH, &mut children, &mut used);
        for (place, &child) in children[..used].iter().enumerate() {
            let added = self.add(child, leaf);
            self.nodes[index].set(place, child.planes(), added);
        }
        Child::node(index as u32)
    }

    /// Adds a subtree, which may be a leaf.
    fn add<'a>(&mut self, subtree: Subtree<'a>, leaf: &impl Fn(Subtree<'a>) -> Option<Leaf>) -> Child {
        match leaf(subtree) {
            Some(leaf) => {
                self.leaves.push(leaf);
                Child::leaf(self.leaves.len() as u32 - 1)
            }
            None => self.add_node(subtree, leaf),
        }
    }
}
