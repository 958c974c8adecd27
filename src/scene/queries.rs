//! [`Questions`]: what rays want to know of objects, the nearest hit or any at all.

use super::objects::Hit;
use super::simd::Level;
use crate::objects::HitRun;
use crate::objects::run::{Numbers, WorldRun, numbers_in};
use crate::objects::{Mesh, Object, PreparedRay, T_MAX};
use vecmath::Real;

/// What the rays of a run want to know.
pub trait Questions {
    /// The rays of a mask that still want to know.
    fn open(&self, mask: u64) -> u64;
    /// How far each ray still looks; minus infinity if no further.
    fn t_max(&self) -> &Numbers;
    /// Asks an object about the rays of a mask.
    fn ask(&mut self, index: u32, level: Level, rays: &mut WorldRun, mask: u64);
}

/// The nearest hits.
pub struct Closest<'a> {
    pub objects: &'a [Object],
    pub meshes: &'a [Mesh],
    pub hits: &'a mut HitRun,
}

impl Questions for Closest<'_> {
    fn open(&self, mask: u64) -> u64 {
        mask
    }

    fn t_max(&self) -> &Numbers {
        &self.hits.at.t
    }

    fn ask(&mut self, index: u32, level: Level, rays: &mut WorldRun, mask: u64) {
        self.objects[index as usize].closest_hits(index, self.meshes, level, rays, mask, self.hits);
    }
}

/// Whether anything is in the way.
pub struct Any<'a> {
    pub objects: &'a [Object],
    pub meshes: &'a [Mesh],
    /// Minus infinity for rays that something is in the way of.
    pub t_max: Numbers,
    /// Those rays.
    pub found: u64,
}

impl Questions for Any<'_> {
    fn open(&self, mask: u64) -> u64 {
        mask & !self.found
    }

    fn t_max(&self) -> &Numbers {
        &self.t_max
    }

    fn ask(&mut self, index: u32, level: Level, rays: &mut WorldRun, mask: u64) {
        let found = self.objects[index as usize].any_hits(self.meshes, level, rays, mask, &self.t_max);
        for number in numbers_in(found) {
            self.t_max[number] = Real::NEG_INFINITY;
        }
        self.found |= found;
    }
}

/// The nearest hit of one ray so far.
pub struct Search<'a> {
    pub objects: &'a [Object],
    pub meshes: &'a [Mesh],
    pub closest: &'a mut Option<Hit>,
}

impl Search<'_> {
    /// Asks one object and returns the new limit.
    pub fn ask(&mut self, ray: &PreparedRay, index: u32) -> Real {
        let t_max = self.closest.as_ref().map_or(T_MAX, |closest| closest.at.t);
        // Of equals the first object wins, whatever the order of asking.
        let comes_first = self.closest.as_ref().is_some_and(|closest| index < closest.object);
        let limit = if comes_first { t_max.next_up() } else { t_max };
        if let Some(at) = self.objects[index as usize].closest_hit(self.meshes, ray, limit) {
            *self.closest = Some(Hit { object: index, at });
            return at.t;
        }
        t_max
    }
}
