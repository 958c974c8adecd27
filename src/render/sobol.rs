//! Sobol's sequence in two dimensions with Owen's scrambling.
//!
//! The sequence is a (0,2)-sequence in base 2: of each *aligned block* of 2^m samples (it begins at a multiple of
//! 2^m), exactly one lies in each elementary interval of area 2^-m. An elementary interval is a cell of a grid of
//! 2^a x 2^(m - a) cells, for any a. So the halves and the quarters of 2^m samples are such nets as well. All
//! aligned blocks of one size have the same distribution, because scrambling takes one to any other.
//!
//! Owen's scrambling keeps the nets and makes each sample uniform. A hash of the reversed bits does it: bit k of the
//! result depends on bits 0 to k alone (Burley, Practical Hash-based Owen Scrambling, JCGT 9(4), 2020; the constants
//! are Vegdahl's, Building a Better LK Hash, 2021). With keys of 64 bits, the variance of a mean is exactly that of
//! Owen's scrambling. For a variance depends on pairs of samples only, and every pair is scrambled as by Owen:
//! (a + s) m is uniform, because s is, and its difference from (b + s) m is (a - b) m, which is uniform among the
//! numbers with as many trailing zeros as a - b, because m is uniform among the odd numbers. The other steps only
//! permute what is equally likely. Burley also shuffles the indices, so that a sample can take its dimensions from
//! several sequences; here a sequence has both.

use vecmath::Real;

/// Samples that are computed together.
pub const BLOCK: usize = 8;

/// A scrambled sequence. Sequences with independent keys are independent.
#[derive(Clone, Copy, Debug)]
pub struct Sobol {
    x: Scrambling,
    y: Scrambling,
}

impl Sobol {
    /// Makes a sequence of two keys, which must be random.
    #[inline(always)]
    pub fn new(keys: [u64; 2]) -> Self {
        Self { x: Scrambling::new(keys[0]), y: Scrambling::new(keys[1]) }
    }

    /// Returns a sample, both coordinates in \[0, 1).
    pub fn sample(&self, index: u32) -> (Real, Real) {
        (unit(self.x.scrambled(index)), unit(self.y.scrambled(second_dimension(index))))
    }

    /// Writes the samples from number `first` on. Call it inside `vectorize`.
    #[inline(always)]
    pub fn write(self, first: u32, mut samples: &mut [(Real, Real)]) {
        let mut skipped = first as usize % BLOCK;
        let mut start = first - skipped as u32;
        while !samples.is_empty() {
            let count = samples.len().min(BLOCK - skipped);
            let (now, later) = samples.split_at_mut(count);
            let block = self.block(start);
            match <&mut [_; BLOCK]>::try_from(&mut *now) {
                Ok(whole) => *whole = block,
                Err(_) => now.copy_from_slice(&block[skipped..skipped + count]),
            }
            samples = later;
            start = start.wrapping_add(BLOCK as u32);
            skipped = 0;
        }
    }

    /// Returns the first `N` samples of each sequence, one sequence after the other, as many as fit into a block; `N` is 2
    /// or 4. Call it inside `vectorize`.
    #[inline(always)]
    pub fn first_of_each<const N: usize>(sequences: &[Self; BLOCK]) -> [(Real, Real); BLOCK] {
        let [mut x, mut y] = [[[0; BLOCK]; 2]; 2];
        for (number, sequence) in sequences[..BLOCK / N].iter().enumerate() {
            for lane in N * number..N * number + N {
                (x[0][lane], x[1][lane]) = (sequence.x.summand, sequence.x.factor);
                (y[0][lane], y[1][lane]) = (sequence.y.summand, sequence.y.factor);
            }
        }
        let mut bits = [[0; BLOCK]; 2];
        for lane in 0..BLOCK {
            let index = (lane % N) as u32;
            // What `second_dimension` is for less than four.
            let second = index ^ (index >> 1);
            bits[0][lane] = Scrambling { summand: x[0][lane], factor: x[1][lane] }.scrambled(index);
            bits[1][lane] = Scrambling { summand: y[0][lane], factor: y[1][lane] }.scrambled(second);
        }
        std::array::from_fn(|lane| (unit(bits[0][lane]), unit(bits[1][lane])))
    }

