//! Instruction sets of the processor, and the lanes that wide code is written in.
//!
//! Wide code is written once, generic over `S: Simd` of the library `fearless_simd`, and compiled once for each
//! [`InstructionSet`]. A value of such a type is the proof that the processor has the instructions, so nobody here
//! has to promise it. Two kinds of work are done wide:
//!
//! - Culling, in `f32x8`. Its products may be fused with sums or not, so its results may differ between instruction
//!   sets. Nothing that is seen depends on them: what culling leaves over is decided by the exact tests.
//! - Plain loops over the [`Real`](vecmath::Real) arrays of a [`packet`], inside [`vectorize!`]. They call the scalar
//!   formulas, and the compiler makes several rays an instruction of them. It never fuses or reorders, so their bits are
//!   the same for every instruction set.

pub mod packet;
mod range;

pub use fearless_simd::prelude::*;
pub use fearless_simd::{Simd, f32x8, mask32x8, u32x8};
pub use range::Range;

use std::fmt;

/// Lanes of a vector: what AVX2 holds in one register, and SSE2 and NEON in two.
pub const WIDTH: usize = 8;

/// The numbers of a vector in memory.
pub type Eight = [f32; WIDTH];

/// What every processor of the target has.
#[cfg(target_arch = "x86_64")]
pub type Baseline = fearless_simd::x86::Sse2;
#[cfg(target_arch = "aarch64")]
pub type Baseline = fearless_simd::aarch64::Neon;
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
pub type Baseline = fearless_simd::Fallback;

/// An instruction set that wide code is compiled for. Pictures are the same with every one.
#[derive(Clone, Copy, Debug)]
pub enum InstructionSet {
    /// SSE2 on x86-64, NEON on 64-bit Arm.
    Baseline(Baseline),
    /// AVX2 and FMA.
    #[cfg(target_arch = "x86_64")]
    Avx2(fearless_simd::x86::Avx2),
    /// AVX-512 as processors since Ice Lake and Zen 4 have it.
    #[cfg(target_arch = "x86_64")]
    Avx512(fearless_simd::x86::Avx512),
}

/// Evaluates an expression with the token of an instruction set as `$simd`; it is compiled once for each.
#[macro_export]
macro_rules! with_simd {
    ($set:expr, $simd:ident => $body:expr) => {
        match $set {
            $crate::simd::InstructionSet::Baseline($simd) => $body,
            #[cfg(target_arch = "x86_64")]
            $crate::simd::InstructionSet::Avx2($simd) => $body,
            #[cfg(target_arch = "x86_64")]
            $crate::simd::InstructionSet::Avx512($simd) => $body,
        }
    };
}
pub use with_simd;

/// Compiles `$body` for the instruction set of `$simd`. It takes its variables by value, so that their addresses stay
/// unknown and loops vectorise. Only what is inlined is compiled so: hence the `#[inline(always)]` on every function that
/// takes lanes.
macro_rules! vectorize {
    ($simd:expr, $body:expr) => {
        $simd.vectorize(
            #[inline(always)]
            move || $body,
        )
    };
}
pub(crate) use vectorize;

impl InstructionSet {
    /// The names of this target's instruction sets, the slowest first.
    #[cfg(target_arch = "x86_64")]
    pub const NAMES: &[&str] = &["sse2", "avx2", "avx512"];
    #[cfg(target_arch = "aarch64")]
    pub const NAMES: &[&str] = &["neon"];
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    pub const NAMES: &[&str] = &["scalar"];

    /// Iterates over those that this processor has, the slowest first.
    pub fn available() -> impl DoubleEndedIterator<Item = Self> {
        Self::NAMES.iter().filter_map(|name| Self::named(name))
    }

    /// Returns the best one that this processor has.
    pub fn detected() -> Self {
        Self::available().next_back().unwrap_or_else(Self::baseline)
    }

    /// Returns the one that every processor of the target has.
    pub fn baseline() -> Self {
        Self::Baseline(Self::baseline_token())
    }

    /// Returns the token of the [`baseline`](Self::baseline).
    #[cfg(target_arch = "x86_64")]
    pub fn baseline_token() -> Baseline {
        fearless_simd::Level::baseline().as_sse2().expect("SSE2 is part of x86-64")
    }

    /// Returns the token of the [`baseline`](Self::baseline).
    #[cfg(target_arch = "aarch64")]
    pub fn baseline_token() -> Baseline {
        fearless_simd::Level::baseline().as_neon().expect("NEON is part of 64-bit Arm")
    }

