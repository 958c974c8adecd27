//! [`Accelerator`]: from a ray to the object that it hits.

use super::beam::{Beam, BeamWalk, Leaves};
use super::build::{self, Built};
use super::bundle::{Bundle, FillBundle, Meeting};
use super::frame::{Entry, Frame};
use super::kept::Kept;
use super::questions::{Any, Closest, Questions, Search};
use super::shaft::Shaft;
use super::simd::{Lanes, Level};
use super::split::Item;
use super::tree::Tree;
use super::walk::{Call, DONE, walk_all};
use crate::objects::HitRun;
use crate::objects::run::{Numbers, RayRun, Vectors, WorldRun, numbers_in};
use crate::objects::{Aabb, Mesh, Object, ObjectHit, PreparedRay, Ray, T_MAX};
use rayon::prelude::*;
use vecmath::Real;

/// A hit and whose it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index into the scene's objects.
    pub object: u32,
    pub at: ObjectHit,
}

/// Objects so distorted that rays meet them with more spread than this are asked one by one: in a tree they would keep
/// it from culling for all the others.
const LARGEST_SPREAD: Real = 1e-9;

/// Up to so many bounded objects are asked one by one.
pub const LOOP_OBJECTS: usize = 16;

/// The objects of a scene, sorted for finding hits.
#[derive(Debug)]
pub struct Accelerator {
    /// Objects to be asked for every ray: planes, and everything in a small scene.
    loose: Vec<u32>,
    /// The other ones.
    treed: Option<ObjectTree>,
    level: Level,
}

#[derive(Debug)]
struct ObjectTree {
    frame: Frame,
    tree: Tree,
    /// The object of each leaf.
    objects: Vec<u32>,
}

impl Accelerator {
    pub fn new(objects: &[Object]) -> Self {
        Self::with_level(objects, Level::detected())
    }

    /// An accelerator that culls at this processor level.
    pub fn with_level(objects: &[Object], level: Level) -> Self {
        let all = || 0..objects.len() as u32;
        let spread = |index: &u32| objects[*index as usize].spread;
        let bounds = |index: &u32| objects[*index as usize].bounds.filter(|_| spread(index) <= LARGEST_SPREAD);
        let bounded: Vec<(u32, Aabb)> = all().filter_map(|index| Some((index, bounds(&index)?))).collect();
        if bounded.len() > LOOP_OBJECTS {
            let around = bounded.iter().fold(Aabb::EMPTY, |all, (_, bounds)| all.union(bounds));
            let all_finite = bounded.iter().all(|(_, b)| b.min.is_finite() && b.max.is_finite());
            let largest_spread = bounded.iter().map(|(index, _)| spread(index)).fold(0.0, Real::max);
            if let Some(frame) = Frame::new(around).filter(|_| all_finite) {
                let frame = frame.with_spread(largest_spread);
                let item = |(index, bounds): &(u32, Aabb)| Item::new(*index, &frame.planes(bounds));
                let items = bounded.par_iter().map(item).collect();
                drop(bounded);
                let Built { tree, leaves, numbers } = build::build::<1>(items);
                let treed = leaves.iter().map(|&(place, _)| numbers[place as usize]).collect();
                let treed = Some(ObjectTree { frame, tree, objects: treed });
                return Self { loose: all().filter(|index| bounds(index).is_none()).collect(), treed, level };
            }
        }
        Self { loose: all().collect(), treed: None, level }
    }

    pub fn has_tree(&self) -> bool {
        self.treed.is_some()
    }

    /// The nearest hit with 0 < t < [`T_MAX`]; of several at the same t, the first object's.
    pub fn closest_hit(&self, objects: &[Object], meshes: &[Mesh], ray: &Ray) -> Option<Hit> {
        let ray = PreparedRay::new(*ray);
        let mut closest = None;
        let mut search = Search { objects, meshes, closest: &mut closest };
        self.candidates(&ray, T_MAX, |index| search.ask(&ray, index));
        closest
    }

    /// Whether anything is hit at a t up to and including `t_max`.
    pub fn any_hit(&self, objects: &[Object], meshes: &[Mesh], ray: &Ray, t_max: Real) -> bool {
        let ray = PreparedRay::new(*ray);
        let t_max = t_max.min(T_MAX.next_down());
        let mut found = false;
        self.candidates(&ray, t_max, |index| {
            found = found || objects[index as usize].any_hit(meshes, &ray, t_max);
            if found { Real::NEG_INFINITY } else { t_max }
        });
        found
    }

    /// Calls `ask` with every object that the ray may hit at a t up to and including `t_max`, and perhaps others. `ask`
    /// returns the new `t_max`: minus infinity ends the search.
    fn candidates(&self, ray: &PreparedRay, t_max: Real, mut ask: impl FnMut(u32) -> Real) {
        let mut t_max = t_max;
        for &index in &self.loose {
            t_max = ask(index);
            if t_max == Real::NEG_INFINITY {
                return;
            }
        }
        let Some(treed) = &self.treed else { return };
        match treed.frame.enter(ray, t_max) {
            Entry::Missed => {}
            Entry::Unknown => {
                let _ = treed.objects.iter().any(|&index| ask(index) == Real::NEG_INFINITY);
            }
            Entry::Met(cull_ray) => {
                let mut visit = Call(|leaf: usize| cull_ray.limit(ask(treed.objects[leaf])));
                walk_all(self.level, &treed.tree, &cull_ray, cull_ray.limit(t_max), &mut visit);
            }
        }
    }

