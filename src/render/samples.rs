//! Samplers: the position of a sample in its pixel. It depends only on pixel, sample number and seed, so that every
//! order of work gives the same picture.
//!
//! Each sampler gives any number of samples. Each single sample is uniform in the pixel, so that the mean is unbiased
//! for any number of samples. The samplers differ in how evenly the samples of a pixel are distributed together.

use super::sobol::{BLOCK, Sobol};
use super::stratified::{Cells, below_one};
use crate::options::SamplerKind;
use vecmath::Real;

/// A sampler and the number of samples in a set.
#[derive(Clone, Copy, Debug)]
pub struct SamplePattern {
    kind: SamplerKind,
    cells: Cells,
}

impl SamplePattern {
    /// Makes a pattern for sets of `count` samples, which must not be 0. Only the stratified sampler uses `count`.
    pub fn new(kind: SamplerKind, count: u32) -> Self {
        let cells = if kind == SamplerKind::Stratified { Cells::new(count) } else { Cells::ONE };
        Self { kind, cells }
    }

    /// Returns a set of samples of a pixel. Sets with different numbers are independent.
    #[inline(always)]
    pub fn set(&self, (x, row): (u32, u32), set: u32, seed: u64) -> SampleSet<'_> {
        // Set 0 uses the seed as it is, so that the default pictures keep their samples.
        let seed = if set == 0 { seed } else { mixed(seed ^ u64::from(set).rotate_left(40)) };
        SampleSet { pattern: self, pixel_bits: mixed(seed ^ mixed(u64::from(x) << 32 | u64::from(row))) }
    }

    /// Writes the first `N` Sobol samples of each pixel, which fill no block: those of several pixels together.
    #[inline(always)]
    fn write_first<const N: usize>(&self, pixels: &[(u32, u32)], seed: u64, offsets: &mut [(Real, Real)]) {
        for (pixels, offsets) in pixels.chunks(BLOCK / N).zip(offsets.chunks_mut(BLOCK)) {
            let mut sequences = [Sobol::new([0; 2]); BLOCK];
            for (sequence, &pixel) in sequences.iter_mut().zip(pixels) {
                *sequence = self.set(pixel, 0, seed).sobol();
            }
            offsets.copy_from_slice(&Sobol::first_of_each::<N>(&sequences)[..offsets.len()]);
        }
    }

    /// Writes the offsets of `samples` samples of each pixel: the whole set 0. Call it inside `vectorize`.
    #[inline(always)]
    pub fn write_sets(&self, pixels: &[(u32, u32)], samples: u32, seed: u64, offsets: &mut [(Real, Real)]) {
        match (self.kind, samples) {
            (SamplerKind::Sobol, 2) => self.write_first::<2>(pixels, seed, offsets),
            (SamplerKind::Sobol, 4) => self.write_first::<4>(pixels, seed, offsets),
            _ => {
                for (&pixel, offsets) in pixels.iter().zip(offsets.chunks_exact_mut(samples as usize)) {
                    self.set(pixel, 0, seed).write_offsets(0, offsets);
                }
            }
        }
    }
}

/// A set of samples of one pixel, chosen together to cover the pixel evenly.
#[derive(Clone, Copy, Debug)]
pub struct SampleSet<'a> {
    pattern: &'a SamplePattern,
    pixel_bits: u64,
}

