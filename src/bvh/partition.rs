//! Sorts items into bins ([`Grid`]), and to the two sides of a plane ([`partition`]).

use super::item::{Bounds, ITEMS_IN_ONE_PIECE, Item, PARALLEL_ITEMS};
use crate::simd::{Simd, load, splat, vectorize};
use fearless_simd::prelude::*;
use rayon::prelude::*;
use std::array::from_fn;
use std::ops::Range;

/// Largest number of bins on an axis.
pub const BINS: usize = 16;

/// Sorts centres into bins along each axis.
pub struct Grid {
    low: [f32; 4],
    per_length: [f32; 4],
    pub bins: usize,
}

impl Grid {
    pub fn new(centers: &Bounds, items: usize) -> Self {
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
    pub fn bin_of(&self, item: &Item, axis: usize) -> usize {
        // A number from -1/2 to 15.5 plus this constant has the rounded number in its last bits. This is faster than
        // a conversion to an integer.
        const ROUNDED: f32 = (3 << 22) as f32;
        let axis = axis % 4;
        let place = (item.0[axis] - item.0[axis + 4] - self.low[axis]) * self.per_length[axis] - 0.5;
        (place + ROUNDED).to_bits() as usize % BINS
    }
}

/// Moves the items whose bin on `axis` is below `plane` to the front. Returns their number, and the boxes around
/// twice the centres of each part. Long ranges are sorted in pieces, by all threads; the order of the items does not depend
/// on their number.
pub fn partition<S: Simd>(
    simd: S,
    items: &mut [Item],
    grid: &Grid,
    axis: usize,
    plane: usize,
) -> (usize, [Bounds; 2]) {
    if items.len() <= ITEMS_IN_ONE_PIECE {
        return partition_piece(simd, items, grid, axis, plane);
    }
    let pieces = items.par_chunks_mut(PARALLEL_ITEMS);
    let sorted: Vec<_> = pieces.map(|piece| partition_piece(simd, piece, grid, axis, plane)).collect();
    let counts: Vec<usize> = sorted.iter().map(|(count, _)| *count).collect();
    join_pieces(items, &counts);
    let around = |side: usize| sorted.iter().fold(Bounds::EMPTY, |all, (_, bounds)| all.merged(bounds[side]));
    (counts.iter().sum(), [around(0), around(1)])
}

fn partition_piece<S: Simd>(
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

/// Moves the items of the first part to the front. Each piece of [`PARALLEL_ITEMS`] items begins with so many of them.
fn join_pieces(items: &mut [Item], counts: &[usize]) {
    let (first, end) = (counts.iter().sum::<usize>(), items.len());
    let pieces = || counts.iter().enumerate().map(|(number, count)| (number * PARALLEL_ITEMS, count));
    let too_early = pieces().map(|(start, count)| start + count..first.min(start + PARALLEL_ITEMS));
    let too_late = pieces().map(|(start, count)| start.max(first)..end.min(start + count));
    let (front, back) = items.split_at_mut(first);
    let too_early = slices(front, too_early);
    let too_late =
        slices(back, too_late.map(|range| range.start.saturating_sub(first)..range.end.saturating_sub(first)));
    pairs(too_early, too_late).into_par_iter().for_each(|(a, b)| a.swap_with_slice(b));
}

/// Returns the slices of ranges that follow one another; empty ranges, which may lie anywhere, are left out.
fn slices(mut items: &mut [Item], ranges: impl Iterator<Item = Range<usize>>) -> Vec<&mut [Item]> {
    let (mut passed, mut slices) = (0, Vec::new());
    for range in ranges.filter(|range| !range.is_empty()) {
        let (slice, after) = items[range.start - passed..].split_at_mut(range.len());
        (items, passed) = (after, range.end);
        slices.push(slice);
    }
    slices
}

/// Cuts slices, which have the same length in sum, so that each has a partner of its length.
fn pairs<'a>(a: Vec<&'a mut [Item]>, b: Vec<&'a mut [Item]>) -> Vec<(&'a mut [Item], &'a mut [Item])> {
    let (mut others, mut other, mut pairs) = (b.into_iter(), <&mut [Item]>::default(), Vec::new());
    for mut slice in a {
        while !slice.is_empty() {
            if other.is_empty() {
                other = others.next().unwrap_or_default();
            }
            let length = slice.len().min(other.len());
            let ((one, rest), (two, others_rest)) = (slice.split_at_mut(length), other.split_at_mut(length));
            pairs.push((one, two));
            (slice, other) = (rest, others_rest);
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::super::item::Enclosing;
    use super::*;
    use crate::simd::InstructionSet;

    #[test]
    fn long_ranges_are_partitioned_by_all_threads() {
        let simd = InstructionSet::baseline_token();
        let place = |number: u32| (number.wrapping_mul(0x9e37_79b9) >> 8) as f32 / (1 << 24) as f32;
        let length = 7 * PARALLEL_ITEMS as u32 + 123;
        // Bins are a sixteenth each. Pieces that belong to one side as a whole, and pieces that are mixed.
        let places: [&dyn Fn(u32) -> f32; 3] =
            [&place, &|number| place(number).sqrt().sqrt(), &|number| (length - number) as f32 / length as f32];
        for place in places {
            let item = |number| Item::new(number, &[place(number), 0.0, 0.0, place(number), 0.5, 0.5]);
            let mut items: Vec<Item> = (0..length).map(item).collect();
            let grid = Grid::new(&Enclosing::of(simd, &items).centers, items.len());
            for plane in [1, 8, 15] {
                let (first, centers) = partition(simd, &mut items, &grid, 0, plane);
                let (left, right) = items.split_at(first);
                assert!(left.iter().all(|item| grid.bin_of(item, 0) < plane));
                assert!(right.iter().all(|item| grid.bin_of(item, 0) >= plane));
                let around = [left, right].map(|side| Enclosing::of(simd, side).centers);
                assert_eq!(centers.map(|side| side.0), around.map(|side| side.0));
                let mut numbers: Vec<u32> = items.iter().map(Item::number).collect();
                numbers.sort_unstable();
                assert!(numbers.into_iter().eq(0..length));
            }
        }
    }
}
