//! [`Bundle`]: many rays against one box after the other, eight rays at once, before anything is computed in `Real`.
//!
//! Coordinates are relative to the first ray's origin. With e = 2^-24 and m the largest coordinate of the box or of any
//! origin, the position of a plane is off by 2 e m for its rounding and the origin's, 2 e m for the two products and
//! 4 e m for the inverse and the rounding of the direction: [`MARGIN`] is four times that. Rounding keeps order, so that
//! intervals which hold for all rays are no narrower for being computed from rounded ends.

use super::beam::GROUPS;
use super::range::Range;
use super::simd::{Eight, Lanes, Task, WIDTH};
use crate::objects::Aabb;
use crate::objects::run::{RUN, RayRun, around};
use vecmath::{Real, Vector3};

/// Boxes grow by this share of the largest coordinate.
const MARGIN: f32 = 1.0 / (1 << 19) as f32;
/// Beyond these, products might leave the range of `f32`: such rays and boxes are not culled.
const LARGEST_COORDINATE: f32 = 1e12;
const LARGEST_DIRECTION: f32 = 1e6;
/// Components of directions are kept this far from zero, as a share of the largest one.
const SMALLEST_SHARE: f32 = 1.0 / (1u32 << 30) as f32;

/// Up to 64 rays as lanes.
pub struct Bundle {
    center: Vector3,
    inverse: [[Eight; GROUPS]; 3],
    origin_times_inverse: [[Eight; GROUPS]; 3],
    /// Smallest and largest of these, axis by axis.
    ranges: [[(f32, f32); 2]; 3],
    /// The largest coordinate of an origin; NaN where rays cannot be culled.
    reach: f32,
    /// The largest coordinate of an origin in world space, at least.
    world_reach: Real,
}

impl Bundle {
    /// A bundle without rays.
    pub const EMPTY: Self = Self {
        center: Vector3::ZERO,
        inverse: [[[1.0; WIDTH]; GROUPS]; 3],
        origin_times_inverse: [[[0.0; WIDTH]; GROUPS]; 3],
        ranges: [[(0.0, 0.0); 2]; 3],
        reach: 0.0,
        world_reach: 0.0,
    };

    /// Replaces all rays by those of a mask, and some between them.
    #[inline(always)]
    fn set<L: Lanes>(&mut self, l: L, rays: &RayRun, mask: u64) {
        let center = rays.origin.get(mask.trailing_zeros() as usize % RUN);
        // At first, these hold directions and origins.
        let Self { inverse, origin_times_inverse, .. } = self;
        // In the order of memory, which the processor then fetches ahead.
        for (axis, from_center) in origin_times_inverse.iter_mut().enumerate() {
            let center = center.to_array()[axis];
            for number in around(mask) {
                from_center.as_flattened_mut()[number] = (rays.origin.0[axis][number] - center) as f32;
            }
        }
        for (axis, along) in inverse.iter_mut().enumerate() {
            for number in around(mask) {
                along.as_flattened_mut()[number] = rays.direction.0[axis][number] as f32;
            }
        }
        let (mut reach, mut insane) = (l.splat(0.0), 0);
        let mut ranges = [[Range::empty(l); 2]; 3];
        for group in 0..GROUPS {
            let here = (mask >> (WIDTH * group) & 0xff) as u32;
            if here == 0 {
                continue;
            }
            let along = [l.load(&inverse[0][group]), l.load(&inverse[1][group]), l.load(&inverse[2][group])];
            let [x, y, z] = origin_times_inverse;
            let from_center = [l.load(&x[group]), l.load(&y[group]), l.load(&z[group])];
            let largest = l.max(l.max(l.abs(along[0]), l.abs(along[1])), l.abs(along[2]));
            let farthest = l.max(l.max(l.abs(from_center[0]), l.abs(from_center[1])), l.abs(from_center[2]));
            reach = l.max(reach, l.select(l.mask(here), farthest, l.splat(0.0)));
            // `max` passes over NaN, a sum does not.
            let sum = l.add(l.add(along[0], along[1]), along[2]);
            let sum = l.add(l.add(l.add(from_center[0], from_center[1]), from_center[2]), sum);
            let in_range =
                l.and(l.le(l.splat(1.0 / LARGEST_DIRECTION), largest), l.le(largest, l.splat(LARGEST_DIRECTION)));
            insane |= here & !l.bits(l.and(in_range, l.le(l.abs(sum), l.splat(f32::MAX))));
            let smallest = l.mul(largest, l.splat(SMALLEST_SHARE));
            for axis in 0..3 {
                let c = l.negated_by(l.max(l.abs(along[axis]), smallest), along[axis]);
                let inverted = l.div(l.splat(1.0), c);
                let product = l.mul(from_center[axis], inverted);
                l.store(inverted, &mut inverse[axis][group]);
                l.store(product, &mut origin_times_inverse[axis][group]);
                ranges[axis][0].widen(l, l.mask(here), inverted);
                ranges[axis][1].widen(l, l.mask(here), product);
            }
        }
        for (ends, ranges) in self.ranges.iter_mut().zip(ranges) {
            *ends = [ranges[0].ends(l), ranges[1].ends(l)];
        }
        let reach = l.greatest(reach);
        self.center = center;
        self.reach = if insane == 0 { reach } else { f32::NAN };
        // More than rounding to `f32` may have taken away.
        self.world_reach = center.max_abs() + 1.01 * Real::from(reach);
    }
}

