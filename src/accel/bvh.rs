//! [`Bvh`]: a binary tree of boxes over numbered items.

use crate::objects::{Aabb, PreparedRay};
use vecmath::Real;

/// Splits are tried at so many places an axis (Wald: On fast Construction of SAH-based Bounding Volume Hierarchies,
/// 2007).
const BINS: usize = 16;
/// Leaves hold at most so many items.
const LEAF_ITEMS: usize = 4;
/// Below this depth the tree is split in the middle, which bounds its depth by `MAX_DEPTH`: 2^32 items halved 32 times.
const SAH_DEPTH: usize = 32;
const MAX_DEPTH: usize = SAH_DEPTH + 32;

/// A bounding volume hierarchy: boxes in boxes, with items at the leaves.
#[derive(Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    /// Item numbers; a leaf owns a run of them.
    items: Vec<u32>,
    /// The largest coordinate of any box.
    reach: Real,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    /// A leaf's first place in `items`, or the index of the right child; the left child is the next node.
    first: u32,
    /// Items of a leaf; 0 for an inner node.
    count: u32,
}

impl Bvh {
    /// A tree over items 0, 1, 2, ... with these boxes.
    pub fn build(boxes: &[Aabb]) -> Self {
        let mut builder = Builder {
            boxes,
            centers: boxes.iter().map(Aabb::center).collect(),
            items: (0..boxes.len() as u32).collect(),
            nodes: Vec::new(),
        };
        if !boxes.is_empty() {
            builder.build_node(0, boxes.len(), 0);
        }
        let reach = builder.nodes.first().map_or(0.0, |root| root.bounds.max_abs());
        Self { nodes: builder.nodes, items: builder.items, reach }
    }

    /// Calls `visit` with every item whose box the ray may meet at a t up to `t_max`, near boxes first. `visit` returns
    /// the new `t_max`.
    pub fn visit(&self, ray: &PreparedRay, t_max: Real, mut visit: impl FnMut(u32) -> Real) {
        let mut t_max = t_max;
        self.walk(ray, &mut t_max, |item, t_max| {
            *t_max = visit(item);
            false
        });
    }

    /// Whether `accept` holds for any item whose box the ray may meet at a t up to `t_max`.
    pub fn visit_any(&self, ray: &PreparedRay, t_max: Real, mut accept: impl FnMut(u32) -> bool) -> bool {
        let mut t_max = t_max;
        self.walk(ray, &mut t_max, |item, _| accept(item))
    }

    /// Walks down until `stop` says so.
    fn walk(&self, ray: &PreparedRay, t_max: &mut Real, mut stop: impl FnMut(u32, &mut Real) -> bool) -> bool {
        // A triangle's corners are rounded when they are moved to the ray's origin and sheared, each time by less than
        // a rounding unit of the distance. The boxes are grown by what that can add up to, and more.
        let margin = 16.0 * Real::EPSILON * (ray.ray.origin.max_abs() + self.reach);
        let entry = |index: u32, t_max: Real| self.nodes[index as usize].bounds.entry(ray, margin, t_max);
        let mut stack = [(0, 0.0); MAX_DEPTH];
        let mut height = 0;
        let mut current = match self.nodes.is_empty() {
            true => None,
            false => entry(0, *t_max).map(|_| 0),
        };
        while let Some(index) = current {
            let node = &self.nodes[index as usize];
            current = None;
            if node.count > 0 {
                let run = node.first as usize..(node.first + node.count) as usize;
                if self.items[run].iter().any(|&item| stop(item, t_max)) {
                    return true;
                }
            } else {
                let (left, right) = (index + 1, node.first);
                match (entry(left, *t_max), entry(right, *t_max)) {
                    (Some(l), Some(r)) => {
                        let (near, far) = if l <= r { (left, (right, r)) } else { (right, (left, l)) };
                        stack[height] = far;
                        height += 1;
                        current = Some(near);
                    }
                    (Some(_), None) => current = Some(left),
                    (None, Some(_)) => current = Some(right),
                    (None, None) => {}
                }
            }
            while current.is_none() && height > 0 {
                height -= 1;
                let (index, near) = stack[height];
                if near <= *t_max {
                    current = Some(index);
                }
            }
        }
        false
    }
}