    /// [`closest_hit`](Self::closest_hit) of the rays of a mask, best such as lie side by side.
    pub fn closest_hits(&self, objects: &[Object], meshes: &[Mesh], rays: &RayRun, mask: u64, hits: &mut HitRun) {
        hits.clear();
        self.candidates_of_many(objects, rays, mask, &mut Closest { objects, meshes, hits });
    }

    /// [`any_hit`](Self::any_hit) of the rays of a mask, each with its `t_max`; as a mask.
    pub fn any_hits(&self, objects: &[Object], meshes: &[Mesh], rays: &RayRun, mask: u64, t_max: &Numbers) -> u64 {
        let t_max = t_max.map(|t_max| t_max.min(T_MAX.next_down()));
        let mut any = Any { objects, meshes, t_max, found: 0 };
        self.candidates_of_many(objects, rays, mask, &mut any);
        any.found
    }

    fn candidates_of_many(&self, objects: &[Object], rays: &RayRun, mask: u64, questions: &mut impl Questions) {
        if mask == 0 {
            return;
        }
        let mut scratch = SCRATCH.take().unwrap_or_default();
        let Scratch { bundle, inverse_direction, beam } = &mut *scratch;
        self.level.run(FillBundle { bundle, rays, mask });
        let mut world = WorldRun::new(rays, mask, inverse_direction);
        let open = self.ask_loose(objects, bundle, &mut world, mask, questions);
        if let Some(treed) = &self.treed {
            treed.ask_many(self.level, bundle, &mut world, beam, open, questions);
        }
        SCRATCH.set(Some(scratch));
    }

    /// Asks the objects outside the tree about the rays of a mask, and returns those that still want to know.
    fn ask_loose(
        &self,
        objects: &[Object],
        bundle: &Bundle,
        world: &mut WorldRun,
        mut open: u64,
        questions: &mut impl Questions,
    ) -> u64 {
        for &index in &self.loose {
            let mut mask = open;
            let object = &objects[index as usize];
            if let Some(bounds) = &object.bounds {
                mask = self.level.run(Meeting { bundle, bounds, spread: object.spread, mask });
            }
            if mask != 0 {
                questions.ask(index, self.level, world, mask);
                open = questions.open(open);
            }
        }
        open
    }
}

impl ObjectTree {
    /// Asks the objects about the rays of a mask.
    fn ask_many(
        &self,
        level: Level,
        bundle: &Bundle,
        world: &mut WorldRun,
        beam: &mut Beam,
        mask: u64,
        questions: &mut impl Questions,
    ) {
        let (bounds, spread) = (self.frame.bounds(), self.frame.spread());
        let mask = level.run(Meeting { bundle, bounds, spread, mask });
        if mask == 0 {
            return;
        }
        let (frame, rays, t_max) = (&self.frame, world.prepared(level), questions.t_max());
        let (met, unknown) = frame.enter_many(level, rays, mask, t_max, beam);
        if met != 0 {
            let leaves = ObjectLeaves { objects: &self.objects, level, world, questions };
            level.run(BeamWalk { tree: &self.tree, beam, mask: met, leaves });
        }
        for &index in &self.objects {
            let unknown = questions.open(unknown);
            if unknown == 0 {
                break;
            }
            questions.ask(index, level, world, unknown);
        }
    }
}

/// What a run of rays needs room for.
struct Scratch {
    bundle: Bundle,
    inverse_direction: Vectors,
    beam: Beam,
}

thread_local! {
    static SCRATCH: Kept<Scratch> = const { Kept::new(None) };
}

impl Default for Scratch {
    fn default() -> Self {
        Self { bundle: Bundle::EMPTY, inverse_direction: Vectors::ZERO, beam: Beam::EMPTY }
    }
}

struct ObjectLeaves<'a, 'b, Q> {
    objects: &'a [u32],
    level: Level,
    world: &'a mut WorldRun<'b>,
    questions: &'a mut Q,
}

impl<Q: Questions> Leaves for ObjectLeaves<'_, '_, Q> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, _: L, leaf: usize, rays: u64, _: Option<&Shaft>, beam: &mut Beam) {
        self.questions.ask(self.objects[leaf], self.level, self.world, rays);
        for number in numbers_in(rays) {
            if beam.limit(number) > DONE {
                beam.set_t_max(number, self.questions.t_max()[number]);
            }
        }
    }

    #[inline(always)]
    fn survivors<L: Lanes>(&self, _: L, _: usize, _: usize, _: &Beam) -> u32 {
        1
    }

    #[inline(always)]
    fn ask<L: Lanes>(&mut self, l: L, leaf: usize, _: u32, number: usize, beam: &mut Beam) {
        self.visit(l, leaf, 1 << number, None, beam);
    }
}