    /// Returns the aligned block of samples that begins at `start`.
    #[inline(always)]
    fn block(self, start: u32) -> [(Real, Real); BLOCK] {
        // The matrix of the second dimension is linear: the part of a sample in its block is a constant.
        let (start_x, start_y) = (start, second_dimension(start));
        let mut bits = [[0; BLOCK]; 2];
        for lane in 0..BLOCK {
            bits[0][lane] = self.x.scrambled(start_x ^ lane as u32);
            bits[1][lane] = self.y.scrambled(start_y ^ SECOND_DIMENSION[lane]);
        }
        std::array::from_fn(|lane| (unit(bits[0][lane]), unit(bits[1][lane])))
    }
}

/// The key of a scrambling.
#[derive(Clone, Copy, Debug)]
struct Scrambling {
    summand: u32,
    /// An odd number.
    factor: u32,
}

impl Scrambling {
    #[inline(always)]
    fn new(key: u64) -> Self {
        Self { summand: key as u32, factor: (key >> 32) as u32 | 1 }
    }

    /// Scrambles a binary fraction whose bits are given in reversed order, the highest as bit 0. Returns it with its
    /// bits in order.
    #[inline(always)]
    fn scrambled(self, reversed: u32) -> u32 {
        let bits = reversed ^ reversed.wrapping_mul(0x3d20_adea);
        let bits = bits.wrapping_add(self.summand).wrapping_mul(self.factor);
        let bits = bits ^ bits.wrapping_mul(0x0552_6c56);
        (bits ^ bits.wrapping_mul(0x53a2_2864)).reverse_bits()
    }
}

/// Returns the second coordinate of a sample before scrambling, its bits in reversed order. (The first coordinate in
/// this order is the index itself: van der Corput's sequence.)
///
/// The matrix is Pascal's triangle modulo 2: bit r is the sum of all bits k of the index for which the binomial
/// coefficient of k and r is odd, that is, k has all bits that r has. So each bit of k and r is a step of its own.
#[inline(always)]
const fn second_dimension(index: u32) -> u32 {
    let bits = index ^ ((index >> 1) & 0x5555_5555);
    let bits = bits ^ ((bits >> 2) & 0x3333_3333);
    let bits = bits ^ ((bits >> 4) & 0x0f0f_0f0f);
    let bits = bits ^ ((bits >> 8) & 0x00ff_00ff);
    bits ^ (bits >> 16)
}

/// The [`second_dimension`] of the first indices.
const SECOND_DIMENSION: [u32; BLOCK] = {
    let mut table = [0; BLOCK];
    let mut index = 0;
    while index < BLOCK {
        table[index] = second_dimension(index as u32);
        index += 1;
    }
    table
};

