//! [`Item`]s in, the cheapest of some ways to part them in two out.
//!
//! Splits are chosen by the surface area heuristic over binned centres (Wald: On fast Construction of SAH-based
//! Bounding Volume Hierarchies, 2007). Nothing depends on the number of threads or on the processor: minima and counts
//! come out the same in any order.

use super::frame::Planes;
use super::simd::{Eight, Lanes, Level, Task, WIDTH};
use rayon::prelude::*;
use std::array::from_fn;

/// Splits are tried at up to so many places an axis.
const BINS: usize = 16;
/// Ranges above this length are shared out among threads.
pub const PARALLEL_ITEMS: usize = 1 << 14;

/// Lower x, y, z and something else, then upper x, y, z with their signs changed and something else: the box around two
/// boxes is one minimum of eight numbers.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Bounds(Eight);

impl Bounds {
    const EMPTY: Self = Self([f32::INFINITY; WIDTH]);

    pub fn planes(&self) -> Planes {
        let [a, b, c, _, d, e, f, _] = self.0;
        [a, b, c, -d, -e, -f]
    }

    /// Infinite for an empty box.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let [x, y, z]: [f32; 3] = from_fn(|axis| self.0[axis] + self.0[axis + 4]);
        x * y + y * z + z * x
    }

    #[inline(always)]
    fn add<L: Lanes>(&mut self, l: L, other: &Eight) {
        l.store(l.min(l.load(other), l.load(&self.0)), &mut self.0);
    }

    fn merged(self, other: Self) -> Self {
        Self(from_fn(|i| self.0[i].min(other.0[i])))
    }
}

/// What is to be put into a tree: its box in the tree's frame, and its number, of which each half is one of the box's
/// two other numbers.
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

    /// Twice the centre as a box.
    #[inline(always)]
    fn center(&self) -> Eight {
        from_fn(|i| self.0[i] - self.0[(i + 4) % WIDTH])
    }
}

/// Boxes around items and around twice their centres.
#[derive(Clone, Copy, Debug)]
pub struct Around {
    pub boxes: Bounds,
    centers: Bounds,
}

impl Around {
    const EMPTY: Self = Self { boxes: Bounds::EMPTY, centers: Bounds::EMPTY };

    pub fn of(items: &[Item]) -> Self {
        let of_part = |items| Level::detected().run(Enclose(items));
        let merged =
            |a: Self, b: Self| Self { boxes: a.boxes.merged(b.boxes), centers: a.centers.merged(b.centers) };
        items.par_chunks(PARALLEL_ITEMS).map(of_part).reduce(|| Self::EMPTY, merged)
    }
}

struct Enclose<'a>(&'a [Item]);

impl Task for Enclose<'_> {
    type Output = Around;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Around {
        let mut around = Around::EMPTY;
        for item in self.0 {
            around.boxes.add(l, &item.0);
            around.centers.add(l, &item.center());
        }
        around
    }
}

/// Sorts items into two parts, neither of them empty: cheapest by the surface area heuristic, or, where all centres
/// coincide, halves. The output is the length of the first and what is around each.
pub fn split(items: &mut [Item], around: &Around, cost: impl Fn(u32) -> f32) -> (usize, [Around; 2]) {
    let grid = Grid::new(&around.centers, items.len());
    let level = Level::detected();
    let fill = |items: &[Item], bins: &mut Bins| level.run(Fill { items, grid: &grid, bins });
    let mut bins = Bins::EMPTY;
    if items.len() <= 4 * PARALLEL_ITEMS {
        fill(items, &mut bins);
    } else {
        let filled = |mut bins: Bins, items: &[Item]| {
            fill(items, &mut bins);
            bins
        };
        let parts = items.par_chunks(PARALLEL_ITEMS).fold(|| Bins::EMPTY, filled);
        bins = parts.reduce(|| Bins::EMPTY, Bins::merged);
    }
    match level.run(Sweep { bins: &bins, grid: &grid, cost }) {
        None => halve(items),
        Some((axis, plane)) => {
            let (first, centers) = level.run(Partition { items, grid: &grid, axis, plane });
            let boxes = bins.sides(axis, plane);
            (first, [0, 1].map(|side| Around { boxes: boxes[side], centers: centers[side] }))
        }
    }
}

/// Parts items by number alone.
pub fn halve(items: &[Item]) -> (usize, [Around; 2]) {
    let (first, second) = items.split_at(items.len() / 2);
    (first.len(), [Around::of(first), Around::of(second)])
}

/// Which bins centres fall into.
struct Grid {
    low: [f32; 4],
    per_length: [f32; 4],
    bins: usize,
}

impl Grid {
    fn new(centers: &Bounds, items: usize) -> Self {
        // Few items need few bins, and looking through them is most of the work then.
        let bins = BINS.min(8 + items / 16).min(2 * items);
        let low = from_fn(|axis| if axis < 3 { centers.0[axis] } else { 0.0 });
        let per_length = |axis: usize| {
            let extent = -centers.0[axis + 4] - centers.0[axis];
            let per_length = 0.999 * bins as f32 / extent;
            // Without extent everything falls into bin 0, and no split is found.
            if axis < 3 && per_length.is_finite() { per_length } else { 0.0 }
        };
        Self { low, per_length: from_fn(per_length), bins }
    }

