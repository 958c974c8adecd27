//! [`Avx2`]: eight numbers in one register of an x86-64 processor with AVX2 and FMA.

use super::{Eight, Lanes, Task, WIDTH, places_in};
use std::arch::x86_64::*;

/// The proof that the processor has AVX2 and FMA: there is no other way to a value than to ask it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Avx2(());

impl Avx2 {
    pub fn detected() -> Option<Self> {
        let there = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("popcnt");
        there.then_some(Self(()))
    }
}

#[inline(always)]
fn places(_: Avx2, bits: u32) -> __m256i {
    // SAFETY: the processor has AVX2 and FMA.
    unsafe { _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(i64::from_le_bytes(places_in(bits)))) }
}

impl Lanes for Avx2 {
    type F = __m256;
    type M = __m256;

    #[inline(always)]
    fn splat(self, value: f32) -> __m256 {
        // SAFETY: a value of this type exists, so the processor has AVX2 and FMA. The same holds below.
        unsafe { _mm256_set1_ps(value) }
    }

    #[inline(always)]
    fn load(self, from: &Eight) -> __m256 {
        // SAFETY: as above; the reference is to eight numbers, and the load needs no alignment.
        unsafe { _mm256_loadu_ps(from.as_ptr()) }
    }

    #[inline(always)]
    fn store(self, value: __m256, into: &mut Eight) {
        // SAFETY: as above; the reference is to eight numbers, and the store needs no alignment.
        unsafe { _mm256_storeu_ps(into.as_mut_ptr(), value) }
    }

    #[inline(always)]
    fn add(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe { _mm256_add_ps(a, b) }
    }

    #[inline(always)]
    fn sub(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe { _mm256_sub_ps(a, b) }
    }

    #[inline(always)]
    fn mul(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe { _mm256_mul_ps(a, b) }
    }

    #[inline(always)]
    fn div(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe { _mm256_div_ps(a, b) }
    }

    #[inline(always)]
    fn mul_add(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe { _mm256_fmadd_ps(a, b, c) }
    }

    #[inline(always)]
    fn mul_sub(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe { _mm256_fmsub_ps(a, b, c) }
    }

    #[inline(always)]
    fn min(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe { _mm256_min_ps(a, b) }
    }

    #[inline(always)]
    fn max(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe { _mm256_max_ps(a, b) }
    }

    #[inline(always)]
    fn abs(self, a: __m256) -> __m256 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), a) }
    }

    #[inline(always)]
    fn negated_by(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe { _mm256_xor_ps(a, _mm256_and_ps(_mm256_set1_ps(-0.0), b)) }
    }

    #[inline(always)]
    fn le(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(a, b) }
    }

    #[inline(always)]
    fn and(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe { _mm256_and_ps(a, b) }
    }

    #[inline(always)]
    fn or(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe { _mm256_or_ps(a, b) }
    }

    #[inline(always)]
    fn mask(self, bits: u32) -> __m256 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe {
            let bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let here = _mm256_and_si256(_mm256_set1_epi32(bits as i32), bit);
            _mm256_castsi256_ps(_mm256_cmpeq_epi32(here, bit))
        }
    }

    #[inline(always)]
    fn select(self, mask: __m256, a: __m256, b: __m256) -> __m256 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe { _mm256_blendv_ps(b, a, mask) }
    }

    #[inline(always)]
    fn compress(self, bits: u32, value: __m256, into: &mut Eight) {
        // SAFETY: the processor has AVX2 and FMA; the reference is to eight numbers, and the store needs no alignment.
        unsafe { _mm256_storeu_ps(into.as_mut_ptr(), _mm256_permutevar8x32_ps(value, places(self, bits))) }
    }

    #[inline(always)]
    fn compress_bits(self, bits: u32, from: [u32; WIDTH], into: &mut [u32; WIDTH]) {
        // SAFETY: as above, and the load is from eight numbers.
        unsafe {
            let from = _mm256_loadu_si256(from.as_ptr().cast());
            _mm256_storeu_si256(into.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(from, places(self, bits)));
        }
    }

    #[inline(always)]
    fn bits(self, mask: __m256) -> u32 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe { _mm256_movemask_ps(mask) as u32 }
    }

    #[inline(always)]
    fn least(self, a: __m256) -> f32 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe {
            let b = _mm_min_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a));
            let b = _mm_min_ps(b, _mm_movehl_ps(b, b));
            _mm_cvtss_f32(_mm_min_ss(b, _mm_movehdup_ps(b)))
        }
    }

    #[inline(always)]
    fn greatest(self, a: __m256) -> f32 {
        // SAFETY: the processor has AVX2 and FMA.
        unsafe {
            let b = _mm_max_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a));
            let b = _mm_max_ps(b, _mm_movehl_ps(b, b));
            _mm_cvtss_f32(_mm_max_ss(b, _mm_movehdup_ps(b)))
        }
    }

    #[inline]
    fn enter<T: Task>(self, task: T) -> T::Output {
        #[target_feature(enable = "avx2,fma,bmi1,popcnt")]
        fn compiled<T: Task>(lanes: Avx2, task: T) -> T::Output {
            task.run(lanes)
        }
        // SAFETY: `self` is the proof that the processor has all four.
        unsafe { compiled(self, task) }
    }
}
