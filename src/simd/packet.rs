//! Runs: up to 64 rays that are followed together, one bit of a mask each.
//!
//! The coordinates of a run stand apart, all x, then all y, then all z. A loop over them that calls a scalar definition
//! is compiled to several rays an instruction, with the very bits that each ray alone would have: where a definition
//! is wanted wide, it is not written again.

use super::ray::ShearAxes;
use super::{PreparedRay, Ray};
use crate::accel::simd::{Lanes, Level, Task};
use vecmath::{Real, Vector3};

/// Rays in a run, at most: one for each bit of a mask.
pub const RUN: usize = 64;

/// A number for each ray of a run.
pub type Numbers = [Real; RUN];

/// The numbers of the rays in a mask.
pub fn numbers_in(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let number = mask.trailing_zeros() as usize;
        let some = mask != 0;
        mask &= mask.wrapping_sub(1);
        some.then_some(number % RUN)
    })
}

/// The first rays of a run as a mask.
pub fn first(count: usize) -> u64 {
    match count {
        0 => 0,
        _ => u64::MAX >> (RUN - count.min(RUN)),
    }
}

/// The rays of a mask and some between them: from a multiple of eight to a multiple of eight.
#[inline(always)]
pub fn around(mask: u64) -> std::ops::Range<usize> {
    let (before, after) = (mask.trailing_zeros() as usize & !7, mask.leading_zeros() as usize & !7);
    before..RUN - after
}

/// Whether asking all rays [`around`] a mask together pays, if so many take the time of one by itself.
pub fn is_dense(mask: u64, in_the_time_of_one: usize) -> bool {
    mask != 0 && around(mask).len() < in_the_time_of_one * mask.count_ones() as usize
}

/// A vector for each ray of a run, by coordinates.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Vectors(pub [Numbers; 3]);

impl Vectors {
    pub const ZERO: Self = Self([[0.0; RUN]; 3]);

    #[inline(always)]
    pub fn get(&self, number: usize) -> Vector3 {
        Vector3::new(self.0[0][number], self.0[1][number], self.0[2][number])
    }

    #[inline(always)]
    pub fn set(&mut self, number: usize, vector: Vector3) {
        self.0[0][number] = vector.x;
        self.0[1][number] = vector.y;
        self.0[2][number] = vector.z;
    }
}

impl Vectors {
    /// Replaces the vectors of a mask by their unit vectors; zero stays zero.
    #[inline(always)]
    pub fn normalize(&mut self, mask: u64) {
        let mut all_usual = true;
        for number in around(mask) {
            let vector = self.get(number);
            let is_usual = vector.is_usual();
            let divisor = if is_usual { vector.length() } else { 1.0 };
            self.set(number, vector / divisor);
            all_usual &= is_usual;
        }
        if !all_usual {
            self.normalize_unusual(mask);
        }
    }

    /// The usual ones are unit vectors by now.
    #[cold]
    fn normalize_unusual(&mut self, mask: u64) {
        for number in numbers_in(mask) {
            let vector = self.get(number);
            if !vector.is_usual() {
                self.set(number, vector.normalized());
            }
        }
    }
}

/// Rays by coordinates. Which of them there are is said elsewhere, in a mask; all others are rays too, of no interest.
#[derive(Clone, Copy, Debug)]
pub struct RayRun {
    pub origin: Vectors,
    pub direction: Vectors,
}

impl RayRun {
    pub const NONE: Self =
        Self { origin: Vectors::ZERO, direction: Vectors([[0.0; RUN], [0.0; RUN], [1.0; RUN]]) };

    #[inline(always)]
    pub fn get(&self, number: usize) -> Ray {
        Ray { origin: self.origin.get(number), direction: self.direction.get(number) }
    }

    #[inline(always)]
    pub fn set(&mut self, number: usize, ray: Ray) {
        self.origin.set(number, ray.origin);
        self.direction.set(number, ray.direction);
    }
}

/// Rays with 1 / direction.
#[derive(Clone, Copy)]
pub struct PreparedRun<'a> {
    pub rays: &'a RayRun,
    pub inverse_direction: &'a Vectors,
}

impl PreparedRun<'_> {
    /// The rays of a mask by the axis along which they are sheared for triangles.
    pub fn by_shear_axis(&self, mask: u64) -> [u64; 3] {
        let mut axes = [0; 3];
        for number in numbers_in(mask) {
            axes[ShearAxes::of(self.rays.direction.get(number)).z] |= 1 << number;
        }
        axes
    }
}