    #[inline(always)]
    fn bin_of(&self, item: &Item, axis: usize) -> usize {
        // Added to a number from -1/2 to 15.5 it leaves that, rounded, in the last bits: less work than a conversion.
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

    /// What is around the items on either side of a plane.
    fn sides(&self, axis: usize, plane: usize) -> [Bounds; 2] {
        let (left, right) = self.bounds[axis].split_at(plane);
        [left, right].map(|bins| bins.iter().fold(Bounds::EMPTY, |all, bin| all.merged(*bin)))
    }
}

struct Fill<'a> {
    items: &'a [Item],
    grid: &'a Grid,
    bins: &'a mut Bins,
}

impl Task for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        for item in self.items {
            for axis in 0..3 {
                let bin = self.grid.bin_of(item, axis);
                self.bins.bounds[axis][bin].add(l, &item.0);
                self.bins.counts[axis][bin] += 1;
            }
        }
    }
}

/// The axis and the plane of the cheapest split, if the centres lie in more than one bin.
struct Sweep<'a, C> {
    bins: &'a Bins,
    grid: &'a Grid,
    cost: C,
}

impl<C: Fn(u32) -> f32> Task for Sweep<'_, C> {
    type Output = Option<(usize, usize)>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Self::Output {
        let (mut least, mut best) = (f32::INFINITY, None);
        for (axis, (bounds, counts)) in self.bins.bounds.iter().zip(&self.bins.counts).enumerate() {
            // Where a side is empty the product is infinite or NaN, and never the least.
            let mut right = [0.0; BINS];
            let (mut around, mut count) = (Bounds::EMPTY, 0);
            for plane in (1..self.grid.bins).rev() {
                around.add(l, &bounds[plane].0);
                count += counts[plane];
                right[plane] = around.half_area() * (self.cost)(count);
            }
            let (mut around, mut count) = (Bounds::EMPTY, 0);
            for plane in 1..self.grid.bins {
                around.add(l, &bounds[plane - 1].0);
                count += counts[plane - 1];
                let cost = around.half_area() * (self.cost)(count) + right[plane];
                if cost < least {
                    (least, best) = (cost, Some((axis, plane)));
                }
            }
        }
        best
    }
}

/// Puts the items whose bin on `axis` is below `plane` first. The output is how many they are, and what is around the
/// centres of each part.
struct Partition<'a> {
    items: &'a mut [Item],
    grid: &'a Grid,
    axis: usize,
    plane: usize,
}

impl Task for Partition<'_> {
    type Output = (usize, [Bounds; 2]);

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Self::Output {
        let mut centers = [l.splat(f32::INFINITY); 2];
        let mut first = 0;
        for place in 0..self.items.len() {
            // No jumps: which side comes next cannot be foreseen.
            let item = self.items[place];
            let is_first = self.grid.bin_of(&item, self.axis).wrapping_sub(self.plane) >> (usize::BITS - 1);
            self.items[place] = self.items[first];
            self.items[first] = item;
            first += is_first;
            let center = l.load(&item.center());
            let lift = l.splat(f32::from_bits(f32::INFINITY.to_bits() | (is_first as u32) << 31));
            centers[0] = l.min(centers[0], l.max(center, lift));
            centers[1] = l.min(centers[1], l.max(center, l.negated_by(lift, l.splat(-1.0))));
        }
        let stored = centers.map(|center| {
            let mut bounds = Bounds::EMPTY;
            l.store(center, &mut bounds.0);
            bounds
        });
        (first, stored)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_item_keeps_its_box_and_its_number() {
        let planes = [-0.5, 0.25, -1.0, 0.5, 0.25, 1.0];
        for number in [0, 1, 0xffff, 0x1_0000, 0x89ab_cdef, u32::MAX] {
            let item = Item::new(number, &planes);
            assert_eq!((item.number(), Around::of(&[item]).boxes.planes()), (number, planes));
        }
    }

    #[test]
    fn items_are_parted_where_the_gap_is() {
        let place = |number: u32| (number * 37 % 64) as f32 / 64.0 - if number < 33 { 3.0 } else { 0.0 };
        let item = |number| Item::new(number, &[place(number), 0.0, 0.0, place(number), 0.5, 0.5]);
        let mut items: Vec<Item> = (0..99).rev().map(item).collect();
        let around = Around::of(&items);
        let (first, sides) = split(&mut items, &around, |count| count as f32);
        assert_eq!(first, 33);
        assert!(items[..first].iter().all(|item| item.number() < 33));
        let [left, right] = sides;
        assert!(left.boxes.planes()[3] < 0.0 && right.boxes.planes()[0] >= 0.0);
        let again = Around::of(&items[first..]);
        assert_eq!((again.boxes.0[..3].to_vec(), again.centers.0), (right.boxes.0[..3].to_vec(), right.centers.0));
    }

    #[test]
    fn coinciding_items_are_halved() {
        let mut items: Vec<Item> =
            (0..7).map(|number| Item::new(number, &[0.0, 0.0, 0.0, 0.5, 0.5, 0.5])).collect();
        let around = Around::of(&items);
        assert_eq!(split(&mut items, &around, |count| count as f32).0, 3);
    }
}
