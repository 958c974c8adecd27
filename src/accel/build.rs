//! Boxes in, [`Tree`] out: the cheapest of some splits, again and again, eight boxes to a node.
//!
//! Splits are chosen by the surface area heuristic over binned centres (Wald: On fast Construction of SAH-based
//! Bounding Volume Hierarchies, 2007); a node is filled by splitting its largest box until there are eight (Wald,
//! Benthin, Boulos: Getting Rid of Packets, 2008). Subtrees are built in parallel. The tree does not depend on how
//! many threads there are: minima, maxima and counts come out the same in any order.

use super::frame::Planes;
use super::simd::WIDTH;
use super::tree::{Child, Node, Tree};
use rayon::prelude::*;

/// Splits are tried at so many places an axis.
const BINS: usize = 16;
/// Ranges above this length are shared out among threads.
const PARALLEL_ITEMS: usize = 1 << 14;
/// Below this depth ranges are halved by number alone, eightfold a node, so that no tree is deeper than about 24 + 11.
const SAH_DEPTH: usize = 24;

/// An item to be put into a tree: its box in the tree's frame, and its number.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Item {
    lower: [f32; 3],
    number: u32,
    upper: [f32; 3],
}

impl Item {
    pub fn new(number: u32, planes: &Planes) -> Self {
        let [a, b, c, d, e, f] = *planes;
        Self { lower: [a, b, c], number, upper: [d, e, f] }
    }

    /// Twice the centre.
    #[inline(always)]
    fn center(&self, axis: usize) -> f32 {
        self.lower[axis] + self.upper[axis]
    }
}

/// A tree and what its leaves hold.
pub struct Built {
    pub tree: Tree,
    /// A leaf's first place in `numbers`, and how many items it has.
    pub leaves: Vec<(u32, u32)>,
    /// Item numbers in the order of the leaves' places.
    pub numbers: Vec<u32>,
}

/// Builds a tree whose leaves hold at most `leaf_items` items.
pub fn build(mut items: Vec<Item>, leaf_items: usize) -> Built {
    if items.is_empty() {
        return Built { tree: Tree::default(), leaves: Vec::new(), numbers: Vec::new() };
    }
    let builder = Builder { leaf_items };
    let whole = Range { start: 0, bounds: Bounds::of(&items, true), centers: Bounds::of(&items, false) };
    let mut subtree = Subtree::default();
    builder.node(&mut items, &whole, 0, &mut subtree);
    let numbers = items.iter().map(|item| item.number).collect();
    Built { tree: Tree { nodes: subtree.nodes }, leaves: subtree.leaves, numbers }
}

#[derive(Clone, Copy)]
struct Bounds {
    lower: [f32; 3],
    upper: [f32; 3],
}

impl Bounds {
    const EMPTY: Self = Self { lower: [f32::INFINITY; 3], upper: [f32::NEG_INFINITY; 3] };

    #[inline(always)]
    fn add(&mut self, lower: &[f32; 3], upper: &[f32; 3]) {
        for axis in 0..3 {
            // Unlike `f32::min`, this is one instruction.
            self.lower[axis] = if lower[axis] < self.lower[axis] { lower[axis] } else { self.lower[axis] };
            self.upper[axis] = if upper[axis] > self.upper[axis] { upper[axis] } else { self.upper[axis] };
        }
    }

    #[inline(always)]
    fn add_center(&mut self, item: &Item) {
        let center = [item.center(0), item.center(1), item.center(2)];
        self.add(&center, &center);
    }

    fn merged(mut self, other: Self) -> Self {
        self.add(&other.lower, &other.upper);
        self
    }

    /// Of the items' boxes, or of their centres.
    fn of(items: &[Item], boxes: bool) -> Self {
        let of_part = |items: &[Item]| {
            let mut bounds = Self::EMPTY;
            for item in items {
                if boxes { bounds.add(&item.lower, &item.upper) } else { bounds.add_center(item) }
            }
            bounds
        };
        items.par_chunks(PARALLEL_ITEMS).map(of_part).reduce(|| Self::EMPTY, Self::merged)
    }

