//! [`Bundle`]: many rays against one box after the other, eight rays at once, before anything is computed in `Real`.
//!
//! Coordinates are relative to the first ray's origin. With e = 2^-24 and m the largest coordinate of the box or of any
//! origin, the position of a plane is off by 2 e m for its rounding and the origin's, 2 e m for the two products and
//! 4 e m for the inverse and the rounding of the direction: [`MARGIN`] is four times that.

use super::beam::{BEAM_RAYS, GROUPS};
use super::simd::{Eight, Lanes, Task, WIDTH};
use crate::objects::{Aabb, Ray};
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
    /// The largest coordinate of an origin; NaN where rays cannot be culled.
    reach: f32,
    /// The same in world space.
    world_reach: Real,
}

impl Bundle {
    /// A bundle without rays.
    pub const EMPTY: Self = Self {
        center: Vector3::ZERO,
        inverse: [[[1.0; WIDTH]; GROUPS]; 3],
        origin_times_inverse: [[[0.0; WIDTH]; GROUPS]; 3],
        reach: 0.0,
        world_reach: 0.0,
    };

    /// Replaces all rays. Lanes beyond the last one keep what they had: no mask has them.
    #[inline(always)]
    fn set<L: Lanes>(&mut self, l: L, rays: &[Ray]) {
        let center = rays.first().map_or(Vector3::ZERO, |ray| ray.origin);
        // Until the end, these hold directions and origins.
        let Self { inverse: direction, origin_times_inverse: origin, .. } = self;
        let (mut reach, mut world_reach, mut sane) = (0.0f32, 0.0, true);
        for (number, ray) in rays.iter().enumerate().take(BEAM_RAYS) {
            let (group, lane) = (number / WIDTH, number % WIDTH);
            let from_center = (ray.origin - center).to_array().map(|c| c as f32);
            let along = ray.direction.to_array().map(|c| c as f32);
            let largest = along[0].abs().max(along[1].abs()).max(along[2].abs());
            let farthest = from_center[0].abs().max(from_center[1].abs()).max(from_center[2].abs());
            reach = reach.max(farthest);
            world_reach = ray.origin.max_abs().max(world_reach);
            sane &= (1.0 / LARGEST_DIRECTION..LARGEST_DIRECTION).contains(&largest);
            // `max` passes over NaN, a sum does not.
            sane &=
                (from_center[0] + from_center[1] + from_center[2] + along[0] + along[1] + along[2]).is_finite();
            let smallest = largest * SMALLEST_SHARE;
            for axis in 0..3 {
                origin[axis][group][lane] = from_center[axis];
                let c = along[axis];
                direction[axis][group][lane] = if c.abs() >= smallest { c } else { smallest.copysign(c) };
            }
        }
        for axis in 0..3 {
            for group in 0..rays.len().div_ceil(WIDTH).min(GROUPS) {
                let inverse = l.div(l.splat(1.0), l.load(&direction[axis][group]));
                l.store(inverse, &mut direction[axis][group]);
                let product = l.mul(l.load(&origin[axis][group]), inverse);
                l.store(product, &mut origin[axis][group]);
            }
        }
        self.center = center;
        self.reach = if sane { reach } else { f32::NAN };
        self.world_reach = world_reach;
    }
}

/// Fills a bundle with rays.
pub struct FillBundle<'a> {
    pub bundle: &'a mut Bundle,
    pub rays: &'a [Ray],
}

impl Task for FillBundle<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        self.bundle.set(l, self.rays);
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
        let margin = largest * MARGIN + (2.0 * spread * bundle.world_reach) as f32;
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
