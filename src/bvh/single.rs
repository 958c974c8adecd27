//! One ray through a [`Tree`]: its leaves, near ones first.

use super::frame::CullRay;
use super::simd::{Lanes, Level, Task, WIDTH};
use super::tree::{Child, Node, Tree};

/// A limit below every t: the search is over.
pub const DONE: f32 = -1.0;

/// Pending boxes kept at hand. Deeper trees are walked on by a call of the walk to itself.
const STACK: usize = 64;

/// What is to be done at a leaf. Implementations are `#[inline(always)]`, as everything in a
/// [`Task`](super::simd::Task).
pub trait Visit {
    /// Looks at a leaf and returns the new limit, [`DONE`] to end the walk.
    fn visit<L: Lanes>(&mut self, lanes: L, leaf: usize) -> f32;
}

/// Calls [`Visit::visit`] with the number of every leaf below `start` whose box the ray may meet at a t up to `limit`.
/// The output is the last limit.
pub struct Walk<'a, V> {
    pub tree: &'a Tree,
    pub start: Child,
    pub ray: &'a CullRay,
    pub limit: f32,
    pub visit: &'a mut V,
    pub stack: &'a mut Stack,
}

/// Pending boxes, and where the ray enters them.
pub type Stack = [(f32, Child); STACK];

pub const EMPTY_STACK: Stack = [(0.0, Child::NONE); STACK];

/// Walks a tree from its root.
#[inline]
pub fn walk_all(level: Level, tree: &Tree, ray: &CullRay, limit: f32, visit: &mut impl Visit) {
    if !tree.nodes.is_empty() {
        let (start, stack) = (Child::node(0), &mut { EMPTY_STACK });
        level.run(Walk { tree, start, ray, limit, visit, stack });
    }
}

/// A leaf's number is enough for a closure.
pub struct Call<F>(pub F);

impl<F: FnMut(usize) -> f32> Visit for Call<F> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, _: L, leaf: usize) -> f32 {
        (self.0)(leaf)
    }
}

/// A ray in registers, each component eight times.
pub struct RayLanes<F> {
    inverse: [F; 3],
    origin_times_inverse: [F; 3],
    /// Index of the lower or upper plane that the ray meets first, axis by axis.
    first: [usize; 3],
    /// The other one.
    second: [usize; 3],
}

impl<F: Copy> RayLanes<F> {
    #[inline(always)]
    fn new<L: Lanes<F = F>>(l: L, ray: &CullRay) -> Self {
        let (inverse, product) = (ray.inverse, ray.origin_times_inverse());
        let first = |axis: usize| if inverse[axis] < 0.0 { axis + 3 } else { axis };
        Self {
            inverse: [l.splat(inverse[0]), l.splat(inverse[1]), l.splat(inverse[2])],
            origin_times_inverse: [l.splat(product[0]), l.splat(product[1]), l.splat(product[2])],
            first: [first(0), first(1), first(2)],
            second: [3 - first(0), 5 - first(1), 7 - first(2)],
        }
    }

    /// t of a plane of each of a node's boxes.
    #[inline(always)]
    fn planes<L: Lanes<F = F>>(&self, l: L, node: &Node, axis: usize, index: usize) -> F {
        l.mul_sub(l.load(&node.planes[index % 6]), self.inverse[axis], self.origin_times_inverse[axis])
    }

    /// Which of a node's boxes the ray meets at a t from 0 to `limit`, and where.
    #[inline(always)]
    fn boxes<L: Lanes<F = F>>(&self, l: L, node: &Node, limit: f32) -> (u32, F) {
        let [x, y, z] = self.first;
        let near = l.max(
            l.max(self.planes(l, node, 0, x), self.planes(l, node, 1, y)),
            l.max(self.planes(l, node, 2, z), l.splat(0.0)),
        );
        let [x, y, z] = self.second;
        let far = l.min(
            l.min(self.planes(l, node, 0, x), self.planes(l, node, 1, y)),
            l.min(self.planes(l, node, 2, z), l.splat(limit)),
        );
        (l.bits(l.le(near, far)), near)
    }
}

impl<V: Visit> Task for Walk<'_, V> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) -> f32 {
        let lanes = RayLanes::new(l, self.ray);
        let mut height = 0;
        let mut current = self.start;
        loop {
            if current.is_leaf() {
                self.limit = self.visit.visit(l, current.index());
                if self.limit < 0.0 {
                    return self.limit;
                }
            } else {
                let node = &self.tree.nodes[current.index()];
                let (mut met, near) = lanes.boxes(l, node, self.limit);
                if met != 0 {
                    let first = met.trailing_zeros() as usize;
                    met &= met - 1;
                    current = node.children[first % WIDTH];
                    if met == 0 {
                        continue;
                    }
                    let mut distances = [0.0; WIDTH];
                    l.store(near, &mut distances);
                    if height + WIDTH > STACK {
                        self.walk_boxes(l, node, first, met, &distances);
                        if self.limit < 0.0 {
                            return self.limit;
                        }
                    } else {
                        current = pushed(node, first, met, &distances, self.stack, &mut height);
                        continue;
                    }
                }
            }
            loop {
                if height == 0 {
                    return self.limit;
                }
                height -= 1;
                let (near, child) = self.stack[height];
                if near <= self.limit {
                    current = child;
                    break;
                }
            }
        }
    }
}

/// Puts all but the nearest of the boxes that are met on the stack, sorted, and returns the nearest.
#[inline(always)]
fn pushed(
    node: &Node,
    first: usize,
    mut met: u32,
    distances: &[f32; WIDTH],
    stack: &mut Stack,
    height: &mut usize,
) -> Child {
    let mut nearest = (distances[first], node.children[first]);
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

impl<V: Visit> Walk<'_, V> {
    /// Walks the boxes of a node one by one, for want of room on the stack.
    #[inline(always)]
    fn walk_boxes<L: Lanes>(&mut self, l: L, node: &Node, first: usize, met: u32, distances: &[f32; WIDTH]) {
        let mut met = met | 1 << first;
        while met != 0 && self.limit >= 0.0 {
            let place = met.trailing_zeros() as usize % WIDTH;
            met &= met - 1;
            if distances[place] <= self.limit {
                let start = node.children[place];
                let Self { tree, ray, limit, .. } = *self;
                let (visit, stack) = (&mut *self.visit, &mut { EMPTY_STACK });
                self.limit = l.enter(Walk { tree, start, ray, limit, visit, stack });
            }
        }
    }
}
