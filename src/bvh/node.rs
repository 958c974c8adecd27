//! [`Tree`]: eight boxes a node, as the processor likes to read them.
//!
//! What the leaves stand for is known to whoever walks the tree, and how to build one to [`build`](super::build).

use super::frame::Planes;
use super::simd::{Eight, WIDTH};

/// 224 bytes, seven times what a register holds:
///
/// | bytes | what |
/// |---|---|
/// | 0..96 | lower x of the eight boxes, then lower y, lower z |
/// | 96..192 | upper x, y, z |
/// | 192..224 | what is in the eight boxes, see [`Child`] |
///
/// Boxes are in the tree's [`Frame`](super::frame::Frame), margin included. Unused places come last; their boxes are a
/// point far away (10^30 on each axis), which neither a ray meets within its limit nor a shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct Node {
    pub planes: [Eight; 6],
    pub children: [Child; WIDTH],
}

/// What is in a box. Bit 31 set: the leaf whose number the other bits are; otherwise the node of that index, which is
/// larger than its parent's. All bits set: nothing.
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

    /// The child as a number, and back.
    #[inline(always)]
    pub fn bits(self) -> u32 {
        self.0
    }

    #[inline(always)]
    pub fn of_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// A leaf's number or a node's index.
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

    pub fn planes_of(&self, place: usize) -> Planes {
        self.planes.map(|plane| plane[place])
    }
}

/// A bounding volume hierarchy without its items. The root is node 0; an empty tree has none.
#[derive(Debug, Default)]
pub struct Tree {
    pub nodes: Vec<Node>,
}

impl Tree {
    /// Whether the tree is one: every node but the root and every leaf from 0 to `leaves` is in exactly one box, that
    /// box encloses what is in it, and unused places are last and empty. `leaf_planes` are what a leaf's box must
    /// enclose.
    ///
    /// # Errors
    /// The first flaw in words.
    pub fn validate(&self, leaves: usize, leaf_planes: impl Fn(usize) -> Planes) -> Result<(), String> {
        let mut node_parents = vec![0u32; self.nodes.len()];
        let mut leaf_parents = vec![0u32; leaves];
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
                    leaf_planes(child.index())
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

impl Node {
    /// The box around all boxes in use.
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
