//! Finding the nearest of many objects without asking each.
//!
//! The contract: exactly the hit that a loop over all objects returns, to the last bit. Nobody who wants to understand
//! the picture needs to read further here. Boxes only ever discard what cannot be hit; the objects decide.

mod bvh;

pub use bvh::Bvh;

use crate::objects::{Aabb, Mesh, Object, ObjectHit, PreparedRay, Ray, T_MAX};
use vecmath::Real;

/// A hit and whose it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index into the scene's objects.
    pub object: u32,
    pub at: ObjectHit,
}

/// Up to so many bounded objects are asked one by one.
pub const LOOP_OBJECTS: usize = 4;

/// The objects of a scene, sorted for finding hits.
#[derive(Debug)]
pub struct Accelerator {
    /// Objects to be asked for every ray: planes, and everything in a small scene.
    loose: Vec<u32>,
    /// The other ones: the tree's items are indices into `treed`.
    tree: Option<Bvh>,
    treed: Vec<u32>,
}

impl Accelerator {
    pub fn new(objects: &[Object]) -> Self {
        let indices = 0..objects.len() as u32;
        let (bounded, unbounded): (Vec<u32>, Vec<u32>) =
            indices.partition(|&index| objects[index as usize].bounds.is_some());
        if bounded.len() <= LOOP_OBJECTS {
            let loose = (0..objects.len() as u32).collect();
            return Self { loose, tree: None, treed: Vec::new() };
        }
        let boxes: Vec<Aabb> = bounded.iter().filter_map(|&index| objects[index as usize].bounds).collect();
        Self { loose: unbounded, tree: Some(Bvh::build(&boxes)), treed: bounded }
    }

    pub fn has_tree(&self) -> bool {
        self.tree.is_some()
    }

    /// The nearest hit with 0 < t < [`T_MAX`]; of several at the same t, the first object's.
    pub fn closest_hit(&self, objects: &[Object], meshes: &[Mesh], ray: &Ray) -> Option<Hit> {
        let ray = PreparedRay::new(*ray);
        let mut search = Search { objects, meshes, ray: &ray, closest: None };
        for &index in &self.loose {
            search.ask(index);
        }
        if let Some(tree) = &self.tree {
            let t_max = search.t_max();
            tree.visit(&ray, t_max, |item| search.ask(self.treed[item as usize]));
        }
        search.closest
    }

    /// Whether anything is hit at a t up to and including `t_max`.
    pub fn any_hit(&self, objects: &[Object], meshes: &[Mesh], ray: &Ray, t_max: Real) -> bool {
        let ray = PreparedRay::new(*ray);
        let t_max = t_max.min(T_MAX.next_down());
        let is_hit = |index: u32| objects[index as usize].any_hit(meshes, &ray, t_max);
        self.loose.iter().any(|&index| is_hit(index))
            || self
                .tree
                .as_ref()
                .is_some_and(|tree| tree.visit_any(&ray, t_max, |item| is_hit(self.treed[item as usize])))
    }
}

/// The nearest hit so far.
struct Search<'a> {
    objects: &'a [Object],
    meshes: &'a [Mesh],
    ray: &'a PreparedRay,
    closest: Option<Hit>,
}

impl Search<'_> {
    fn t_max(&self) -> Real {
        self.closest.map_or(T_MAX, |closest| closest.at.t)
    }

    /// Asks one object and returns the new limit. Of equals the first object wins, whatever the order of asking.
    fn ask(&mut self, index: u32) -> Real {
        let comes_first = self.closest.is_some_and(|closest| index < closest.object);
        let limit = if comes_first { self.t_max().next_up() } else { self.t_max() };
        if let Some(at) = self.objects[index as usize].closest_hit(self.meshes, self.ray, limit) {
            self.closest = Some(Hit { object: index, at });
        }
        self.t_max()
    }
}
