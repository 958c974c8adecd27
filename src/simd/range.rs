//! [`Range`]: the smallest and the largest of numbers in lanes.

use super::simd::Lanes;

/// Smallest and largest numbers so far, lane by lane.
#[derive(Clone, Copy)]
pub struct Range<F> {
    low: F,
    high: F,
}

impl<F: Copy> Range<F> {
    #[inline(always)]
    pub fn empty<L: Lanes<F = F>>(l: L) -> Self {
        Self { low: l.splat(f32::INFINITY), high: l.splat(f32::NEG_INFINITY) }
    }

    /// Takes the numbers of a mask in, none of them NaN.
    #[inline(always)]
    pub fn widen<L: Lanes<F = F>>(&mut self, l: L, mask: L::M, value: F) {
        self.low = l.min(self.low, l.select(mask, value, l.splat(f32::INFINITY)));
        self.high = l.max(self.high, l.select(mask, value, l.splat(f32::NEG_INFINITY)));
    }

    /// Of all lanes together.
    #[inline(always)]
    pub fn ends<L: Lanes<F = F>>(&self, l: L) -> (f32, f32) {
        (l.least(self.low), l.greatest(self.high))
    }
}