    fn half_area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.upper[axis] - self.lower[axis]);
        x * y + y * z + z * x
    }

    fn planes(&self) -> Planes {
        let (l, u) = (self.lower, self.upper);
        [l[0], l[1], l[2], u[0], u[1], u[2]]
    }
}

/// Items that belong together. `start` counts from the beginning of all items.
#[derive(Clone, Copy)]
struct Range {
    start: usize,
    bounds: Bounds,
    centers: Bounds,
}

#[derive(Default)]
struct Subtree {
    nodes: Vec<Node>,
    leaves: Vec<(u32, u32)>,
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    count: u32,
}

type Bins = [[Bin; BINS]; 3];
const EMPTY_BINS: Bins = [[Bin { bounds: Bounds::EMPTY, count: 0 }; BINS]; 3];

/// Where to split: items whose bin on `axis` is below `plane` go left.
struct Split {
    axis: usize,
    plane: usize,
    sides: [Bounds; 2],
}

struct Builder {
    leaf_items: usize,
}

impl Builder {
    /// Adds the node of a range, and everything below it, to `subtree`.
    fn node(&self, items: &mut [Item], range: &Range, depth: usize, subtree: &mut Subtree) {
        let index = subtree.nodes.len();
        subtree.nodes.push(Node::EMPTY);
        let length = items.len();
        let mut parts = self.parts(items, range, depth);
        let build_part = |(range, items): &mut (Range, &mut [Item])| {
            let mut below = Subtree::default();
            if items.len() > self.leaf_items {
                self.node(items, range, depth + 1, &mut below);
            }
            below
        };
        if length <= PARALLEL_ITEMS {
            for (place, (part, items)) in parts.into_iter().enumerate() {
                let child = if items.len() <= self.leaf_items {
                    subtree.leaves.push((part.start as u32, items.len() as u32));
                    Child::leaf(subtree.leaves.len() as u32 - 1)
                } else {
                    let child = Child::node(subtree.nodes.len() as u32);
                    self.node(items, &part, depth + 1, subtree);
                    child
                };
                subtree.nodes[index].set(place, &part.bounds.planes(), child);
            }
            return;
        }
        let built: Vec<Subtree> = parts.par_iter_mut().with_max_len(1).map(build_part).collect();
        for (place, ((part, items), below)) in parts.iter().zip(built).enumerate() {
            let (nodes, leaves) = (subtree.nodes.len() as u32, subtree.leaves.len() as u32);
            let child = if below.nodes.is_empty() {
                subtree.leaves.push((part.start as u32, items.len() as u32));
                Child::leaf(leaves)
            } else {
                subtree.leaves.extend_from_slice(&below.leaves);
                subtree.nodes.extend(below.nodes.iter().map(|node| Node {
                    children: node.children.map(|child| child.moved(nodes, leaves)),
                    ..*node
                }));
                Child::node(nodes)
            };
            subtree.nodes[index].set(place, &part.bounds.planes(), child);
        }
    }