impl PreparedRun<'_> {
    #[inline(always)]
    pub fn get(&self, number: usize) -> PreparedRay {
        PreparedRay { ray: self.rays.get(number), inverse_direction: self.inverse_direction.get(number) }
    }
}

/// Computes 1 / direction of the rays of a mask.
pub struct Prepare<'a> {
    pub rays: &'a RayRun,
    pub mask: u64,
    pub inverse_direction: &'a mut Vectors,
}

impl Task for Prepare<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        for number in around(self.mask) {
            let prepared = PreparedRay::new(self.rays.get(number));
            self.inverse_direction.set(number, prepared.inverse_direction);
        }
    }
}

/// Rays in world space, prepared when they are first needed.
pub struct WorldRun<'a> {
    rays: &'a RayRun,
    mask: u64,
    inverse_direction: &'a mut Vectors,
    is_prepared: bool,
}

impl<'a> WorldRun<'a> {
    /// The rays of a mask. There is room for what is computed of them in `inverse_direction`.
    pub fn new(rays: &'a RayRun, mask: u64, inverse_direction: &'a mut Vectors) -> Self {
        Self { rays, mask, inverse_direction, is_prepared: false }
    }

    pub fn rays(&self) -> &RayRun {
        self.rays
    }

    /// One of the rays, prepared.
    #[inline(always)]
    pub fn get(&self, number: usize) -> PreparedRay {
        if self.is_prepared {
            PreparedRun { rays: self.rays, inverse_direction: self.inverse_direction }.get(number)
        } else {
            PreparedRay::new(self.rays.get(number))
        }
    }

    pub fn prepared(&mut self, level: Level) -> PreparedRun<'_> {
        if !self.is_prepared {
            level.run(Prepare { rays: self.rays, mask: self.mask, inverse_direction: self.inverse_direction });
            self.is_prepared = true;
        }
        PreparedRun { rays: self.rays, inverse_direction: self.inverse_direction }
    }
}

/// Something that is known of each ray of a run.
pub trait Lanewise {
    /// Of no interest for any ray.
    const NONE: Self;
}

impl Lanewise for RayRun {
    const NONE: Self = Self::NONE;
}

/// Something known of any number of rays, run by run.
#[derive(Debug)]
pub struct Runs<T> {
    /// Those in use come first.
    runs: Vec<T>,
    count: usize,
}

/// Any number of rays.
pub type Rays = Runs<RayRun>;

impl<T> Default for Runs<T> {
    fn default() -> Self {
        Self { runs: Vec::new(), count: 0 }
    }
}

impl<T: Lanewise> Runs<T> {
    pub fn clear(&mut self) {
        self.count = 0;
    }

    pub fn len(&self) -> usize {
        self.count
    }

    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Room for one more: its run, and its number there.
    #[inline]
    pub fn add(&mut self) -> (&mut T, usize) {
        let (index, number) = (self.count / RUN, self.count % RUN);
        if index == self.runs.len() {
            self.runs.push(T::NONE);
        }
        self.count += 1;
        (&mut self.runs[index], number)
    }

    /// Room for so many, for the caller to fill.
    pub fn resize(&mut self, count: usize) -> &mut [T] {
        let runs = count.div_ceil(RUN);
        while self.runs.len() < runs {
            self.runs.push(T::NONE);
        }
        self.count = count;
        &mut self.runs[..runs]
    }

    /// The runs, each with a mask of its rays.
    pub fn runs(&self) -> impl Iterator<Item = (&T, u64)> {
        let runs = &self.runs[..self.count.div_ceil(RUN)];
        runs.iter().enumerate().map(|(index, run)| (run, first(self.count - index * RUN)))
    }

    /// The same, to be changed.
    pub fn runs_mut(&mut self) -> impl Iterator<Item = (&mut T, u64)> {
        let count = self.count;
        let runs = &mut self.runs[..count.div_ceil(RUN)];
        runs.iter_mut().enumerate().map(move |(index, run)| (run, first(count - index * RUN)))
    }
}

impl Rays {
    pub fn push(&mut self, ray: Ray) {
        let (run, number) = self.add();
        run.set(number, ray);
    }
}

impl FromIterator<Ray> for Rays {
    fn from_iter<I: IntoIterator<Item = Ray>>(iter: I) -> Self {
        let mut rays = Self::default();
        iter.into_iter().for_each(|ray| rays.push(ray));
        rays
    }
}
