//! [`ObjectTree`]: the objects of a scene, sorted for queries.

use crate::bvh::build::{self, Item};
use crate::bvh::{Bvh, CullingSpace};
use crate::objects::{Aabb, Object};
use rayon::prelude::*;
use vecmath::Real;

/// Objects with a larger [`sideways_error`](Object::sideways_error) are tested for every ray: in the tree, they would
/// keep it from culling all others.
const LARGEST_SIDEWAYS_ERROR: Real = 1e-9;

/// Largest number of bounded objects that a loop tests faster than a tree.
pub const LOOP_OBJECTS: usize = 16;

/// The objects that are tested for every ray, and a tree of the others.
#[derive(Debug)]
pub struct ObjectTree {
    /// Indices of the objects outside the tree: planes, and everything in a small scene.
    pub always: Vec<u32>,
    /// A leaf is an object's index.
    pub bvh: Option<Bvh<u32>>,
}

impl ObjectTree {
    pub fn build(objects: &[Object]) -> Self {
        let all = || 0..objects.len() as u32;
        let sideways_error = |index: u32| objects[index as usize].sideways_error;
        let bounds = |index: u32| {
            let bounds =
                objects[index as usize].bounds.filter(|_| sideways_error(index) <= LARGEST_SIDEWAYS_ERROR);
            bounds.map(|bounds| (index, bounds))
        };
        let bounded: Vec<(u32, Aabb)> = all().filter_map(bounds).collect();
        let none = || Self { always: all().collect(), bvh: None };
        if bounded.len() <= LOOP_OBJECTS {
            return none();
        }
        let around = bounded.iter().fold(Aabb::EMPTY, |all, bounded| all.union(&bounded.1));
        let largest_error = bounded.iter().map(|bounded| sideways_error(bounded.0)).fold(0.0, Real::max);
        let Some(space) = CullingSpace::new(around) else { return none() };
        let space = space.with_sideways_error(largest_error);
        let item = |(index, bounds): &(u32, Aabb)| Item::new(*index, &space.planes(bounds));
        let items = bounded.par_iter().map(item).collect();
        drop(bounded);
        let bvh = Some(build::build::<1, _>(space, items, |index| index[0]));
        Self { always: all().filter(|&index| bounds(index).is_none()).collect(), bvh }
    }
}
