//! [`HitRun`]: what the rays of a run have hit so far.

use super::run::{Numbers, RUN, Vectors};
use super::{Object, ObjectHit, Shape, T_MAX};
use crate::accel::Hit;
use crate::accel::simd::{Lanes, Level, Task};
use vecmath::Real;

/// The nearest hits of the rays of a run.
#[derive(Clone, Copy, Debug)]
pub struct HitRun {
    /// Index of the object, [`NOTHING`](Self::NOTHING) where nothing is hit.
    pub object: [u32; RUN],
    pub at: SurfaceRun,
}

/// Where rays meet a surface; see [`ObjectHit`](super::ObjectHit).
#[derive(Clone, Copy, Debug)]
pub struct SurfaceRun {
    pub t: Numbers,
    pub triangle: [u32; RUN],
    pub barycentric: Vectors,
}

impl SurfaceRun {
    #[inline(always)]
    pub fn get(&self, number: usize) -> ObjectHit {
        let barycentric = self.barycentric.get(number).to_array();
        ObjectHit { t: self.t[number], triangle: self.triangle[number], barycentric }
    }

    #[inline(always)]
    pub fn set(&mut self, number: usize, hit: ObjectHit) {
        self.t[number] = hit.t;
        self.triangle[number] = hit.triangle;
        self.barycentric.set(number, hit.barycentric.into());
    }
}

impl HitRun {
    /// The index of no object.
    pub const NOTHING: u32 = u32::MAX;

    /// Nothing is hit yet: whatever is nearer than [`T_MAX`] will be.
    pub const NONE: Self = Self {
        object: [Self::NOTHING; RUN],
        at: SurfaceRun { t: [BELOW_T_MAX; RUN], triangle: [0; RUN], barycentric: Vectors::ZERO },
    };

    pub fn clear(&mut self) {
        self.object = Self::NONE.object;
        self.at.t = Self::NONE.at.t;
    }

    /// The rays of a mask whose nearest hit is of this object.
    pub fn of_object(&self, level: Level, mask: u64, object: u32) -> u64 {
        mask & level.run(OfObject { hits: self, object })
    }

    /// The nearest hit of a ray.
    pub fn get(&self, number: usize, objects: &[Object]) -> Option<Hit> {
        let object = self.object[number];
        let at = |shape: &Shape| match shape {
            Shape::Sphere(_) | Shape::Plane(_) => ObjectHit::at(self.at.t[number]),
            Shape::Triangle(_) | Shape::Mesh(_) => self.at.get(number),
        };
        (object != Self::NOTHING).then(|| Hit { object, at: at(&objects[object as usize].shape) })
    }

    /// Hits of this object count below this t. Of equals the first object wins, whatever the order of asking.
    #[inline(always)]
    pub fn limit(&self, number: usize, object: u32) -> Real {
        let bits = self.at.t[number].to_bits();
        // The next number, for t is above 0.
        Real::from_bits(if object < self.object[number] { bits + 1 } else { bits })
    }
}

/// Tells the rays whose nearest hit is of an object.
struct OfObject<'a> {
    hits: &'a HitRun,
    object: u32,
}

impl Task for OfObject<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> u64 {
        let mut mask = 0;
        for number in 0..RUN {
            mask |= u64::from(self.hits.object[number] == self.object) << number;
        }
        mask
    }
}

/// The largest t of a hit.
const BELOW_T_MAX: Real = T_MAX.next_down();
