//! Prefetching: the processor is told what will be visited, and goes on while it comes from memory.
//!
//! In a large tree most of a ray's time is waiting for nodes and leaves that are in no cache. A packet that pushes the boxes
//! it meets, and a stream that has noted what its rays visit next, know long before what they will need. Small trees are in
//! a cache, where prefetching costs more than it saves.

use super::node::{Bvh, Child, Node};
use crate::simd::WIDTH;
use prefetch_index::prefetch_index;

impl<Leaf> Bvh<Leaf> {
    /// Returns whether the tree is so large that most of it is in no cache.
    #[inline(always)]
    pub fn is_large(&self) -> bool {
        const LARGE: usize = 16 << 20;
        self.bytes() > LARGE
    }
}

/// Prefetches the children of a node that are met; leaves by `prefetch_leaf`. It is never inlined, so that the traversal of
/// small trees stays as it is.
#[inline(never)]
pub fn prefetch_children(nodes: &[Node], node: &Node, mut met: u32, prefetch_leaf: impl Fn(usize)) {
    while met != 0 {
        prefetch(nodes, node.children[met.trailing_zeros() as usize % WIDTH], &prefetch_leaf);
        met &= met - 1;
    }
}

/// Prefetches a child; a leaf by `prefetch_leaf`.
#[inline(always)]
pub fn prefetch(nodes: &[Node], child: Child, prefetch_leaf: impl Fn(usize)) {
    if child.is_leaf() {
        prefetch_leaf(child.index());
    } else if let Some(node) = nodes.get(child.index()) {
        prefetch_lines(&node.planes);
        prefetch_lines(&node.children);
    }
}

/// Prefetches all lines of some numbers.
#[inline(always)]
pub fn prefetch_lines<T>(numbers: &[T]) {
    /// Bytes of a line of a cache.
    const LINE: usize = 64;
    for index in (0..numbers.len()).step_by((LINE / size_of::<T>()).max(1)) {
        prefetch_index(numbers, index);
    }
}
