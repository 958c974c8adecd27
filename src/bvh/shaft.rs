//! [`Shaft`]: encloses the rays of a packet. Eight boxes that no ray meets are discarded by one test against it.

use super::culling_packet::{CullingPacket, GROUPS};
use crate::simd::packet::PACKET;
use crate::simd::{Range, Simd, WIDTH, bits_of, f32x8, load, mask_of, splat};
use fearless_simd::prelude::*;

/// A shaft is widened by this. Its corners are computed in four roundings, from rays within 6 of the middle.
const SHAFT_MARGIN: f32 = 1.0 / (1 << 18) as f32;

/// Bounds on the rays of a packet that run along one axis in the same sense: for each place along that axis, a range of
/// the other two coordinates.
pub struct Shaft {
    axis: usize,
    /// 1, or -1 where the rays run towards smaller coordinates.
    sign: f32,
    /// Signed coordinates along the axis at which the first ray starts, and the last.
    first: f32,
    last: f32,
    /// For the other two axes, in cyclic order: the range at `first`, and the range of the change along the axis.
    at_first: [(f32, f32); 2],
    slope: [(f32, f32); 2],
}

impl Shaft {
    /// Makes the shaft around the active rays; `None` if they have no direction in common.
    #[inline(always)]
    pub fn around<S: Simd>(simd: S, packet: &CullingPacket, active: u64) -> Option<Self> {
        let some = packet.ray(active.trailing_zeros() as usize % PACKET).direction;
        let axis = (0..3).find(|&axis| some[axis].abs() >= 0.99)?;
        let sign = 1f32.copysign(some[axis]);
        let mut starts = Range::empty(simd);
        for group in 0..GROUPS {
            let bits = (active >> (WIDTH * group) & 0xff) as u32;
            let along = load(simd, &packet.direction[axis][group]) * sign;
            if bits_of(along.simd_le(splat(simd, 0.25))) & bits != 0 {
                return None;
            }
            starts.widen(simd, mask_of(simd, bits), load(simd, &packet.origin[axis][group]) * sign);
        }
        let (first, last) = starts.ends();
        let others = [(axis + 1) % 3, (axis + 2) % 3];
        let mut at_first = [Range::empty(simd), Range::empty(simd)];
        let mut slopes = [Range::empty(simd), Range::empty(simd)];
        for group in 0..GROUPS {
            let here = mask_of(simd, (active >> (WIDTH * group) & 0xff) as u32);
            let way = splat(simd, first) - load(simd, &packet.origin[axis][group]) * sign;
            let per_way = load(simd, &packet.inverse[axis][group]) * sign;
            for (side, &other) in others.iter().enumerate() {
                let slope = load(simd, &packet.direction[other][group]) * per_way;
                slopes[side].widen(simd, here, slope);
                at_first[side].widen(simd, here, way.mul_add(slope, load(simd, &packet.origin[other][group])));
            }
        }
        let at_first = [at_first[0].ends(), at_first[1].ends()];
        let at_first = at_first.map(|(low, high)| (low - SHAFT_MARGIN, high + SHAFT_MARGIN));
        Some(Self { axis, sign, first, last, at_first, slope: [slopes[0].ends(), slopes[1].ends()] })
    }

    /// Returns how far along the rays are at a t of `limit`, at most.
    #[inline(always)]
    pub fn end(&self, limit: f32) -> f32 {
        self.last + limit + SHAFT_MARGIN - self.first
    }

    /// Intersects the shaft with eight boxes (lower and upper planes): which ones it meets at a t up to `limit`, which of
    /// these it stays within sideways, and how far along each begins.
    #[inline(always)]
    pub fn intersect<S: Simd>(&self, simd: S, planes: &[f32x8<S>; 6], limit: f32) -> (u32, u32, f32x8<S>) {
        let (zero, sign, first) = (splat(simd, 0.0), splat(simd, self.sign), splat(simd, self.first));
        let axis = self.axis % 3;
        let (near, far) = if self.sign < 0.0 { (axis + 3, axis) } else { (axis, axis + 3) };
        let enter = planes[near].mul_sub(sign, first).max(zero);
        let leave = planes[far].mul_sub(sign, first);
        let mut met = zero.simd_le(leave) & enter.simd_le(splat(simd, self.end(limit)));
        let mut within = met;
        for side in 0..2 {
            let other = (axis + 1 + side) % 3;
            let (low_slope, high_slope) = (splat(simd, self.slope[side].0), splat(simd, self.slope[side].1));
            let low = (enter * low_slope).min(leave * low_slope);
            let high = (enter * high_slope).max(leave * high_slope);
            let low = splat(simd, self.at_first[side].0) + low;
            let high = splat(simd, self.at_first[side].1) + high;
            met = met & low.simd_le(planes[other + 3]) & planes[other].simd_le(high);
            within = within & high.simd_le(planes[other + 3]) & planes[other].simd_le(low);
        }
        (bits_of(met), bits_of(within), enter)
    }
}
