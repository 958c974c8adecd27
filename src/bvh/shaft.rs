//! [`Shaft`]: what encloses many rays, for discarding boxes that none of them meets, eight at once.

use super::beam::{Beam, GROUPS};
use super::range::Range;
use super::simd::{Lanes, WIDTH};
use crate::objects::run::RUN;

/// What a shaft is widened by: its corners are computed from rays within 6 of the middle, in four roundings.
const SHAFT_MARGIN: f32 = 1.0 / (1 << 18) as f32;

/// What encloses a beam: along one axis, which all rays run along in the same sense, the range of the other two.
pub struct Shaft {
    axis: usize,
    /// -1 where the rays run towards smaller coordinates.
    sign: f32,
    /// Signed coordinates along the axis at which the first ray starts, and the last.
    first: f32,
    last: f32,
    /// For the other two axes, in cyclic order: the range at `first`, and that of the change for each unit of way.
    at_first: [(f32, f32); 2],
    slope: [(f32, f32); 2],
}

impl Shaft {
    /// Around the rays of a mask; `None` for rays that have no direction in common.
    #[inline(always)]
    pub fn around<L: Lanes>(l: L, beam: &Beam, mask: u64) -> Option<Self> {
        let some = beam.ray(mask.trailing_zeros() as usize % RUN).direction;
        let axis = (0..3).find(|&axis| some[axis].abs() >= 0.99)?;
        let sign = 1f32.copysign(some[axis]);
        let signs = l.splat(sign);
        let mut starts = Range::empty(l);
        for group in 0..GROUPS {
            let bits = (mask >> (WIDTH * group) & 0xff) as u32;
            let along = l.mul(l.load(&beam.direction[axis][group]), signs);
            if l.bits(l.le(along, l.splat(0.25))) & bits != 0 {
                return None;
            }
            starts.widen(l, l.mask(bits), l.mul(l.load(&beam.origin[axis][group]), signs));
        }
        let (first, last) = starts.ends(l);
        let others = [(axis + 1) % 3, (axis + 2) % 3];
        let mut at_first = [Range::empty(l), Range::empty(l)];
        let mut slopes = [Range::empty(l), Range::empty(l)];
        for group in 0..GROUPS {
            let here = l.mask((mask >> (WIDTH * group) & 0xff) as u32);
            let way = l.sub(l.splat(first), l.mul(l.load(&beam.origin[axis][group]), signs));
            let per_way = l.mul(l.load(&beam.inverse[axis][group]), signs);
            for (side, &other) in others.iter().enumerate() {
                let slope = l.mul(l.load(&beam.direction[other][group]), per_way);
                slopes[side].widen(l, here, slope);
                at_first[side].widen(l, here, l.mul_add(way, slope, l.load(&beam.origin[other][group])));
            }
        }
        let at_first = [at_first[0].ends(l), at_first[1].ends(l)];
        let at_first = at_first.map(|(low, high)| (low - SHAFT_MARGIN, high + SHAFT_MARGIN));
        Some(Self { axis, sign, first, last, at_first, slope: [slopes[0].ends(l), slopes[1].ends(l)] })
    }

    /// Which of eight boxes (lower and upper planes) the shaft meets at a t up to `limit`, and how far along.
    #[inline(always)]
    pub fn boxes<L: Lanes>(&self, l: L, planes: &[L::F; 6], limit: f32) -> (u32, L::F) {
        let end = self.last + limit + SHAFT_MARGIN;
        let zero = l.splat(0.0);
        let sign = l.splat(self.sign);
        let axis = self.axis % 3;
        let (near, far) = if self.sign < 0.0 { (axis + 3, axis) } else { (axis, axis + 3) };
        let first = l.splat(self.first);
        let enter = l.max(l.mul_sub(planes[near], sign, first), zero);
        let leave = l.mul_sub(planes[far], sign, first);
        let mut met = l.and(l.le(zero, leave), l.le(enter, l.splat(end - self.first)));
        for side in 0..2 {
            let other = (axis + 1 + side) % 3;
            let (low_slope, high_slope) = (l.splat(self.slope[side].0), l.splat(self.slope[side].1));
            let low = l.min(l.mul(enter, low_slope), l.mul(leave, low_slope));
            let high = l.max(l.mul(enter, high_slope), l.mul(leave, high_slope));
            let low = l.add(l.splat(self.at_first[side].0), low);
            let high = l.add(l.splat(self.at_first[side].1), high);
            met = l.and(met, l.and(l.le(low, planes[other + 3]), l.le(planes[other], high)));
        }
        (l.bits(met), enter)
    }
}