impl SampleSet<'_> {
    /// Returns the offset of a sample from its pixel, in pixels, both in \[0, 1).
    pub fn offset(&self, sample: u32) -> (Real, Real) {
        match self.pattern.kind {
            SamplerKind::Independent => independent(self.pixel_bits, sample),
            SamplerKind::Stratified => {
                let (x, y) = random(self.pixel_bits, sample.into());
                self.pattern.cells.cell(sample).place(x, y)
            }
            SamplerKind::Sobol => self.sobol().sample(sample),
        }
    }

    /// Writes the [`offset`](Self::offset) of each sample from number `first` on. Call it inside `vectorize`.
    #[inline(always)]
    pub fn write_offsets(&self, first: u32, offsets: &mut [(Real, Real)]) {
        let (key, cells) = (self.pixel_bits, self.pattern.cells);
        let whole_set = first == 0 && offsets.len() == cells.count as usize;
        match self.pattern.kind {
            SamplerKind::Independent => {
                for (index, offset) in offsets.iter_mut().enumerate() {
                    *offset = independent(key, first + index as u32);
                }
            }
            SamplerKind::Stratified if whole_set => {
                for (index, offset) in offsets.iter_mut().enumerate() {
                    *offset = random(key, index as u64);
                }
                cells.place_each(offsets);
            }
            SamplerKind::Stratified => {
                for (index, offset) in offsets.iter_mut().enumerate() {
                    *offset = self.offset(first + index as u32);
                }
            }
            SamplerKind::Sobol => self.sobol().write(first, offsets),
        }
    }

    #[inline(always)]
    fn sobol(&self) -> Sobol {
        // Other bits than those of the other samplers.
        Sobol::new([self.pixel_bits, mixed(self.pixel_bits ^ 0xbb67_ae85_84ca_a73b)])
    }
}

/// Returns two random numbers from 0 to 1.
#[inline(always)]
fn random(key: u64, index: u64) -> (Real, Real) {
    let bits = mixed(key.wrapping_add(index));
    // Both halves are independent enough, because every bit of the mix depends on every bit of the input.
    let unit = |half: u32| half as Real * (0.5 as Real).powi(32);
    (unit((bits >> 32) as u32), unit(bits as u32))
}

/// Returns a sample of the independent sampler.
#[inline(always)]
fn independent(key: u64, sample: u32) -> (Real, Real) {
    // Other bits than the stratified sampler's, so that pictures of both are independent.
    let (x, y) = random(key, u64::from(sample) ^ 0x6a09_e667_f3bc_c908);
    (below_one(x), below_one(y))
}

