//! [`PacketBounds`]: tests the rays of a packet against one object's box in world space, eight rays at once, before
//! anything is computed in `Real`.
//!
//! Coordinates are relative to the first ray's origin. With e = 2^-24 and m the largest coordinate of the box or of any
//! origin, the error of a plane's position is 2 e m for its rounding and the origin's, 2 e m for the two products and
//! 4 e m for the inverse and the rounding of the direction. [`MARGIN`] is four times that. Rounding keeps order, so
//! intervals that hold for all rays are not narrower for being computed from rounded ends.

use super::culling_packet::{GROUPS, Lanes, intersect_box};
use crate::objects::Aabb;
use crate::simd::packet::{PACKET, RayPacket, span};
use crate::simd::{Range, Simd, WIDTH, bits_of, flip_sign, load3, mask_of, splat, vectorize};
use fearless_simd::prelude::*;
use vecmath::{Real, Vector3};

/// Boxes grow by this share of the largest coordinate.
const MARGIN: f32 = 1.0 / (1 << 19) as f32;
/// Beyond these, products might leave the range of `f32`. Such rays and boxes are not culled.
const LARGEST_COORDINATE: f32 = 1e12;
const LARGEST_DIRECTION: f32 = 1e6;
/// Components of directions are kept this far from zero, as a share of the largest one.
const SMALLEST_SHARE: f32 = 1.0 / (1u32 << 30) as f32;

/// The rays of a packet, rounded to `f32`, and the ranges of their numbers.
pub struct PacketBounds {
    center: Vector3,
    inverse: [Lanes; 3],
    origin_times_inverse: [Lanes; 3],
    /// Smallest and largest of these over all rays, axis by axis.
    ranges: [[(f32, f32); 2]; 3],
    /// The largest coordinate of an origin; NaN if the rays cannot be culled.
    reach: f32,
    /// At least the largest coordinate of an origin in world space.
    world_reach: Real,
}

impl PacketBounds {
    /// Bounds of no rays.
    pub const EMPTY: Self = Self {
        center: Vector3::ZERO,
        inverse: [[[1.0; WIDTH]; GROUPS]; 3],
        origin_times_inverse: [[[0.0; WIDTH]; GROUPS]; 3],
        ranges: [[(0.0, 0.0); 2]; 3],
        reach: 0.0,
        world_reach: 0.0,
    };

    /// Replaces all rays by the active ones.
    pub fn fill<S: Simd>(&mut self, simd: S, rays: &RayPacket, active: u64) {
        vectorize!(simd, {
            self.round_rays(rays, active);
            self.invert(simd, active);
        });
    }

    /// Rounds origins and directions. They are put where [`invert`](Self::invert) replaces them by what is tested.
    #[inline(always)]
    fn round_rays(&mut self, rays: &RayPacket, active: u64) {
        self.center = rays.origin.get(active.trailing_zeros() as usize % PACKET);
        // In the order of memory, which the processor then fetches ahead.
        for (axis, from_center) in self.origin_times_inverse.iter_mut().enumerate() {
            let center = self.center.to_array()[axis];
            for lane in span(active) {
                from_center.as_flattened_mut()[lane] = (rays.origin.0[axis][lane] - center) as f32;
            }
        }
        for (axis, along) in self.inverse.iter_mut().enumerate() {
            for lane in span(active) {
                along.as_flattened_mut()[lane] = rays.direction.0[axis][lane] as f32;
            }
        }
    }

