//! Splits items in two by the surface area heuristic: [`Item`]s in, the cheapest of several splits out.
//!
//! The centres of the items are sorted into bins (Wald: On fast Construction of SAH-based Bounding Volume
//! Hierarchies, 2007). Nothing depends on the number of threads or on the instruction set: minima and counts are the
//! same in any order.

use super::item::{Bounds, Enclosing, ITEMS_IN_ONE_PIECE, Item, PARALLEL_ITEMS};
use super::partition::{BINS, Grid, partition};
use crate::simd::{Simd, vectorize};
use rayon::prelude::*;

/// Sorts items into two parts, neither of them empty: the cheapest split by the surface area heuristic, or halves if
/// all centres coincide. Returns the length of the first part and the boxes around each part.
pub fn split<S: Simd>(
    simd: S,
    items: &mut [Item],
    enclosing: &Enclosing,
    cost: impl Fn(u32) -> f32,
) -> (usize, [Enclosing; 2]) {
    let grid = Grid::new(&enclosing.centers, items.len());
    let mut bins = Bins::EMPTY;
    if items.len() <= ITEMS_IN_ONE_PIECE {
        bins.fill(simd, items, &grid);
    } else {
        let filled = |mut bins: Bins, items: &[Item]| {
            bins.fill(simd, items, &grid);
            bins
        };
        let parts = items.par_chunks(PARALLEL_ITEMS).fold(|| Bins::EMPTY, filled);
        bins = parts.reduce(|| Bins::EMPTY, Bins::merged);
    }
    match bins.cheapest_split(simd, &grid, cost) {
        None => halve(simd, items),
        Some((axis, plane)) => {
            let (first, centers) = partition(simd, items, &grid, axis, plane);
            let boxes = bins.sides(axis, plane);
            (first, [0, 1].map(|side| Enclosing { boxes: boxes[side], centers: centers[side] }))
        }
    }
}

/// Splits items in the middle of their order.
pub fn halve<S: Simd>(simd: S, items: &[Item]) -> (usize, [Enclosing; 2]) {
    let (first, second) = items.split_at(items.len() / 2);
    (first.len(), [Enclosing::of(simd, first), Enclosing::of(simd, second)])
}

#[derive(Clone)]
struct Bins {
    bounds: [[Bounds; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl Bins {
    const EMPTY: Self = Self { bounds: [[Bounds::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] };

    fn merged(mut self, other: Self) -> Self {
        for (a, b) in self.bounds.as_flattened_mut().iter_mut().zip(other.bounds.as_flattened()) {
            *a = a.merged(*b);
        }
        for (a, b) in self.counts.as_flattened_mut().iter_mut().zip(other.counts.as_flattened()) {
            *a += b;
        }
        self
    }

    /// Returns the boxes around the items on either side of a plane.
    fn sides(&self, axis: usize, plane: usize) -> [Bounds; 2] {
        let (left, right) = self.bounds[axis].split_at(plane);
        [left, right].map(|bins| bins.iter().fold(Bounds::EMPTY, |all, bin| all.merged(*bin)))
    }

    /// Adds items to their bins.
    fn fill<S: Simd>(&mut self, simd: S, items: &[Item], grid: &Grid) {
        vectorize!(simd, {
            for item in items {
                for axis in 0..3 {
                    let bin = grid.bin_of(item, axis);
                    self.bounds[axis][bin].add(simd, &item.0);
                    self.counts[axis][bin] += 1;
                }
            }
        });
    }

    /// Returns axis and plane of the cheapest split; `None` if all centres lie in one bin.
    fn cheapest_split<S: Simd>(&self, simd: S, grid: &Grid, cost: impl Fn(u32) -> f32) -> Option<(usize, usize)> {
        vectorize!(simd, {
            let (mut least, mut best) = (f32::INFINITY, None);
            for (axis, (bounds, counts)) in self.bounds.iter().zip(&self.counts).enumerate() {
                // If a side is empty, its cost is infinite or NaN, which is never the least.
                let mut right = [0.0; BINS];
                let (mut around, mut count) = (Bounds::EMPTY, 0);
                for plane in (1..grid.bins).rev() {
                    around.add(simd, &bounds[plane].0);
                    count += counts[plane];
                    right[plane] = around.half_area() * cost(count);
                }
                let (mut around, mut count) = (Bounds::EMPTY, 0);
                for plane in 1..grid.bins {
                    around.add(simd, &bounds[plane - 1].0);
                    count += counts[plane - 1];
                    let cost = around.half_area() * cost(count) + right[plane];
                    if cost < least {
                        (least, best) = (cost, Some((axis, plane)));
                    }
                }
            }
            best
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Baseline, InstructionSet};

    fn simd() -> Baseline {
        InstructionSet::baseline_token()
    }

    #[test]
    fn items_are_split_between_two_clusters() {
        let place = |number: u32| (number * 37 % 64) as f32 / 64.0 - if number < 33 { 3.0 } else { 0.0 };
        let item = |number| Item::new(number, &[place(number), 0.0, 0.0, place(number), 0.5, 0.5]);
        let mut items: Vec<Item> = (0..99).rev().map(item).collect();
        let around = Enclosing::of(simd(), &items);
        let (first, sides) = split(simd(), &mut items, &around, |count| count as f32);
        assert_eq!(first, 33);
        assert!(items[..first].iter().all(|item| item.number() < 33));
        let [left, right] = sides;
        assert!(left.boxes.planes()[3] < 0.0 && right.boxes.planes()[0] >= 0.0);
        let again = Enclosing::of(simd(), &items[first..]);
        assert_eq!((again.boxes.0[..3].to_vec(), again.centers.0), (right.boxes.0[..3].to_vec(), right.centers.0));
    }

    #[test]
    fn coinciding_items_are_halved() {
        let mut items: Vec<Item> =
            (0..7).map(|number| Item::new(number, &[0.0, 0.0, 0.0, 0.5, 0.5, 0.5])).collect();
        let around = Enclosing::of(simd(), &items);
        assert_eq!(split(simd(), &mut items, &around, |count| count as f32).0, 3);
    }
}