/// Hashes a number. It is a bijection of 64-bit numbers (the finaliser of SplitMix64: Steele, Lea, Flood, Fast
/// Splittable Pseudorandom Number Generators, OOPSLA 2014).
#[inline(always)]
pub fn mixed(bits: u64) -> u64 {
    let bits = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{InstructionSet, Simd, vectorize, with_simd};

    const COUNTS: [u32; 12] = [1, 2, 3, 5, 7, 8, 12, 13, 16, 17, 100, 101];

    #[test]
    fn sixteen_stratified_samples_are_the_courses_grid() {
        let pattern = SamplePattern::new(SamplerKind::Stratified, 16);
        let set = pattern.set((17, 3), 0, 5);
        for sample in 0..16 {
            let (x, y) = set.offset(sample);
            assert_eq!(((x * 4.0) as u32, (y * 4.0) as u32), (sample % 4, sample / 4));
        }
    }

    #[test]
    fn offsets_lie_in_the_pixel_and_depend_on_pixel_number_set_and_seed_alone() {
        for kind in SamplerKind::ALL {
            for count in COUNTS {
                let offsets = |pixel, set, seed| {
                    let pattern = SamplePattern::new(kind, count);
                    let set = pattern.set(pixel, set, seed);
                    (0..count).map(|sample| set.offset(sample)).collect::<Vec<_>>()
                };
                let some = offsets((1, 2), 0, 4);
                assert!(some.iter().all(|(x, y)| (0.0..1.0).contains(x) && (0.0..1.0).contains(y)));
                assert_eq!(some, offsets((1, 2), 0, 4));
                for other in [offsets((2, 1), 0, 4), offsets((1, 2), 1, 4), offsets((1, 2), 0, 5)] {
                    assert_ne!(some, other, "{kind:?} {count}");
                }
            }
        }
    }

    #[test]
    fn many_samples_are_the_same_as_one_by_one_with_every_instruction_set() {
        for kind in SamplerKind::ALL {
            for count in COUNTS {
                let pattern = SamplePattern::new(kind, count);
                let set = pattern.set((3, 4), 1, 5);
                for first in [0, count / 2] {
                    let expected: Vec<_> = (first..count).map(|sample| set.offset(sample)).collect();
                    for simd in InstructionSet::available() {
                        let mut written = vec![(-1.0, -1.0); expected.len()];
                        let offsets = written.as_mut_slice();
                        with_simd!(simd, simd => vectorize!(simd, set.write_offsets(first, offsets)));
                        assert_eq!(written, expected, "{kind:?} {simd:?} {first}..{count}");
                    }
                }
            }
        }
    }

    #[test]
    fn sets_of_many_pixels_are_those_of_each_with_every_instruction_set() {
        let pixels: Vec<(u32, u32)> = (0..13).map(|x| (x, x / 3)).collect();
        for (kind, count) in SamplerKind::ALL.into_iter().flat_map(|kind| COUNTS.map(|count| (kind, count))) {
            let pattern = SamplePattern::new(kind, count);
            let of_pixel = |&pixel| (0..count).map(move |sample| pattern.set(pixel, 0, 5).offset(sample));
            let expected: Vec<_> = pixels.iter().flat_map(of_pixel).collect();
            for simd in InstructionSet::available() {
                let mut written = vec![(-1.0, -1.0); expected.len()];
                let (pixels, offsets) = (pixels.as_slice(), written.as_mut_slice());
                with_simd!(simd, simd => vectorize!(simd, pattern.write_sets(pixels, count, 5, offsets)));
                assert_eq!(written, expected, "{kind:?} {simd:?} {count}");
            }
        }
    }

    #[test]
    fn every_sample_by_itself_is_uniform() {
        // 9 degrees of freedom: the chi-square is below 43 in all but 2 of a million cases, and about 250 are tested.
        for kind in SamplerKind::ALL {
            for (count, sample) in [(1, 0), (3, 2), (7, 3), (16, 0), (16, 15), (17, 4)] {
                let pattern = SamplePattern::new(kind, count);
                let mut bins = [[0; 10]; 2];
                for pixel in 0..4000 {
                    let set = pattern.set((pixel, pixel / 7), 1, 0);
                    // All cells together are uniform, so any cell's samples are rotated through the cells.
                    let sample = if kind == SamplerKind::Stratified { pixel % count } else { sample };
                    let (x, y) = set.offset(sample);
                    bins[0][(x * 10.0) as usize] += 1;
                    bins[1][(y * 10.0) as usize] += 1;
                }
                for bins in bins {
                    let chi_square: f64 = bins.iter().map(|&n| (f64::from(n) - 400.0).powi(2) / 400.0).sum();
                    assert!(chi_square < 43.0, "{kind:?} {count} {sample}: {bins:?}");
                }
            }
        }
    }

    #[test]
    fn sixteen_sobol_samples_are_stratified_in_every_way() {
        let pattern = SamplePattern::new(SamplerKind::Sobol, 16);
        let set = pattern.set((8, 9), 0, 5);
        for (columns, rows) in [(16, 1), (8, 2), (4, 4), (2, 8), (1, 16)] {
            let mut seen = vec![0; 16];
            for sample in 0..16 {
                let (x, y) = set.offset(sample);
                seen[(y * rows as Real) as usize * columns + (x * columns as Real) as usize] += 1;
            }
            assert_eq!(seen, [1; 16], "{columns} x {rows}");
        }
    }

    #[test]
    fn sets_and_samples_are_uncorrelated() {
        // The correlation of n pairs has a standard deviation of 1 / sqrt(n).
        let correlation = |pairs: &[(Real, Real)]| {
            let products = pairs.iter().map(|(a, b)| (f64::from(*a as f32) - 0.5) * (f64::from(*b as f32) - 0.5));
            12.0 * products.sum::<f64>() / pairs.len() as f64
        };
        for kind in SamplerKind::ALL {
            let pattern = SamplePattern::new(kind, 1);
            let pairs: Vec<(Real, Real)> = (0..20_000)
                .map(|pixel| {
                    let offset = |set| pattern.set((pixel, 5), set, 0).offset(0);
                    (offset(0).0, offset(1).0)
                })
                .collect();
            assert!(correlation(&pairs).abs() < 4.5 / (20_000.0 as f64).sqrt(), "{kind:?}");
            let neighbours: Vec<(Real, Real)> = (0..20_000)
                .map(|x| {
                    let offset = |x| pattern.set((x, 5), 0, 0).offset(0);
                    (offset(x).0, offset(x + 1).1)
                })
                .collect();
            assert!(correlation(&neighbours).abs() < 4.5 / (20_000.0 as f64).sqrt(), "{kind:?}");
        }
    }
}