    /// Up to eight parts of a range with their items.
    fn parts<'a>(&self, items: &'a mut [Item], range: &Range, depth: usize) -> Vec<(Range, &'a mut [Item])> {
        let mut parts = Vec::with_capacity(WIDTH);
        parts.push((*range, items));
        while parts.len() < WIDTH {
            let splittable = parts.iter().enumerate().filter(|(_, (_, items))| items.len() > self.leaf_items);
            let key = |part: &(Range, &mut [Item])| match depth < SAH_DEPTH {
                true => part.0.bounds.half_area(),
                false => part.1.len() as f32,
            };
            let largest = splittable.max_by(|a, b| key(a.1).total_cmp(&key(b.1))).map(|(place, _)| place);
            let Some(place) = largest else { break };
            let (range, items) = std::mem::replace(&mut parts[place], (*range, &mut []));
            let [left, right] = self.halves(items, &range, depth);
            parts[place] = left;
            parts.push(right);
        }
        parts
    }

    /// Sorts the items of a range into two parts, neither of them empty.
    fn halves<'a>(&self, items: &'a mut [Item], range: &Range, depth: usize) -> [(Range, &'a mut [Item]); 2] {
        let split = if depth < SAH_DEPTH { self.best_split(items, &range.centers) } else { None };
        let Some(split) = split else {
            let (left, right) = items.split_at_mut(items.len() / 2);
            let part = |items: &'a mut [Item], start| {
                let (bounds, centers) = (Bounds::of(items, true), Bounds::of(items, false));
                (Range { start, bounds, centers }, items)
            };
            let middle = range.start + left.len();
            return [part(left, range.start), part(right, middle)];
        };
        let bin = BinOf::new(&range.centers, split.axis);
        let mut centers = [Bounds::EMPTY; 2];
        let (mut left, mut right) = (0, items.len());
        while left < right {
            if bin.of(&items[left]) < split.plane {
                centers[0].add_center(&items[left]);
                left += 1;
            } else {
                right -= 1;
                items.swap(left, right);
                centers[1].add_center(&items[right]);
            }
        }
        let (first, second) = items.split_at_mut(left);
        let start = [range.start, range.start + left];
        let part = |side: usize| Range { start: start[side], bounds: split.sides[side], centers: centers[side] };
        [(part(0), first), (part(1), second)]
    }

    /// The cheapest split, if the centres lie in more than one bin.
    fn best_split(&self, items: &[Item], centers: &Bounds) -> Option<Split> {
        let fill = |items: &[Item]| {
            let mut bins = EMPTY_BINS;
            let bin_of = [0, 1, 2].map(|axis| BinOf::new(centers, axis));
            for item in items {
                for axis in 0..3 {
                    let bin = &mut bins[axis][bin_of[axis].of(item)];
                    bin.bounds.add(&item.lower, &item.upper);
                    bin.count += 1;
                }
            }
            bins
        };
        let bins = if items.len() <= 4 * PARALLEL_ITEMS {
            fill(items)
        } else {
            items.par_chunks(PARALLEL_ITEMS).map(fill).reduce(|| EMPTY_BINS, merged_bins)
        };
        let mut best: Option<(f32, Split)> = None;
        for (axis, bins) in bins.iter().enumerate() {
            let mut right = [(f32::INFINITY, Bounds::EMPTY); BINS];
            let (mut bounds, mut count) = (Bounds::EMPTY, 0);
            for plane in (1..BINS).rev() {
                bounds = bounds.merged(bins[plane].bounds);
                count += bins[plane].count;
                right[plane] = (self.cost(&bounds, count), bounds);
            }
            let (mut bounds, mut count) = (Bounds::EMPTY, 0);
            for plane in 1..BINS {
                bounds = bounds.merged(bins[plane - 1].bounds);
                count += bins[plane - 1].count;
                let cost = self.cost(&bounds, count) + right[plane].0;
                if cost < best.as_ref().map_or(f32::INFINITY, |best| best.0) {
                    best = Some((cost, Split { axis, plane, sides: [bounds, right[plane].1] }));
                }
            }
        }
        best.map(|best| best.1)
    }

    /// The expected work below a box. Leaves are tested whole, so what counts is how many of them are needed.
    fn cost(&self, bounds: &Bounds, count: u32) -> f32 {
        match count {
            0 => f32::INFINITY,
            _ => bounds.half_area() * (count as usize).next_multiple_of(self.leaf_items.div_ceil(2)) as f32,
        }
    }
}

fn merged_bins(mut a: Bins, b: Bins) -> Bins {
    for (a, b) in a.as_flattened_mut().iter_mut().zip(b.as_flattened()) {
        a.bounds = a.bounds.merged(b.bounds);
        a.count += b.count;
    }
    a
}

/// Which bin a centre falls into.
struct BinOf {
    axis: usize,
    low: f32,
    per_length: f32,
}

impl BinOf {
    fn new(centers: &Bounds, axis: usize) -> Self {
        let extent = centers.upper[axis] - centers.lower[axis];
        // Without extent everything falls into bin 0, and no split is found.
        let per_length = if extent > 0.0 { BINS as f32 / extent } else { 0.0 };
        let per_length = if per_length.is_finite() { per_length } else { 0.0 };
        Self { axis, low: centers.lower[axis], per_length }
    }

    #[inline(always)]
    fn of(&self, item: &Item) -> usize {
        (((item.center(self.axis) - self.low) * self.per_length) as usize).min(BINS - 1)
    }
}
