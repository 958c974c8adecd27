//! [`Range`]: the smallest and the largest of many numbers.

use super::{Simd, f32x8, mask32x8, splat};
use fearless_simd::prelude::*;

/// The smallest and the largest numbers so far, lane by lane.
#[derive(Clone, Copy)]
pub struct Range<S: Simd> {
    low: f32x8<S>,
    high: f32x8<S>,
}

impl<S: Simd> Range<S> {
    #[inline(always)]
    pub fn empty(simd: S) -> Self {
        Self { low: splat(simd, f32::INFINITY), high: splat(simd, f32::NEG_INFINITY) }
    }

    /// Takes in the numbers of the active lanes, none of them NaN.
    #[inline(always)]
    pub fn widen(&mut self, simd: S, active: mask32x8<S>, value: f32x8<S>) {
        self.low = self.low.min(active.select(value, splat(simd, f32::INFINITY)));
        self.high = self.high.max(active.select(value, splat(simd, f32::NEG_INFINITY)));
    }

    /// Returns the smallest and the largest number of all lanes.
    #[inline(always)]
    pub fn ends(&self) -> (f32, f32) {
        (self.low.reduce_min(), self.high.reduce_max())
    }
}
