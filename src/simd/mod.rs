//! Processor levels. Whatever runs as a [`Task`] is compiled once for each of them.
//!
//! Culling is written in [`Lanes`], eight `f32` at a time, whose products may be fused with sums or not: what is left is
//! decided elsewhere. Loops over the `Real` numbers of a run are plain arithmetic, which no level fuses, so that their
//! bits are the same at each. The only place of the program with `unsafe` code.
#![allow(unsafe_code)]

#[cfg(target_arch = "x86_64")]
mod avx2;
mod scalar;

use std::fmt;

/// Numbers in a register.
pub const WIDTH: usize = 8;
/// What a register holds, in memory.
pub type Eight = [f32; WIDTH];

/// For each mask of eight bits the places of those that are set.
static PLACES: [[u8; WIDTH]; 256] = {
    let mut places = [[0; WIDTH]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut place, mut count) = (0, 0);
        while place < WIDTH {
            if mask >> place & 1 == 1 {
                places[mask][count] = place as u8;
                count += 1;
            }
            place += 1;
        }
        mask += 1;
    }
    places
};

/// The places of the bits that are set, of the lowest eight; then zeros.
#[inline(always)]
pub fn places_in(bits: u32) -> [u8; WIDTH] {
    PLACES[bits as usize % 256]
}

/// The arithmetic of eight numbers. A value of an implementing type is the proof that the processor has it.
pub trait Lanes: Copy + Send + Sync {
    /// Eight numbers.
    type F: Copy;
    /// Eight times yes or no.
    type M: Copy;

    fn splat(self, value: f32) -> Self::F;
    fn load(self, from: &Eight) -> Self::F;
    fn store(self, value: Self::F, into: &mut Eight);
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    /// a b + c, rounded once or twice.
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// a b - c, rounded once or twice.
    fn mul_sub(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// The smaller one; either one if any is NaN.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// The larger one; either one if any is NaN.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    fn abs(self, a: Self::F) -> Self::F;
    /// `a` with its sign changed where `b` has a minus sign.
    fn negated_by(self, a: Self::F, b: Self::F) -> Self::F;
    /// a <= b; no where any is NaN.
    fn le(self, a: Self::F, b: Self::F) -> Self::M;
    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    fn or(self, a: Self::M, b: Self::M) -> Self::M;
    /// The lanes whose bits are set.
    fn mask(self, bits: u32) -> Self::M;
    /// `a` where the mask says yes, `b` elsewhere.
    fn select(self, mask: Self::M, a: Self::F, b: Self::F) -> Self::F;
    /// Stores the lanes whose bits are set one after the other, and anything after them.
    fn compress(self, bits: u32, value: Self::F, into: &mut Eight);
    /// The same for integers.
    fn compress_bits(self, bits: u32, from: [u32; WIDTH], into: &mut [u32; WIDTH]);
    /// Bit i is lane i's yes.
    fn bits(self, mask: Self::M) -> u32;
    /// The smallest of eight numbers, none of them NaN.
    fn least(self, a: Self::F) -> f32;
    /// The largest of eight numbers, none of them NaN.
    fn greatest(self, a: Self::F) -> f32;
    /// Runs a task compiled for this level.
    fn enter<T: Task>(self, task: T) -> T::Output;
}

/// Work that is compiled once for each level. `run` and everything in it that touches lanes must be
/// `#[inline(always)]`: only what is inlined into [`Lanes::enter`] is compiled for the level.
pub trait Task {
    type Output;
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// A kind of processor that tasks are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Any processor.
    Scalar(scalar::Scalar),
    /// x86-64 with AVX2 and FMA.
    #[cfg(target_arch = "x86_64")]
    Avx2(avx2::Avx2),
}

impl Level {
    /// The names that [`named`](Self::named) knows.
    pub const NAMES: [&str; 2] = ["scalar", "avx2"];

    /// The best level of this processor.
    pub fn detected() -> Self {
        Self::named("avx2").unwrap_or(Self::SCALAR)
    }

    pub const SCALAR: Self = Self::Scalar(scalar::Scalar);

    /// The level of a name, if this processor has it.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "scalar" => Some(Self::SCALAR),
            #[cfg(target_arch = "x86_64")]
            "avx2" => avx2::Avx2::detected().map(Self::Avx2),
            _ => None,
        }
    }

    /// Runs a task at this level.
    #[inline]
    pub fn run<T: Task>(self, task: T) -> T::Output {
        match self {
            Self::Scalar(lanes) => lanes.enter(task),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(lanes) => lanes.enter(task),
        }
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Scalar(_) => "scalar",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => "avx2",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Everything;

    impl Task for Everything {
        type Output = (Vec<Eight>, Vec<u32>);

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Self::Output {
            let a = l.load(&[1.0, -2.0, 3.0, -0.0, 5.0, 6.5, -7.0, 0.0]);
            let b = l.load(&[2.0, -2.0, -3.0, 4.0, -5.0, 0.5, 7.0, -0.0]);
            let c = l.splat(3.0);
            let mut numbers = Vec::new();
            let results = [
                l.add(a, b),
                l.sub(a, b),
                l.mul(a, b),
                l.div(c, l.add(c, l.abs(a))),
                l.mul_add(a, b, c),
                l.mul_sub(a, b, c),
                l.min(a, b),
                l.max(a, b),
                l.abs(a),
                l.negated_by(a, b),
                l.select(l.mask(0b0101_1010), a, b),
            ];
            for result in results {
                let mut eight = [0.0; WIDTH];
                l.store(result, &mut eight);
                numbers.push(eight);
            }
            for bits in [0, 0b1, 0b1000_0000, 0b0110_1001, 0xff] {
                let (mut packed, mut counts) = ([0.0; WIDTH], [0; WIDTH]);
                l.compress(bits, a, &mut packed);
                l.compress_bits(bits, [10, 11, 12, 13, 14, 15, 16, 17], &mut counts);
                // What comes after them may be anything.
                let end = bits.count_ones() as usize;
                packed[end..].fill(0.0);
                counts[end..].fill(0);
                numbers.extend([packed, counts.map(|count| count as f32)]);
            }
            let (x, y) = (l.le(a, b), l.le(c, a));
            assert_eq!((l.least(a), l.greatest(a), l.least(c)), (-7.0, 6.5, 3.0));
            (numbers, vec![l.bits(x), l.bits(y), l.bits(l.and(x, y)), l.bits(l.or(x, y))])
        }
    }

    #[test]
    fn all_levels_compute_the_same() {
        let (numbers, bits) = Level::SCALAR.run(Everything);
        assert_eq!(numbers[4], [5.0, 7.0, -6.0, 3.0, -22.0, 6.25, -46.0, 3.0]);
        let tail = &numbers[numbers.len() - 4..];
        assert_eq!(tail[0], [1.0, -0.0, 6.5, -7.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(tail[1], [10.0, 13.0, 15.0, 16.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(tail[3], [10.0, 11.0, 12.0, 13.0, 14.0, 15.0, 16.0, 17.0]);
        assert_eq!(bits, [0b1100_1011, 0b0011_0100, 0, 0b1111_1111]);
        match Level::named("avx2") {
            Some(level) => assert_eq!(level.run(Everything), (numbers, bits)),
            None => eprintln!("skipped: this processor has no AVX2"),
        }
    }
}
