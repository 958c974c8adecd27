//! [`CullingPacket`]: the rays of a packet in culling space.

use super::single::DONE;
use super::space::{self, CullingRay, CullingSpace, Planes};
use crate::simd::packet::{PACKET, RayPacket, Scalars, has_lane, lanes_in, span};
use crate::simd::{Eight, Simd, WIDTH, bits_of, f32x8, load, load3, splat, vectorize};
use fearless_simd::prelude::*;
use vecmath::Real;

/// Number of groups of eight lanes in a packet.
pub const GROUPS: usize = PACKET / WIDTH;
/// A number for each lane.
pub type Lanes = [Eight; GROUPS];

/// Rays in culling space, lane by lane. A lane without a ray has the limit [`DONE`], and so has a lane whose query is
/// finished.
pub struct CullingPacket {
    pub origin: [Lanes; 3],
    pub direction: [Lanes; 3],
    pub inverse: [Lanes; 3],
    pub origin_times_inverse: [Lanes; 3],
    pub limit: Lanes,
    /// See [`CullingRay`].
    start: Scalars,
    rate: Scalars,
}

impl CullingPacket {
    /// A packet without rays.
    pub const EMPTY: Self = Self {
        origin: [[[0.0; WIDTH]; GROUPS]; 3],
        direction: [[[1.0; WIDTH]; GROUPS]; 3],
        inverse: [[[1.0; WIDTH]; GROUPS]; 3],
        origin_times_inverse: [[[0.0; WIDTH]; GROUPS]; 3],
        limit: [[DONE; WIDTH]; GROUPS],
        start: [0.0; PACKET],
        rate: [1.0; PACKET],
    };

    /// Fills the packet with the rays of the active lanes that enter the space within their `t_max`. Returns the mask
    /// of these lanes, and the mask of unbounded rays that may meet an item: for these every item must be tested.
    pub fn enter<S: Simd>(
        &mut self,
        simd: S,
        space: &CullingSpace,
        rays: &RayPacket,
        active: u64,
        t_max: &Scalars,
    ) -> (u64, u64) {
        let (entered, unbounded) = self.enter_bounded(simd, space, rays, active, t_max);
        // Not in the vectorised loop, because a call there would keep it from being vectorised.
        let grazing = lanes_in(unbounded).filter(|&lane| space.may_graze(&rays.get_prepared(lane), t_max[lane]));
        (entered, grazing.fold(0, |mask, lane| mask | 1 << lane))
    }

    /// Does the work of [`enter`](Self::enter) for bounded rays. Returns the mask of lanes that have entered, and the
    /// mask of all unbounded rays.
    fn enter_bounded<S: Simd>(
        &mut self,
        simd: S,
        space: &CullingSpace,
        rays: &RayPacket,
        active: u64,
        t_max: &Scalars,
    ) -> (u64, u64) {
        vectorize!(simd, {
            self.limit = Self::EMPTY.limit;
            // 0: missed, 1: entered, 2: unbounded.
            let mut states = [[0.0f32; WIDTH]; GROUPS];
            // Not in `self`, because the compiler does not see that these `f64` do not overlap its `f32`.
            let (mut start, mut rate) = ([0.0; PACKET], [1.0; PACKET]);
            for lane in span(active) {
                let ray = rays.get_prepared(lane);
                let (meets, entry) = space.bounds().entry_branchless(&ray, 0.0, t_max[lane]);
                // An inactive lane must stay out: its ray would make the packet visit more nodes.
                let is_active = has_lane(active, lane);
                let is_bounded = space.is_bounded(&ray.ray);
                let moved = space.moved(&ray, entry);
                let limit = moved.limit(t_max[lane]);
                let state = if meets { 1.0 } else { 0.0 };
                let state = if is_bounded { state } else { 2.0 };
                states.as_flattened_mut()[lane] = if is_active { state } else { 0.0 };
                (start[lane], rate[lane]) = (moved.start, moved.rate);
                self.set(lane, &moved, if meets & is_bounded & is_active { limit } else { DONE });
            }
            (self.start, self.rate) = (start, rate);
            let (mut entered, mut unbounded) = (0, 0);
            for (group, states) in states.iter().enumerate() {
                let states = load(simd, states);
                let from_one = u64::from(bits_of(splat(simd, 1.0).simd_le(states)));
                let from_two = u64::from(bits_of(splat(simd, 2.0).simd_le(states)));
                entered |= (from_one & !from_two) << (WIDTH * group);
                unbounded |= from_two << (WIDTH * group);
            }
            (entered, unbounded)
        })
    }

