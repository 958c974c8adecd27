//! Packets: up to 64 rays that are followed together.
//!
//! This page explains the words that all wide code uses.
//!
//! A *packet* holds what is known of 64 rays, each kind of number in an array of its own ("structure of arrays"). A
//! ray's place in these arrays is its *lane*. A *mask* is a `u64` that says which lanes are meant: bit i stands for
//! lane i. Lanes outside the *active mask* hold numbers too, but nobody looks at them.
//!
//! ```text
//!            lane    0    1    2    3    4    5    6    7    8   ...   63
//! origin.x         [ x0 | x1 | x2 | x3 | x4 | x5 | x6 | x7 | x8 | ... | x63 ]
//! origin.y         [ y0 | y1 | y2 | y3 | y4 | y5 | y6 | y7 | y8 | ... | y63 ]
//! origin.z         [ z0 | z1 | z2 | z3 | z4 | z5 | z6 | z7 | z8 | ... | z63 ]
//!                    '---- one AVX2 register --'
//! active mask        1    1    0    1    1    1    0    1    0   ...    0      = 0b...0_1011_1011
//! span of the mask   '--------- a loop runs over these -----'  whole groups of eight
//! ```
//!
//! A loop over the [`span`] of a mask that calls a scalar formula is compiled to several lanes an instruction, and
//! gives each lane the bits that the formula alone gives. So a formula is written once and is wide all the same.
//!
//! Rays meet a tree in one of three ways. *Single*: one ray by itself. *Packet*: rays that lie side by side go down the
//! tree together and share the tests of boxes. *Stream*: rays with nothing in common each keep a stack of their own, but
//! each step is done for all of them before the next one begins.

use super::{Simd, WIDTH, bits_of, u32x8, vectorize};
use crate::objects::{PreparedRay, Ray};
use fearless_simd::prelude::*;
use vecmath::{Real, Vector3};

/// Lanes of a packet: one for each bit of a mask.
pub const PACKET: usize = 64;

/// A number for each lane.
pub type Scalars = [Real; PACKET];

/// Iterates over the lanes of a mask.
pub fn lanes_in(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = mask.trailing_zeros() as usize;
        let is_any = mask != 0;
        mask &= mask.wrapping_sub(1);
        is_any.then_some(lane % PACKET)
    })
}

/// Returns the mask of the first lanes.
pub fn first_lanes(count: usize) -> u64 {
    match count {
        0 => 0,
        _ => u64::MAX >> (PACKET - count.min(PACKET)),
    }
}

/// Returns the lanes from the first to the last of a mask, rounded outward to whole groups of eight, so that loops need
/// no remainder.
#[inline(always)]
pub fn span(mask: u64) -> std::ops::Range<usize> {
    let (before, after) = (mask.trailing_zeros() as usize & !7, mask.leading_zeros() as usize & !7);
    before..PACKET - after
}

/// Returns whether a loop over the [`span`] of a mask pays, if one ray by itself takes the time of so many lanes of it.
pub fn is_dense(mask: u64, lanes_per_single: usize) -> bool {
    mask != 0 && span(mask).len() < lanes_per_single * mask.count_ones() as usize
}

/// Returns whether a lane is in a mask.
#[inline(always)]
pub fn has_lane(mask: u64, lane: usize) -> bool {
    mask >> lane & 1 == 1
}

/// Returns the lanes with this number.
pub fn lanes_equal<S: Simd>(simd: S, numbers: &[u32; PACKET], number: u32) -> u64 {
    vectorize!(simd, {
        let (groups, _) = numbers.as_chunks();
        groups.iter().enumerate().fold(0, |lanes, (group, numbers)| {
            let is_equal = u32x8::load_array_ref(simd, numbers).simd_eq(u32x8::splat(simd, number));
            lanes | u64::from(bits_of(is_equal)) << (WIDTH * group)
        })
    })
}

/// A vector for each lane, axis by axis.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Vectors(pub [Scalars; 3]);

impl Vectors {
    pub const ZERO: Self = Self([[0.0; PACKET]; 3]);

    /// The same vector in all lanes.
    pub fn splat(vector: Vector3) -> Self {
        Self(vector.to_array().map(|component| [component; PACKET]))
    }

    #[inline(always)]
    pub fn get(&self, lane: usize) -> Vector3 {
        Vector3::new(self.0[0][lane], self.0[1][lane], self.0[2][lane])
    }

    #[inline(always)]
    pub fn set(&mut self, lane: usize, vector: Vector3) {
        self.0[0][lane] = vector.x;
        self.0[1][lane] = vector.y;
        self.0[2][lane] = vector.z;
    }

    /// Normalises the vectors of the active lanes; zero stays zero. Call it inside `vectorize`.
    #[inline(always)]
    pub fn normalize(&mut self, active: u64) {
        let mut all_usual = true;
        for lane in span(active) {
            let vector = self.get(lane);
            let is_usual = vector.is_usual();
            let divisor = if is_usual { vector.length() } else { 1.0 };
            self.set(lane, vector / divisor);
            all_usual &= is_usual;
        }
        if !all_usual {
            self.normalize_unusual(active);
        }
    }

    /// Normalises those whose length is near an end of the range of numbers. All others are unit vectors by now.
    #[cold]
    fn normalize_unusual(&mut self, active: u64) {
        for lane in lanes_in(active) {
            let vector = self.get(lane);
            if !vector.is_usual() {
                self.set(lane, vector.normalized());
            }
        }
    }
}

/// Rays, lane by lane. Lanes that are not active hold rays as well.
#[derive(Clone, Copy, Debug)]
pub struct RayPacket {
    pub origin: Vectors,
    pub direction: Vectors,
    /// 1 / direction, once [`prepare`](Self::prepare) has computed it.
    pub inverse_direction: Vectors,
}

impl RayPacket {
    /// Rays of no interest.
    pub const NONE: Self = Self {
        origin: Vectors::ZERO,
        direction: Vectors([[0.0; PACKET], [0.0; PACKET], [1.0; PACKET]]),
        inverse_direction: Vectors([[Real::INFINITY; PACKET], [Real::INFINITY; PACKET], [1.0; PACKET]]),
    };

    #[inline(always)]
    pub fn get(&self, lane: usize) -> Ray {
        Ray { origin: self.origin.get(lane), direction: self.direction.get(lane) }
    }

    #[inline(always)]
    pub fn set(&mut self, lane: usize, ray: Ray) {
        self.origin.set(lane, ray.origin);
        self.direction.set(lane, ray.direction);
    }

    /// Returns a ray with its reciprocals. The packet must be prepared.
    #[inline(always)]
    pub fn get_prepared(&self, lane: usize) -> PreparedRay {
        PreparedRay { ray: self.get(lane), inverse_direction: self.inverse_direction.get(lane) }
    }

    /// Computes 1 / direction of the active lanes.
    #[inline]
    pub fn prepare<S: Simd>(&mut self, simd: S, active: u64) {
        vectorize!(simd, {
            for lane in span(active) {
                let prepared = PreparedRay::new(self.get(lane));
                self.inverse_direction.set(lane, prepared.inverse_direction);
            }
        });
    }
}

impl FromIterator<Ray> for RayPacket {
    /// Makes a packet of at most 64 rays, in order.
    fn from_iter<I: IntoIterator<Item = Ray>>(iter: I) -> Self {
        let mut packet = Self::NONE;
        iter.into_iter().take(PACKET).enumerate().for_each(|(lane, ray)| packet.set(lane, ray));
        packet
    }
}