struct Builder<'a> {
    boxes: &'a [Aabb],
    centers: Vec<vecmath::Vector3>,
    items: Vec<u32>,
    nodes: Vec<Node>,
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    count: usize,
}

impl Builder<'_> {
    fn build_node(&mut self, start: usize, end: usize, depth: usize) -> u32 {
        let bounds = self.bounds_of(start, end);
        let index = self.nodes.len() as u32;
        self.nodes.push(Node { bounds, first: start as u32, count: (end - start) as u32 });
        if end - start > LEAF_ITEMS {
            let middle = self.split(start, end, depth);
            self.build_node(start, middle, depth + 1);
            let right = self.build_node(middle, end, depth + 1);
            self.nodes[index as usize].first = right;
            self.nodes[index as usize].count = 0;
        }
        index
    }

    fn bounds_of(&self, start: usize, end: usize) -> Aabb {
        let boxes = self.items[start..end].iter().map(|&item| &self.boxes[item as usize]);
        boxes.fold(Aabb::EMPTY, |all, one| all.union(one))
    }

    /// Sorts the items of a node into two sides and returns where the second begins.
    fn split(&mut self, start: usize, end: usize, depth: usize) -> usize {
        let centers = Aabb::of_points(self.items[start..end].iter().map(|&item| self.centers[item as usize]));
        let best = (0..3)
            .filter_map(|axis| self.best_plane(start, end, &centers, axis))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let middle = start + (end - start) / 2;
        let Some((_, axis, plane)) = best.filter(|_| depth < SAH_DEPTH) else {
            return middle;
        };
        let bin = bin_of(&centers, axis);
        let (mut left, mut right) = (start, end);
        while left < right {
            if bin(self.centers[self.items[left] as usize][axis]) < plane {
                left += 1;
            } else {
                right -= 1;
                self.items.swap(left, right);
            }
        }
        if left == start || left == end { middle } else { left }
    }

    /// The cheapest plane across `axis`: its cost (surface area heuristic), the axis, and the first bin to its right.
    fn best_plane(&self, start: usize, end: usize, centers: &Aabb, axis: usize) -> Option<(Real, usize, usize)> {
        let extent = centers.size()[axis];
        if !(extent > 0.0 && extent.is_finite()) {
            return None;
        }
        let bin = bin_of(centers, axis);
        let mut bins = [Bin { bounds: Aabb::EMPTY, count: 0 }; BINS];
        for &item in &self.items[start..end] {
            let bin = &mut bins[bin(self.centers[item as usize][axis])];
            bin.bounds = bin.bounds.union(&self.boxes[item as usize]);
            bin.count += 1;
        }
        let cost = |bounds: &Aabb, count: usize| if count == 0 { 0.0 } else { bounds.area() * count as Real };
        let mut right_costs = [0.0; BINS];
        let (mut bounds, mut count) = (Aabb::EMPTY, 0);
        for plane in (1..BINS).rev() {
            bounds = bounds.union(&bins[plane].bounds);
            count += bins[plane].count;
            right_costs[plane] = cost(&bounds, count);
        }
        let (mut bounds, mut count) = (Aabb::EMPTY, 0);
        (1..BINS)
            .map(|plane| {
                bounds = bounds.union(&bins[plane - 1].bounds);
                count += bins[plane - 1].count;
                (cost(&bounds, count) + right_costs[plane], axis, plane)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
    }
}

/// Which bin a centre's coordinate falls into.
fn bin_of(centers: &Aabb, axis: usize) -> impl Fn(Real) -> usize + use<> {
    let (low, extent) = (centers.min[axis], centers.size()[axis]);
    move |coordinate| (((coordinate - low) / extent * BINS as Real) as usize).min(BINS - 1)
}
