//! [`Scalar`]: eight numbers as an array, for every processor.

use super::{Eight, Lanes, Task, WIDTH};
use std::array::from_fn;

/// The level that needs nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scalar;

impl Lanes for Scalar {
    type F = Eight;
    type M = [bool; WIDTH];

    #[inline(always)]
    fn splat(self, value: f32) -> Eight {
        [value; WIDTH]
    }

    #[inline(always)]
    fn load(self, from: &Eight) -> Eight {
        *from
    }

    #[inline(always)]
    fn store(self, value: Eight, into: &mut Eight) {
        *into = value;
    }

    #[inline(always)]
    fn add(self, a: Eight, b: Eight) -> Eight {
        from_fn(|i| a[i] + b[i])
    }

    #[inline(always)]
    fn sub(self, a: Eight, b: Eight) -> Eight {
        from_fn(|i| a[i] - b[i])
    }

    #[inline(always)]
    fn mul(self, a: Eight, b: Eight) -> Eight {
        from_fn(|i| a[i] * b[i])
    }

    #[inline(always)]
    fn div(self, a: Eight, b: Eight) -> Eight {
        from_fn(|i| a[i] / b[i])
    }

    #[inline(always)]
    fn mul_add(self, a: Eight, b: Eight, c: Eight) -> Eight {
        from_fn(|i| a[i] * b[i] + c[i])
    }

    #[inline(always)]
    fn mul_sub(self, a: Eight, b: Eight, c: Eight) -> Eight {
        from_fn(|i| a[i] * b[i] - c[i])
    }

    #[inline(always)]
    fn min(self, a: Eight, b: Eight) -> Eight {
        from_fn(|i| if a[i] < b[i] { a[i] } else { b[i] })
    }

    #[inline(always)]
    fn max(self, a: Eight, b: Eight) -> Eight {
        from_fn(|i| if a[i] > b[i] { a[i] } else { b[i] })
    }

    #[inline(always)]
    fn abs(self, a: Eight) -> Eight {
        a.map(f32::abs)
    }

    #[inline(always)]
    fn negated_by(self, a: Eight, b: Eight) -> Eight {
        from_fn(|i| f32::from_bits(a[i].to_bits() ^ (b[i].to_bits() & 0x8000_0000)))
    }

    #[inline(always)]
    fn le(self, a: Eight, b: Eight) -> Self::M {
        from_fn(|i| a[i] <= b[i])
    }

    #[inline(always)]
    fn and(self, a: Self::M, b: Self::M) -> Self::M {
        from_fn(|i| a[i] & b[i])
    }

    #[inline(always)]
    fn or(self, a: Self::M, b: Self::M) -> Self::M {
        from_fn(|i| a[i] | b[i])
    }

    #[inline(always)]
    fn mask(self, bits: u32) -> Self::M {
        from_fn(|i| bits >> i & 1 == 1)
    }

    #[inline(always)]
    fn select(self, mask: Self::M, a: Eight, b: Eight) -> Eight {
        from_fn(|i| if mask[i] { a[i] } else { b[i] })
    }

    #[inline(always)]
    fn compress(self, mut bits: u32, value: Eight, into: &mut Eight) {
        for number in into {
            *number = value[bits.trailing_zeros() as usize % WIDTH];
            bits &= bits.wrapping_sub(1);
        }
    }

    #[inline(always)]
    fn compress_bits(self, mut bits: u32, from: [u32; WIDTH], into: &mut [u32; WIDTH]) {
        for number in into {
            *number = from[bits.trailing_zeros() as usize % WIDTH];
            bits &= bits.wrapping_sub(1);
        }
    }

    #[inline(always)]
    fn bits(self, mask: Self::M) -> u32 {
        mask.iter().enumerate().fold(0, |bits, (i, &yes)| bits | u32::from(yes) << i)
    }

    #[inline(always)]
    fn least(self, a: Eight) -> f32 {
        a.into_iter().fold(f32::INFINITY, f32::min)
    }

    #[inline(always)]
    fn greatest(self, a: Eight) -> f32 {
        a.into_iter().fold(f32::NEG_INFINITY, f32::max)
    }

    fn enter<T: Task>(self, task: T) -> T::Output {
        task.run(self)
    }
}
