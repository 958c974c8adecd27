//! [`Accelerator`]: from a ray to the object that it hits.

use super::beam::{BEAM_RAYS, Beam, BeamWalk, Leaves, numbers_in};
use super::build::{self, Item};
use super::bundle::{MakeBundle, Meeting};
use super::frame::{Entry, Frame};
use super::simd::{Lanes, Level};
use super::tree::{Child, Tree};
use super::walk::{Call, DONE, Walk};
use crate::objects::{Aabb, Mesh, Object, ObjectHit, PreparedRay, Ray, Shape, T_MAX};
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
        let bounded: Vec<u32> = all().filter(|index| bounds(index).is_some()).collect();
        if bounded.len() > LOOP_OBJECTS {
            let around = bounded.iter().filter_map(bounds).fold(Aabb::EMPTY, |all, one| all.union(&one));
            let all_finite = bounded.iter().filter_map(bounds).all(|b| b.min.is_finite() && b.max.is_finite());
            let largest_spread = bounded.iter().map(spread).fold(0.0, Real::max);
            if let Some(frame) = Frame::new(around).filter(|_| all_finite) {
                let frame = frame.with_spread(largest_spread);
                let boxes = bounded.iter().filter_map(bounds);
                let items = boxes.zip(0..).map(|(bounds, number)| Item::new(number, &frame.planes(&bounds)));
                let built = build::build(items.collect(), 1);
                let object_of = |&(start, _): &(u32, u32)| bounded[built.numbers[start as usize] as usize];
                let treed = built.leaves.iter().map(object_of).collect();
                let treed = Some(ObjectTree { frame, tree: built.tree, objects: treed });
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
        let mut search = Search { objects, meshes, closest: None };
        self.candidates(&ray, T_MAX, |index| search.ask(&ray, index));
        search.closest
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
                let (tree, limit) = (&treed.tree, cull_ray.limit(t_max));
                self.level.run(Walk { tree, start: Child::node(0), ray: &cull_ray, limit, visit: &mut visit });
            }
        }
    }

    /// [`closest_hit`](Self::closest_hit) of many rays, best such as lie side by side: `hits` gets an entry for each.
    pub fn closest_hits(&self, objects: &[Object], meshes: &[Mesh], rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        hits.clear();
        for rays in rays.chunks(BEAM_RAYS) {
            let search = Search { objects, meshes, closest: None };
            let mut closest = Closest { searches: [search; BEAM_RAYS] };
            self.candidates_of_many(objects, rays, rays.len(), &mut closest);
            hits.extend(closest.searches[..rays.len()].iter().map(|search| search.closest));
        }
    }

    /// [`any_hit`](Self::any_hit) of many rays, each with its `t_max`: `found` gets an entry for each.
    pub fn any_hits(
        &self,
        objects: &[Object],
        meshes: &[Mesh],
        rays: &[Ray],
        t_max: &[Real],
        found: &mut Vec<bool>,
    ) {
        found.clear();
        for (rays, limits) in rays.chunks(BEAM_RAYS).zip(t_max.chunks(BEAM_RAYS)) {
            let mut t_max = [0.0; BEAM_RAYS];
            for (t_max, limit) in t_max.iter_mut().zip(limits) {
                *t_max = limit.min(T_MAX.next_down());
            }
            let mut any = Any { objects, meshes, t_max, found: 0 };
            self.candidates_of_many(objects, rays, rays.len(), &mut any);
            found.extend((0..rays.len()).map(|number| any.found >> number & 1 == 1));
        }
    }

    fn candidates_of_many(&self, objects: &[Object], rays: &[Ray], count: usize, questions: &mut impl Questions) {
        let mut open = u64::MAX >> (BEAM_RAYS - count);
        let bundle = self.level.run(MakeBundle(rays));
        let mut prepared = Prepared { rays, done: 0, prepared: [PreparedRay::NONE; BEAM_RAYS] };
        for &index in &self.loose {
            let mut mask = open;
            let object = &objects[index as usize];
            if let Some(bounds) = &object.bounds {
                mask = self.level.run(Meeting { bundle: &bundle, bounds, spread: object.spread, mask });
            }
            if mask == 0 {
                continue;
            }
            let object = &objects[index as usize];
            match &object.shape {
                Shape::Plane(plane) if object.bounds.is_none() => {
                    object.plane_hits(plane, rays, mask, |number, t| questions.take(index, number, t));
                }
                _ => questions.ask(index, prepared.rays(mask), mask),
            }
            open = questions.open(open);
        }
        let Some(treed) = &self.treed else { return };
        let (bounds, spread) = (treed.frame.bounds(), treed.frame.spread());
        let mask = self.level.run(Meeting { bundle: &bundle, bounds, spread, mask: open });
        let (mut beam, mut met, mut unknown) = (Beam::EMPTY, 0, 0);
        let rays = prepared.rays(mask);
        for number in numbers_in(mask) {
            let t_max = questions.t_max(number);
            match treed.frame.enter(&rays[number], t_max) {
                Entry::Missed => {}
                Entry::Unknown => unknown |= 1 << number,
                Entry::Met(ray) => {
                    met |= 1 << number;
                    beam.set(number, ray, t_max);
                }
            }
        }
        let leaves = ObjectLeaves { objects: &treed.objects, rays, questions };
        if met != 0 {
            self.level.run(BeamWalk { tree: &treed.tree, beam: &mut beam, mask: met, leaves });
        }
        for &index in &treed.objects {
            let unknown = questions.open(unknown);
            if unknown == 0 {
                break;
            }
            questions.ask(index, rays, unknown);
        }
    }
}

