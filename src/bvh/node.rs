//! [`Bvh`] and its [`Node`]s of eight boxes, laid out as vectors are loaded.
//!
//! The tree knows boxes and not what its leaves stand for. [`build`](super::build) makes a tree; the code that
//! traverses it tests the leaves.

use super::space::{CullingSpace, Planes};
use crate::simd::{Eight, WIDTH};

/// Eight boxes and their children: 224 bytes, seven vectors.
///
/// | bytes | what |
/// |---|---|
/// | 0..96 | lower x of the eight boxes, then lower y, lower z |
/// | 96..192 | upper x, y, z |
/// | 192..224 | the eight children, see [`Child`] |
///
/// Boxes are in the tree's [`CullingSpace`], margin included. Unused places come last. Their boxes are one point far
/// away (10^30 on each axis), which no ray meets within its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct Node {
    pub planes: [Eight; 6],
    pub children: [Child; WIDTH],
}

/// The content of a box. Bit 31 says whether it is a leaf; the other bits are the index of the leaf or node. A node's
/// index is larger than its parent's. All bits set: no child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Child(u32);

const LEAF_BIT: u32 = 1 << 31;
const FAR_AWAY: f32 = 1e30;

impl Child {
    pub const NONE: Self = Self(u32::MAX);

    pub fn leaf(number: u32) -> Self {
        debug_assert!(number < LEAF_BIT - 1);
        Self(number | LEAF_BIT)
    }

    pub fn node(index: u32) -> Self {
        debug_assert!(index < LEAF_BIT);
        Self(index)
    }

    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.0 & LEAF_BIT != 0
    }

    /// Returns the child as a number; [`of_bits`](Self::of_bits) turns it back.
    #[inline(always)]
    pub fn bits(self) -> u32 {
        self.0
    }

    #[inline(always)]
    pub fn of_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// Returns the child when nodes and leaves have moved by so many.
    pub fn moved(self, (nodes, leaves): (usize, usize)) -> Self {
        match self {
            Self::NONE => self,
            _ if self.is_leaf() => Self::leaf((self.index() + leaves) as u32),
            _ => Self::node((self.index() + nodes) as u32),
        }
    }

    /// Returns the index of the leaf or of the node.
    #[inline(always)]
    pub fn index(self) -> usize {
        (self.0 & !LEAF_BIT) as usize
    }
}

impl Node {
    pub const EMPTY: Self = Self { planes: [[FAR_AWAY; WIDTH]; 6], children: [Child::NONE; WIDTH] };

    pub fn set(&mut self, place: usize, planes: &Planes, child: Child) {
        for (plane, &value) in self.planes.iter_mut().zip(planes) {
            plane[place] = value;
        }
        self.children[place] = child;
    }

    #[inline]
    pub fn planes_of(&self, place: usize) -> Planes {
        self.planes.map(|plane| plane[place])
    }

    /// Returns the number of boxes in use.
    pub fn box_count(&self) -> u32 {
        self.children.iter().filter(|&&child| child != Child::NONE).count() as u32
    }

    /// Returns the box around all boxes in use.
    fn around(&self) -> Planes {
        let used = (0..WIDTH).filter(|&place| self.children[place] != Child::NONE);
        let boxes = used.map(|place| self.planes_of(place));
        let nothing = std::array::from_fn(|side| if side < 3 { f32::INFINITY } else { f32::NEG_INFINITY });
        boxes.fold(nothing, |around: Planes, planes| {
            std::array::from_fn(|side| {
                let (a, b) = (around[side], planes[side]);
                if side < 3 { a.min(b) } else { a.max(b) }
            })
        })
    }
}

/// A bounding volume hierarchy. The root is node 0.
#[derive(Debug)]
pub struct Bvh<Leaf> {
    pub space: CullingSpace,
    pub nodes: Vec<Node>,
    pub leaves: Vec<Leaf>,
}

impl<Leaf> Bvh<Leaf> {
    /// Returns the bytes of nodes and leaves on the heap.
    pub fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.leaves.as_slice())
    }

    /// Checks the structure: every leaf and every node but the root is in exactly one box, each box encloses its
    /// content, and unused places are last and empty. `leaf_planes` returns the box around a leaf.
    ///
    /// # Errors
    /// The first flaw in words.
    pub fn validate(&self, leaf_planes: impl Fn(&Leaf) -> Planes) -> Result<(), String> {
        let mut node_parents = vec![0u32; self.nodes.len()];
        let mut leaf_parents = vec![0u32; self.leaves.len()];
        for (index, node) in self.nodes.iter().enumerate() {
            let used = node.children.iter().take_while(|&&child| child != Child::NONE).count();
            for place in used..WIDTH {
                if node.children[place] != Child::NONE || node.planes_of(place) != Node::EMPTY.planes_of(0) {
                    return Err(format!("node {index}: place {place} is neither used nor empty"));
                }
            }
            for place in 0..used {
                let child = node.children[place];
                let outer = node.planes_of(place);
                let inner = if child.is_leaf() {
                    *leaf_parents.get_mut(child.index()).ok_or("a leaf's number is too large")? += 1;
                    leaf_planes(&self.leaves[child.index()])
                } else {
                    if child.index() <= index {
                        return Err(format!("node {index}: its child {} comes before it", child.index()));
                    }
                    *node_parents.get_mut(child.index()).ok_or("a node's index is too large")? += 1;
                    self.nodes[child.index()].around()
                };
                let encloses = (0..3).all(|axis| outer[axis] <= inner[axis] && outer[axis + 3] >= inner[axis + 3]);
                if !encloses {
                    return Err(format!("node {index}: box {place} does not enclose what is in it"));
                }
            }
        }
        let once = |parents: &[u32]| parents.iter().all(|&count| count == 1);
        let rooted = node_parents.is_empty() || (node_parents[0] == 0 && once(&node_parents[1..]));
        if rooted && once(&leaf_parents) {
            Ok(())
        } else {
            Err("a node or a leaf is not in exactly one box".into())
        }
    }
}
