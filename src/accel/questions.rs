//! [`Questions`]: what rays want to know of objects, the nearest hit or any at all.

use super::beam::{BEAM_RAYS, numbers_in};
use super::objects::Hit;
use crate::objects::{Mesh, Object, ObjectHit, PreparedRay, Shape, T_MAX};
use vecmath::Real;

/// What many rays want to know.
pub trait Questions {
    /// The rays of a mask that still want to know.
    fn open(&self, mask: u64) -> u64;
    /// How far a ray still looks; minus infinity if no further.
    fn t_max(&self, number: usize) -> Real;
    /// Asks an object about the rays of a mask.
    fn ask(&mut self, index: u32, rays: &[PreparedRay; BEAM_RAYS], mask: u64);
    /// Hears that a ray hits an object at t.
    fn take(&mut self, index: u32, number: usize, t: Real);
}

/// So many rays in one mesh are worth a beam.
const BEAM_WORTH: u32 = 4;

/// The nearest hits of many rays.
pub struct Closest<'a> {
    pub objects: &'a [Object],
    pub meshes: &'a [Mesh],
    /// One a ray.
    pub hits: &'a mut [Option<Hit>],
}

impl Questions for Closest<'_> {
    fn open(&self, mask: u64) -> u64 {
        mask
    }

    fn t_max(&self, number: usize) -> Real {
        t_max(&self.hits[number])
    }

    fn ask(&mut self, index: u32, rays: &[PreparedRay; BEAM_RAYS], mask: u64) {
        let Self { objects, meshes, ref mut hits } = *self;
        let object = &objects[index as usize];
        match object.shape {
            Shape::Mesh(mesh) if mask.count_ones() >= BEAM_WORTH => {
                let mut limits = [0.0; BEAM_RAYS];
                for number in numbers_in(mask) {
                    limits[number] = limit_for(&hits[number], index);
                }
                object.closest_mesh_hits(&meshes[mesh as usize], rays, mask, &limits, |number, at| {
                    hits[number] = Some(Hit { object: index, at });
                });
            }
            _ => {
                for number in numbers_in(mask) {
                    Search { objects, meshes, closest: &mut hits[number] }.ask(&rays[number], index);
                }
            }
        }
    }

    fn take(&mut self, index: u32, number: usize, t: Real) {
        let closest = &mut self.hits[number];
        if t < limit_for(closest, index) {
            *closest = Some(Hit { object: index, at: ObjectHit::at(t) });
        }
    }
}

/// Whether anything is in the way of many rays.
pub struct Any<'a> {
    pub objects: &'a [Object],
    pub meshes: &'a [Mesh],
    pub t_max: [Real; BEAM_RAYS],
    /// Rays that something is in the way of.
    pub found: u64,
}

impl Questions for Any<'_> {
    fn open(&self, mask: u64) -> u64 {
        mask & !self.found
    }

    fn t_max(&self, number: usize) -> Real {
        if self.found >> number & 1 == 1 { Real::NEG_INFINITY } else { self.t_max[number] }
    }

    fn ask(&mut self, index: u32, rays: &[PreparedRay; BEAM_RAYS], mask: u64) {
        let object = &self.objects[index as usize];
        match object.shape {
            Shape::Mesh(mesh) if mask.count_ones() >= BEAM_WORTH => {
                self.found |= object.any_mesh_hits(&self.meshes[mesh as usize], rays, mask, &self.t_max);
            }
            _ => {
                for number in numbers_in(mask) {
                    if object.any_hit(self.meshes, &rays[number], self.t_max[number]) {
                        self.found |= 1 << number;
                    }
                }
            }
        }
    }

    fn take(&mut self, _: u32, number: usize, t: Real) {
        self.found |= u64::from(t <= self.t_max[number]) << number;
    }
}

/// How far a ray looks that has hit this so far.
fn t_max(closest: &Option<Hit>) -> Real {
    closest.as_ref().map_or(T_MAX, |closest| closest.at.t)
}

/// Hits of an object count below this t. Of equals the first object wins, whatever the order of asking.
fn limit_for(closest: &Option<Hit>, index: u32) -> Real {
    let comes_first = closest.as_ref().is_some_and(|closest| index < closest.object);
    if comes_first { t_max(closest).next_up() } else { t_max(closest) }
}

/// The nearest hit so far.
pub struct Search<'a> {
    pub objects: &'a [Object],
    pub meshes: &'a [Mesh],
    pub closest: &'a mut Option<Hit>,
}

impl Search<'_> {
    /// Asks one object and returns the new limit.
    pub fn ask(&mut self, ray: &PreparedRay, index: u32) -> Real {
        let limit = limit_for(self.closest, index);
        if let Some(at) = self.objects[index as usize].closest_hit(self.meshes, ray, limit) {
            *self.closest = Some(Hit { object: index, at });
        }
        t_max(self.closest)
    }
}