/// Takes a binary fraction of 32 bits to a number. Bits that `Real` cannot hold are cut off, so that no number is
/// rounded up into another elementary interval.
#[inline(always)]
fn unit(bits: u32) -> Real {
    const CUT: u32 = 32u32.saturating_sub(Real::MANTISSA_DIGITS);
    (bits >> CUT) as Real * (0.5 as Real).powi(32 - CUT as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{InstructionSet, Simd, vectorize, with_simd};

    /// Hashes a number (the finaliser of MurmurHash3).
    fn hash(bits: u64) -> u64 {
        let bits = (bits ^ (bits >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
        let bits = (bits ^ (bits >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
        bits ^ (bits >> 33)
    }

    fn sequence(number: u64) -> Sobol {
        Sobol::new([hash(2 * number + 1), hash(2 * number + 2)])
    }

    #[test]
    fn the_second_dimension_has_sobols_direction_numbers() {
        // Bratley and Fox, Algorithm 659, TOMS 14(1), 1988: m of the polynomial x + 1.
        let m = [1, 3, 5, 15, 17, 51, 85, 255, 257, 771, 1285, 3855, 4369, 13107, 21845, 65535];
        for (k, m) in m.into_iter().enumerate() {
            assert_eq!(second_dimension(1 << k).reverse_bits(), m << (31 - k), "{k}");
        }
        let eighths = |index| second_dimension(index).reverse_bits() >> 29;
        assert_eq!([0, 1, 2, 3, 4, 5, 6, 7].map(eighths), [0, 4, 6, 2, 5, 1, 3, 7]);
    }

    /// Counts the blocks looked at, and fails where an elementary interval is empty.
    fn assert_nets(sobol: &Sobol, size: u32, block: u32) {
        let bits = size.trailing_zeros();
        let samples = (0..size).map(|index| sobol.sample(block * size + index));
        let samples: Vec<_> = samples.collect();
        for columns in (0..=bits).map(|bits| 1usize << bits) {
            let rows = size as usize / columns;
            let mut seen = vec![0; size as usize];
            for (x, y) in &samples {
                seen[(y * rows as Real) as usize * columns + (x * columns as Real) as usize] += 1;
            }
            assert!(seen.iter().all(|&count| count == 1), "{columns} x {rows}, block {block}");
        }
    }

    #[test]
    fn every_aligned_block_is_a_net() {
        for size in [2, 4, 8, 16, 64, 256, 4096] {
            let last = u32::MAX / size;
            for block in [0, 1, 2, 3, 4, 7, 0x1_0000 / size, 12_345 % last, last / 2, last - 1, last] {
                (0..20).for_each(|number| assert_nets(&sequence(number), size, block));
            }
        }
    }

    #[test]
    fn many_samples_are_the_same_as_one_by_one_with_every_instruction_set() {
        let sobol = sequence(7);
        for set in InstructionSet::available() {
            for first in [0, 1, 5, 8, 15, 1 << 16, u32::MAX - 40] {
                for count in 0..40 {
                    let mut written = vec![(-1.0, -1.0); count as usize];
                    let samples = written.as_mut_slice();
                    with_simd!(set, simd => vectorize!(simd, sobol.write(first, samples)));
                    let expected: Vec<_> = (first..first + count).map(|index| sobol.sample(index)).collect();
                    assert_eq!(written, expected, "{set} {first} {count}");
                }
            }
        }
    }

    /// Owen's scrambling by its definition: whether a bit is flipped is decided by a coin of its own for every
    /// possible sequence of bits before it.
    fn scrambled_by_owen(fraction: u32, key: u64) -> u32 {
        let flip = |bit: u32| {
            let before = u64::from(fraction) >> (32 - bit);
            (hash(key ^ hash(before << 6 | u64::from(bit))) as u32 & 1) << (31 - bit)
        };
        (0..32).fold(fraction, |scrambled, bit| scrambled ^ flip(bit))
    }

    /// Returns the variance of the mean of `count` samples, over many sequences.
    fn variance(count: u32, f: impl Fn(f64, f64) -> f64, sample: impl Fn(u64, u32) -> (f64, f64)) -> f64 {
        const SEQUENCES: u64 = 20_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for number in 0..SEQUENCES {
            let values = (0..count).map(|index| sample(number, index));
            let mean = values.map(|(x, y)| f(x, y)).sum::<f64>() / f64::from(count);
            sum += mean;
            squares += mean * mean;
        }
        squares / SEQUENCES as f64 - (sum / SEQUENCES as f64).powi(2)
    }

    /// The ratio of two variances, each of 20,000 means, has a standard deviation of about 1.5%.
    #[test]
    fn the_variance_is_that_of_owens_scrambling() {
        type Integrand = fn(f64, f64) -> f64;
        let integrands: [(&str, Integrand); 4] = [
            ("edge", |x, y| f64::from(0.6 * x + y > 0.7)),
            ("steep edge", |x, y| f64::from(0.05 * y + x > 0.4)),
            ("smooth", |x, y| (x * y + 0.5 * x).exp()),
            ("disc", |x, y| f64::from((x - 0.45).hypot(y - 0.55) < 0.37)),
        ];
        let by_owen = |number: u64, index: u32| {
            let scale = 0.5f64.powi(32);
            let bits = [index.reverse_bits(), second_dimension(index).reverse_bits()];
            let keys = [hash(2 * number + 1), hash(2 * number + 2)];
            (
                f64::from(scrambled_by_owen(bits[0], keys[0])) * scale,
                f64::from(scrambled_by_owen(bits[1], keys[1])) * scale,
            )
        };
        let ours = |number: u64, index: u32| {
            let (x, y) = sequence(number).sample(index);
            (x as f64, y as f64)
        };
        for (name, f) in integrands {
            for count in [2, 3, 4, 7, 16] {
                let (ours, by_owen) = (variance(count, f, ours), variance(count, f, by_owen));
                assert!((ours / by_owen - 1.0).abs() < 0.07, "{name} {count}: {ours} {by_owen}");
                assert!(ours > 0.0);
            }
        }
    }
}