/// Rays that are prepared when they are first needed.
struct Prepared<'a> {
    rays: &'a [Ray],
    done: u64,
    prepared: [PreparedRay; BEAM_RAYS],
}

impl Prepared<'_> {
    /// All rays, of which at least those of a mask are prepared.
    fn rays(&mut self, mask: u64) -> &[PreparedRay; BEAM_RAYS] {
        for number in numbers_in(mask & !self.done) {
            self.prepared[number] = PreparedRay::new(self.rays[number]);
        }
        self.done |= mask;
        &self.prepared
    }
}

/// What many rays want to know.
trait Questions {
    /// The rays of a mask that still want to know.
    fn open(&self, mask: u64) -> u64;
    /// How far a ray still looks; minus infinity if no further.
    fn t_max(&self, number: usize) -> Real;
    /// Asks an object about the rays of a mask.
    fn ask(&mut self, index: u32, rays: &[PreparedRay; BEAM_RAYS], mask: u64);
    /// Hears that a ray hits an object at t.
    fn take(&mut self, index: u32, number: usize, t: Real);
}

struct ObjectLeaves<'a, Q> {
    objects: &'a [u32],
    rays: &'a [PreparedRay; BEAM_RAYS],
    questions: &'a mut Q,
}

impl<Q: Questions> Leaves for ObjectLeaves<'_, Q> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, _: L, leaf: usize, rays: u64, beam: &mut Beam) {
        self.questions.ask(self.objects[leaf], self.rays, rays);
        for number in numbers_in(rays) {
            if beam.limit(number) > DONE {
                beam.set_t_max(number, self.questions.t_max(number));
            }
        }
    }
}

/// So many rays in one mesh are worth a beam.
const BEAM_WORTH: u32 = 4;

/// The nearest hits of many rays.
struct Closest<'a> {
    searches: [Search<'a>; BEAM_RAYS],
}

impl Questions for Closest<'_> {
    fn open(&self, mask: u64) -> u64 {
        mask
    }

    fn t_max(&self, number: usize) -> Real {
        self.searches[number].t_max()
    }

    fn ask(&mut self, index: u32, rays: &[PreparedRay; BEAM_RAYS], mask: u64) {
        let Search { objects, meshes, .. } = self.searches[0];
        let object = &objects[index as usize];
        match object.shape {
            Shape::Mesh(mesh) if mask.count_ones() >= BEAM_WORTH => {
                let mut limits = [0.0; BEAM_RAYS];
                for number in numbers_in(mask) {
                    limits[number] = self.searches[number].limit_for(index);
                }
                let searches = &mut self.searches;
                object.closest_mesh_hits(&meshes[mesh as usize], rays, mask, &limits, |number, at| {
                    searches[number].closest = Some(Hit { object: index, at });
                });
            }
            _ => {
                for number in numbers_in(mask) {
                    self.searches[number].ask(&rays[number], index);
                }
            }
        }
    }

    fn take(&mut self, index: u32, number: usize, t: Real) {
        let search = &mut self.searches[number];
        if t < search.limit_for(index) {
            search.closest = Some(Hit { object: index, at: ObjectHit::at(t) });
        }
    }
}

/// Whether anything is in the way of many rays.
struct Any<'a> {
    objects: &'a [Object],
    meshes: &'a [Mesh],
    t_max: [Real; BEAM_RAYS],
    /// Rays that something is in the way of.
    found: u64,
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

/// The nearest hit so far.
#[derive(Clone, Copy)]
struct Search<'a> {
    objects: &'a [Object],
    meshes: &'a [Mesh],
    closest: Option<Hit>,
}

impl Search<'_> {
    fn t_max(&self) -> Real {
        self.closest.map_or(T_MAX, |closest| closest.at.t)
    }

    /// Hits of an object count below this t. Of equals the first object wins, whatever the order of asking.
    fn limit_for(&self, index: u32) -> Real {
        let comes_first = self.closest.is_some_and(|closest| index < closest.object);
        if comes_first { self.t_max().next_up() } else { self.t_max() }
    }

    /// Asks one object and returns the new limit.
    fn ask(&mut self, ray: &PreparedRay, index: u32) -> Real {
        if let Some(at) = self.objects[index as usize].closest_hit(self.meshes, ray, self.limit_for(index)) {
            self.closest = Some(Hit { object: index, at });
        }
        self.t_max()
    }
}