impl Bundle {
    /// Whether any of the rays may meet a box at a t from 0 on: by intervals of t that hold for all of them.
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

/// Fills a bundle with the rays of a mask.
pub struct FillBundle<'a> {
    pub bundle: &'a mut Bundle,
    pub rays: &'a RayRun,
    pub mask: u64,
}

impl Task for FillBundle<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        self.bundle.set(l, self.rays, self.mask);
    }
}

/// Which rays of a mask may meet a box, at any t above 0.
pub struct Meeting<'a> {
    pub bundle: &'a Bundle,
    pub bounds: &'a Aabb,
    /// How far rounding may move rays sideways before they meet what is in the box, as a share of their origin's largest
    /// coordinate (see [`Object::spread`](crate::objects::Object)).
    pub spread: Real,
    pub mask: u64,
}

impl Task for Meeting<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> u64 {
        let Self { bundle, bounds, spread, mask } = self;
        let lower = (bounds.min - bundle.center).to_array().map(|c| c as f32);
        let upper = (bounds.max - bundle.center).to_array().map(|c| c as f32);
        let largest = lower.iter().chain(&upper).fold(bundle.reach, |largest, c| largest.max(c.abs()));
        // Written so that NaN culls nothing.
        if !(bundle.reach <= LARGEST_COORDINATE && largest <= LARGEST_COORDINATE) {
            return mask;
        }
        // Doubled for its own rounding to `f32`.
        // Below the range of `f32` all of it would be rounding.
        let margin = largest * MARGIN + (2.0 * spread * bundle.world_reach) as f32 + f32::MIN_POSITIVE;
        if !bundle.may_meet(lower.map(|c| c - margin), upper.map(|c| c + margin)) {
            return 0;
        }
        let mut met = 0;
        for group in 0..GROUPS {
            let here = mask >> (WIDTH * group) & 0xff;
            if here == 0 {
                continue;
            }
            let (mut near, mut far) = (l.splat(0.0), l.splat(f32::INFINITY));
            for axis in 0..3 {
                let inverse = l.load(&bundle.inverse[axis][group]);
                let product = l.load(&bundle.origin_times_inverse[axis][group]);
                let a = l.mul_sub(l.splat(lower[axis] - margin), inverse, product);
                let b = l.mul_sub(l.splat(upper[axis] + margin), inverse, product);
                near = l.max(near, l.min(a, b));
                far = l.min(far, l.max(a, b));
            }
            met |= (here & u64::from(l.bits(l.le(near, far)))) << (WIDTH * group);
        }
        met
    }
}