    /// Returns the token of the [`baseline`](Self::baseline).
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    pub fn baseline_token() -> Baseline {
        fearless_simd::Fallback::new()
    }

    /// Returns the instruction set of a name, if this processor has it. `scalar` is an older name of the baseline.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            #[cfg(target_arch = "x86_64")]
            "avx512" => fearless_simd::Level::new().as_avx512().map(Self::Avx512),
            #[cfg(target_arch = "x86_64")]
            "avx2" => fearless_simd::Level::new().as_avx2().map(Self::Avx2),
            _ if name == Self::NAMES[0] || name == "scalar" => Some(Self::baseline()),
            _ => None,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Baseline(_) => Self::NAMES[0],
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => "avx2",
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(_) => "avx512",
        }
    }
}

impl PartialEq for InstructionSet {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl fmt::Display for InstructionSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Returns the bits of a mask, lane 0 lowest.
#[inline(always)]
pub fn bits_of<S: Simd>(mask: mask32x8<S>) -> u32 {
    mask.to_bitmask() as u32
}

/// Returns the mask of these bits.
#[inline(always)]
pub fn mask_of<S: Simd>(simd: S, bits: u32) -> mask32x8<S> {
    mask32x8::from_bitmask(simd, bits.into())
}

/// Loads eight numbers.
#[inline(always)]
pub fn load<S: Simd>(simd: S, numbers: &Eight) -> f32x8<S> {
    f32x8::load_array_ref(simd, numbers)
}

/// Loads the eight numbers of each axis.
#[inline(always)]
pub fn load3<S: Simd>(simd: S, numbers: &[Eight; 3]) -> [f32x8<S>; 3] {
    [load(simd, &numbers[0]), load(simd, &numbers[1]), load(simd, &numbers[2])]
}

/// Puts one number into all lanes.
#[inline(always)]
pub fn splat<S: Simd>(simd: S, number: f32) -> f32x8<S> {
    f32x8::splat(simd, number)
}

/// Puts the number of each axis into all lanes.
#[inline(always)]
pub fn splat3<S: Simd>(simd: S, numbers: [f32; 3]) -> [f32x8<S>; 3] {
    [splat(simd, numbers[0]), splat(simd, numbers[1]), splat(simd, numbers[2])]
}

/// Changes the sign of `a` where `b` has a minus sign.
#[inline(always)]
pub fn flip_sign<S: Simd>(simd: S, a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
    let sign = u32x8::splat(simd, 1 << 31) & b.to_bits();
    f32x8::from_bits(a.to_bits() ^ sign)
}

/// Stores the lanes of a mask one after another, and anything behind them.
#[inline(always)]
pub fn compress<S: Simd>(mask: mask32x8<S>, value: f32x8<S>, into: &mut Eight) {
    value.compress(mask).store_array(into);
}

/// Does the same with integers.
#[inline(always)]
pub fn compress_u32<S: Simd>(simd: S, mask: mask32x8<S>, from: &[u32; WIDTH], into: &mut [u32; WIDTH]) {
    u32x8::load_array_ref(simd, from).compress(mask).store_array(into);
}

/// For each mask of eight bits, the places of those that are set.
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

/// Returns the places of those of the lowest eight bits that are set, then zeros.
#[inline(always)]
pub fn places_in(bits: u32) -> [u8; WIDTH] {
    PLACES[bits as usize % 256]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_instruction_sets() {
        for name in InstructionSet::NAMES {
            if let Some(set) = InstructionSet::named(name) {
                assert_eq!(set.name(), *name);
            }
        }
        assert_eq!(InstructionSet::named("scalar"), Some(InstructionSet::baseline()));
        assert_eq!(InstructionSet::named("mmx"), None);
    }

    #[test]
    fn signs_are_flipped_where_they_are_negative() {
        for set in InstructionSet::available() {
            let flipped = with_simd!(set, simd => {
                let a = load(simd, &[1.0, 2.0, -3.0, 0.0, 5.0, -6.0, 7.0, 8.0]);
                let b = load(simd, &[1.0, -1.0, -0.0, -2.0, 0.0, 3.0, f32::NEG_INFINITY, 9.0]);
                flip_sign(simd, a, b).to_array()
            });
            assert_eq!(
                flipped.map(f32::to_bits),
                [1.0, -2.0, 3.0, -0.0, 5.0, -6.0, -7.0, 8.0f32].map(f32::to_bits)
            );
        }
    }
}