    /// Sets everything of a ray but its start and rate.
    #[inline(always)]
    fn set(&mut self, lane: usize, ray: &CullingRay, limit: f32) {
        for (axis, product) in ray.origin_times_inverse().into_iter().enumerate() {
            self.origin[axis].as_flattened_mut()[lane] = ray.origin[axis];
            self.direction[axis].as_flattened_mut()[lane] = ray.direction[axis];
            self.inverse[axis].as_flattened_mut()[lane] = ray.inverse[axis];
            self.origin_times_inverse[axis].as_flattened_mut()[lane] = product;
        }
        self.limit.as_flattened_mut()[lane] = limit;
    }

    #[inline(always)]
    pub fn ray(&self, lane: usize) -> CullingRay {
        let of = |lanes: &[Lanes; 3]| [0, 1, 2].map(|axis| lanes[axis].as_flattened()[lane]);
        CullingRay {
            origin: of(&self.origin),
            direction: of(&self.direction),
            inverse: of(&self.inverse),
            start: self.start[lane],
            rate: self.rate[lane],
        }
    }

    #[inline(always)]
    pub fn limit(&self, lane: usize) -> f32 {
        self.limit.as_flattened()[lane]
    }

    /// Lowers a lane's limit to `t_max` of its ray. Minus infinity ends the query.
    #[inline(always)]
    pub fn set_t_max(&mut self, lane: usize, t_max: Real) {
        self.limit.as_flattened_mut()[lane] = space::limit(t_max, self.start[lane], self.rate[lane]);
    }

    /// Lowers the limits of the active lanes.
    #[inline(always)]
    pub fn set_t_maxes(&mut self, active: u64, t_max: &Scalars) {
        for lane in span(active) {
            let limit = space::limit(t_max[lane], self.start[lane], self.rate[lane]);
            let before = self.limit.as_flattened()[lane];
            self.limit.as_flattened_mut()[lane] = if has_lane(active, lane) { limit } else { before };
        }
    }

    #[inline(always)]
    pub fn largest_limit<S: Simd>(&self, simd: S) -> f32 {
        let mut largest = load(simd, &self.limit[0]);
        for limit in &self.limit[1..] {
            largest = largest.max(load(simd, limit));
        }
        largest.reduce_max()
    }

    /// Copies origin and direction of one ray into all lanes of a vector.
    #[inline(always)]
    pub fn splat_ray<S: Simd>(&self, simd: S, lane: usize) -> [[f32x8<S>; 3]; 2] {
        let of = |lanes: &[Lanes; 3], axis: usize| splat(simd, lanes[axis].as_flattened()[lane]);
        let Self { origin: o, direction: d, .. } = self;
        [[of(o, 0), of(o, 1), of(o, 2)], [of(d, 0), of(d, 1), of(d, 2)]]
    }

    /// Loads origins and directions of a group of eight rays.
    #[inline(always)]
    pub fn load_group<S: Simd>(&self, simd: S, group: usize) -> [[f32x8<S>; 3]; 2] {
        let Self { origin: [x, y, z], direction: [i, j, k], .. } = self;
        [load3(simd, &[x[group], y[group], z[group]]), load3(simd, &[i[group], j[group], k[group]])]
    }
}

/// Intersects the active rays, given by 1 / direction and origin / direction, with one box, eight rays at once. Returns
/// those that meet it at a t from 0 to their `limit`, which is asked for each group of eight.
#[inline(always)]
pub fn intersect_box<S: Simd>(
    simd: S,
    [inverse, origin_times_inverse]: [&[Lanes; 3]; 2],
    planes: &Planes,
    active: u64,
    limit: impl Fn(usize) -> f32x8<S>,
) -> u64 {
    let mut met = 0;
    for group in 0..GROUPS {
        let here = active >> (WIDTH * group) & 0xff;
        if here == 0 {
            continue;
        }
        let (mut near, mut far) = (splat(simd, 0.0), limit(group));
        for axis in 0..3 {
            let inverse = load(simd, &inverse[axis][group]);
            let product = load(simd, &origin_times_inverse[axis][group]);
            let lower = splat(simd, planes[axis]).mul_sub(inverse, product);
            let upper = splat(simd, planes[axis + 3]).mul_sub(inverse, product);
            near = near.max(lower.min(upper));
            far = far.min(lower.max(upper));
        }
        met |= (here & u64::from(bits_of(near.simd_le(far)))) << (WIDTH * group);
    }
    met
}
