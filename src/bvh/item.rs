//! [`Item`]s of a tree, and the boxes around them.

use super::space::Planes;
use crate::simd::{Eight, Simd, WIDTH, load, vectorize};
use fearless_simd::prelude::*;
use rayon::prelude::*;
use std::array::from_fn;

/// Longer ranges of items are divided among threads.
pub const PARALLEL_ITEMS: usize = 1 << 14;
/// So many items, or fewer, are sorted into bins and to the sides of a plane by one thread, without pieces to join.
pub const ITEMS_IN_ONE_PIECE: usize = 4 * PARALLEL_ITEMS;

/// A box as eight numbers: lower x, y, z and one unused, then the negated upper x, y, z and one unused. So the box
/// around two boxes is one minimum of vectors.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Bounds(pub Eight);

impl Bounds {
    pub const EMPTY: Self = Self([f32::INFINITY; WIDTH]);

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
    pub fn add<S: Simd>(&mut self, simd: S, other: &Eight) {
        load(simd, other).min(load(simd, &self.0)).store_array(&mut self.0);
    }

    pub fn merged(self, other: Self) -> Self {
        Self(from_fn(|i| self.0[i].min(other.0[i])))
    }
}

/// An item of a tree: its box in culling space, and its number, stored in two halves in the unused numbers of the
/// box.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Item(pub Eight);

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
    pub fn center(&self) -> Eight {
        from_fn(|i| self.0[i] - self.0[(i + 4) % WIDTH])
    }
}

/// The box around items, and the box around twice their centres.
#[derive(Clone, Copy, Debug)]
pub struct Enclosing {
    pub boxes: Bounds,
    pub centers: Bounds,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::InstructionSet;

    #[test]
    fn an_item_keeps_its_box_and_its_number() {
        let planes = [-0.5, 0.25, -1.0, 0.5, 0.25, 1.0];
        for number in [0, 1, 0xffff, 0x1_0000, 0x89ab_cdef, u32::MAX] {
            let item = Item::new(number, &planes);
            assert_eq!(
                (item.number(), Enclosing::of(InstructionSet::baseline_token(), &[item]).boxes.planes()),
                (number, planes)
            );
        }
    }
}
