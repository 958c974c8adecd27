//! Splits items in two by the surface area heuristic: [`Item`]s in, the cheapest of several splits out.
//!
//! The centres of the items are sorted into bins (Wald: On fast Construction of SAH-based Bounding Volume
//! Hierarchies, 2007). Nothing depends on the number of threads or on the instruction set: minima and counts are the
//! same in any order.

use super::space::Planes;
use crate::simd::{Eight, Simd, WIDTH, load, splat, vectorize};
use fearless_simd::prelude::*;
use rayon::prelude::*;
use std::array::from_fn;

/// Largest number of bins on an axis.
const BINS: usize = 16;
/// Longer ranges of items are divided among threads.
pub const PARALLEL_ITEMS: usize = 1 << 14;

/// A box as eight numbers: lower x, y, z and one unused, then the negated upper x, y, z and one unused. So the box
/// around two boxes is one minimum of vectors.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Bounds(Eight);

impl Bounds {
    const EMPTY: Self = Self([f32::INFINITY; WIDTH]);

    pub fn planes(&self) -> Planes {
        let [a, b, c, _, d, e, f, _] = self.0;
        [a, b, c, -d, -e, -f]
    }

    /// Returns half of the box's surface area; infinite for an empty box.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let [x, y, z]: [f32; 3] = from_fn(|axis| self.0[axis] + self.0[axis + 4]);
        x * y + y * z + z * x
    }

    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, other: &Eight) {
        load(simd, other).min(load(simd, &self.0)).store_array(&mut self.0);
    }

    fn merged(self, other: Self) -> Self {
        Self(from_fn(|i| self.0[i].min(other.0[i])))
    }
}

/// An item of a tree: its box in culling space, and its number, stored in two halves in the unused numbers of the
/// box.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Item(Eight);

impl Item {
    pub fn new(number: u32, planes: &Planes) -> Self {
        let [a, b, c, d, e, f] = *planes;
        Self([a, b, c, (number & 0xffff) as f32, -d, -e, -f, (number >> 16) as f32])
    }

    pub fn number(&self) -> u32 {
        self.0[3] as u32 | (self.0[7] as u32) << 16
    }

    /// Returns twice the centre, as a box.
    #[inline(always)]
    fn center(&self) -> Eight {
        from_fn(|i| self.0[i] - self.0[(i + 4) % WIDTH])
    }
}

/// The box around items, and the box around twice their centres.
#[derive(Clone, Copy, Debug)]
pub struct Enclosing {
    pub boxes: Bounds,
    centers: Bounds,
}

impl Enclosing {
    const EMPTY: Self = Self { boxes: Bounds::EMPTY, centers: Bounds::EMPTY };

    pub fn of<S: Simd>(simd: S, items: &[Item]) -> Self {
        let of_part = |items: &[Item]| {
            vectorize!(simd, {
                let mut enclosing = Self::EMPTY;
                for item in items {
                    enclosing.boxes.add(simd, &item.0);
                    enclosing.centers.add(simd, &item.center());
                }
                enclosing
            })
        };
        let merged =
            |a: Self, b: Self| Self { boxes: a.boxes.merged(b.boxes), centers: a.centers.merged(b.centers) };
        items.par_chunks(PARALLEL_ITEMS).map(of_part).reduce(|| Self::EMPTY, merged)
    }
}

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
    if items.len() <= 4 * PARALLEL_ITEMS {
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

/// Sorts centres into bins along each axis.
struct Grid {
    low: [f32; 4],
    per_length: [f32; 4],
    bins: usize,
}

impl Grid {
    fn new(centers: &Bounds, items: usize) -> Self {
        // Few items need few bins: the search over the bins would be most of the work.
        let bins = BINS.min(8 + items / 16).min(2 * items);
        let low = from_fn(|axis| if axis < 3 { centers.0[axis] } else { 0.0 });
        let per_length = |axis: usize| {
            let extent = -centers.0[axis + 4] - centers.0[axis];
            let per_length = 0.999 * bins as f32 / extent;
            // If all centres have one coordinate, all items fall into bin 0, and no split is found.
            if axis < 3 && per_length.is_finite() { per_length } else { 0.0 }
        };
        Self { low, per_length: from_fn(per_length), bins }
    }

    #[inline(always)]
    fn bin_of(&self, item: &Item, axis: usize) -> usize {
        // A number from -1/2 to 15.5 plus this constant has the rounded number in its last bits. This is faster than
        // a conversion to an integer.
        const ROUNDED: f32 = (3 << 22) as f32;
        let axis = axis % 4;
        let place = (item.0[axis] - item.0[axis + 4] - self.low[axis]) * self.per_length[axis] - 0.5;
        (place + ROUNDED).to_bits() as usize % BINS
    }
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

/// Moves the items whose bin on `axis` is below `plane` to the front. Returns their number, and the boxes around
/// twice the centres of each part.
fn partition<S: Simd>(
    simd: S,
    items: &mut [Item],
    grid: &Grid,
    axis: usize,
    plane: usize,
) -> (usize, [Bounds; 2]) {
    vectorize!(simd, {
        let mut centers = [splat(simd, f32::INFINITY); 2];
        let mut first = 0;
        for place in 0..items.len() {
            // No branch, because the side of the next item cannot be predicted.
            let item = items[place];
            let is_first = grid.bin_of(&item, axis).wrapping_sub(plane) >> (usize::BITS - 1);
            items[place] = items[first];
            items[first] = item;
            first += is_first;
            let center = load(simd, &item.center());
            let lift = splat(simd, f32::from_bits(f32::INFINITY.to_bits() | (is_first as u32) << 31));
            centers[0] = centers[0].min(center.max(lift));
            centers[1] = centers[1].min(center.max(-lift));
        }
        let stored = centers.map(|center| {
            let mut bounds = Bounds::EMPTY;
            center.store_array(&mut bounds.0);
            bounds
        });
        (first, stored)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Baseline, InstructionSet};

    fn simd() -> Baseline {
        InstructionSet::baseline_token()
    }

    #[test]
    fn an_item_keeps_its_box_and_its_number() {
        let planes = [-0.5, 0.25, -1.0, 0.5, 0.25, 1.0];
        for number in [0, 1, 0xffff, 0x1_0000, 0x89ab_cdef, u32::MAX] {
            let item = Item::new(number, &planes);
            assert_eq!((item.number(), Enclosing::of(simd(), &[item]).boxes.planes()), (number, planes));
        }
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