    #[inline(always)]
    fn invert<S: Simd>(&mut self, simd: S, active: u64) {
        let Self { inverse, origin_times_inverse, .. } = self;
        let (mut reach, mut insane) = (splat(simd, 0.0), 0);
        let mut ranges = [[Range::empty(simd); 2]; 3];
        for group in 0..GROUPS {
            let here = (active >> (WIDTH * group) & 0xff) as u32;
            if here == 0 {
                continue;
            }
            let along = load3(simd, &[inverse[0][group], inverse[1][group], inverse[2][group]]);
            let [x, y, z] = origin_times_inverse;
            let from_center = load3(simd, &[x[group], y[group], z[group]]);
            let largest = along[0].abs().max(along[1].abs()).max(along[2].abs());
            let farthest = from_center[0].abs().max(from_center[1].abs()).max(from_center[2].abs());
            reach = reach.max(mask_of(simd, here).select(farthest, splat(simd, 0.0)));
            // `max` passes over NaN, a sum does not.
            let sum = along[0] + along[1] + along[2];
            let sum = from_center[0] + from_center[1] + from_center[2] + sum;
            let in_range = splat(simd, 1.0 / LARGEST_DIRECTION).simd_le(largest)
                & largest.simd_le(splat(simd, LARGEST_DIRECTION));
            insane |= here & !bits_of(in_range & sum.abs().simd_le(splat(simd, f32::MAX)));
            let smallest = largest * SMALLEST_SHARE;
            for axis in 0..3 {
                let c = flip_sign(simd, along[axis].abs().max(smallest), along[axis]);
                let inverted = splat(simd, 1.0) / c;
                let product = from_center[axis] * inverted;
                inverted.store_array(&mut inverse[axis][group]);
                product.store_array(&mut origin_times_inverse[axis][group]);
                ranges[axis][0].widen(simd, mask_of(simd, here), inverted);
                ranges[axis][1].widen(simd, mask_of(simd, here), product);
            }
        }
        for (ends, ranges) in self.ranges.iter_mut().zip(ranges) {
            *ends = [ranges[0].ends(), ranges[1].ends()];
        }
        let reach = reach.reduce_max();
        self.reach = if insane == 0 { reach } else { f32::NAN };
        // More than rounding to `f32` may have taken away.
        self.world_reach = self.center.max_abs() + 1.01 * Real::from(reach);
    }

    /// Returns at least the largest coordinate of an origin, in world space; infinity if nothing is known of the rays.
    pub fn origin_reach(&self) -> Real {
        if self.reach.is_finite() { self.world_reach } else { Real::INFINITY }
    }

    /// Returns the active rays that may meet a box at any t above 0. `sideways_error` is the object's; see
    /// [`Object`](crate::objects::Object).
    pub fn intersect<S: Simd>(&self, simd: S, bounds: &Aabb, sideways_error: Real, active: u64) -> u64 {
        vectorize!(simd, {
            let lower = (bounds.min - self.center).to_array().map(|c| c as f32);
            let upper = (bounds.max - self.center).to_array().map(|c| c as f32);
            let largest = lower.iter().chain(&upper).fold(self.reach, |largest, c| largest.max(c.abs()));
            // Written so that NaN culls nothing.
            if !(self.reach <= LARGEST_COORDINATE && largest <= LARGEST_COORDINATE) {
                return active;
            }
            // The sideways error is doubled for its own rounding to `f32`. Below the range of `f32` all of the margin
            // would be rounding.
            let margin = largest * MARGIN + (2.0 * sideways_error * self.world_reach) as f32 + f32::MIN_POSITIVE;
            let (lower, upper) = (lower.map(|c| c - margin), upper.map(|c| c + margin));
            if !self.may_meet(lower, upper) {
                return 0;
            }
            let ([a, b, c], [d, e, f]) = (lower, upper);
            intersect_box(
                simd,
                [&self.inverse, &self.origin_times_inverse],
                &[a, b, c, d, e, f],
                active,
                #[inline(always)]
                |_| splat(simd, f32::INFINITY),
            )
        })
    }

    /// Returns whether any ray may meet a box at a t from 0 on, by intervals of t that hold for all rays.
    #[inline(always)]
    fn may_meet(&self, lower: [f32; 3], upper: [f32; 3]) -> bool {
        let (mut near, mut far) = (0.0f32, f32::INFINITY);
        for axis in 0..3 {
            let [(least, greatest), product] = self.ranges[axis];
            // Unlike `f32::min`, each is one instruction.
            let min = |a: f32, b: f32| if a < b { a } else { b };
            let max = |a: f32, b: f32| if a > b { a } else { b };
            let (a, b) = (lower[axis] * least, lower[axis] * greatest);
            let (c, d) = (upper[axis] * least, upper[axis] * greatest);
            near = max(near, min(min(a, b), min(c, d)) - product.1);
            far = min(far, max(max(a, b), max(c, d)) - product.0);
        }
        near <= far
    }
}
