//! [`Accelerator`]: from a ray to the object that it hits.

use super::beam::{BEAM_RAYS, Beam, BeamWalk, Leaves, numbers_in};
use super::build::{self, Item};
use super::bundle::{Bundle, FillBundle, Meeting};
use super::frame::{Entry, Frame};
use super::kept::Kept;
use super::questions::{Any, Closest, Questions, Search};
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
                let (tree, limit) = (&treed.tree, cull_ray.limit(t_max));
                self.level.run(Walk { tree, start: Child::node(0), ray: &cull_ray, limit, visit: &mut visit });
            }
        }
    }

    /// [`closest_hit`](Self::closest_hit) of many rays, best such as lie side by side: `hits` gets an entry for each.
    pub fn closest_hits(&self, objects: &[Object], meshes: &[Mesh], rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        hits.clear();
        for rays in rays.chunks(BEAM_RAYS) {
            let first = hits.len();
            hits.extend(std::iter::repeat_with(|| None).take(rays.len()));
            let mut closest = Closest { objects, meshes, hits: &mut hits[first..] };
            self.candidates_of_many(objects, rays, &mut closest);
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
            self.candidates_of_many(objects, rays, &mut any);
            found.extend((0..rays.len()).map(|number| any.found >> number & 1 == 1));
        }
    }

    fn candidates_of_many(&self, objects: &[Object], rays: &[Ray], questions: &mut impl Questions) {
        let mut scratch = SCRATCH.take().unwrap_or_default();
        let Scratch { bundle, prepared, beam } = &mut *scratch;
        self.level.run(FillBundle { bundle, rays });
        let mut prepared = Prepared { rays, done: 0, prepared };
        let open = u64::MAX >> (BEAM_RAYS - rays.len());
        let open = self.ask_loose(objects, bundle, &mut prepared, open, questions);
        if let Some(treed) = &self.treed {
            treed.ask_many(self.level, bundle, &mut prepared, beam, open, questions);
        }
        SCRATCH.set(Some(scratch));
    }

    /// Asks the objects outside the tree about the rays of a mask, and returns those that still want to know.
    fn ask_loose(
        &self,
        objects: &[Object],
        bundle: &Bundle,
        prepared: &mut Prepared,
        mut open: u64,
        questions: &mut impl Questions,
    ) -> u64 {
        for &index in &self.loose {
            let mut mask = open;
            let object = &objects[index as usize];
            if let Some(bounds) = &object.bounds {
                mask = self.level.run(Meeting { bundle, bounds, spread: object.spread, mask });
            }
            if mask == 0 {
                continue;
            }
            match &object.shape {
                Shape::Plane(plane) if object.bounds.is_none() => {
                    object.plane_hits(plane, prepared.rays, mask, |number, t| questions.take(index, number, t));
                }
                _ => questions.ask(index, prepared.prepare(mask), mask),
            }
            open = questions.open(open);
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
        prepared: &mut Prepared,
        beam: &mut Beam,
        mask: u64,
        questions: &mut impl Questions,
    ) {
        let (bounds, spread) = (self.frame.bounds(), self.frame.spread());
        let mask = level.run(Meeting { bundle, bounds, spread, mask });
        let (mut met, mut unknown) = (0, 0);
        beam.clear();
        let rays = prepared.prepare(mask);
        for number in numbers_in(mask) {
            let t_max = questions.t_max(number);
            match self.frame.enter(&rays[number], t_max) {
                Entry::Missed => {}
                Entry::Unknown => unknown |= 1 << number,
                Entry::Met(ray) => {
                    met |= 1 << number;
                    beam.set(number, ray, t_max);
                }
            }
        }
        let leaves = ObjectLeaves { objects: &self.objects, rays, questions };
        if met != 0 {
            level.run(BeamWalk { tree: &self.tree, beam, mask: met, leaves });
        }
        for &index in &self.objects {
            let unknown = questions.open(unknown);
            if unknown == 0 {
                break;
            }
            questions.ask(index, rays, unknown);
        }
    }
}

/// What a run of rays needs room for.
struct Scratch {
    bundle: Bundle,
    prepared: [PreparedRay; BEAM_RAYS],
    beam: Beam,
}

thread_local! {
    static SCRATCH: Kept<Scratch> = const { Kept::new(None) };
}

impl Default for Scratch {
    fn default() -> Self {
        Self { bundle: Bundle::EMPTY, prepared: [PreparedRay::NONE; BEAM_RAYS], beam: Beam::EMPTY }
    }
}

/// Rays that are prepared when they are first needed.
struct Prepared<'a> {
    rays: &'a [Ray],
    done: u64,
    prepared: &'a mut [PreparedRay; BEAM_RAYS],
}

impl Prepared<'_> {
    /// All rays, of which at least those of a mask are prepared.
    fn prepare(&mut self, mask: u64) -> &[PreparedRay; BEAM_RAYS] {
        for number in numbers_in(mask & !self.done) {
            self.prepared[number] = PreparedRay::new(self.rays[number]);
        }
        self.done |= mask;
        self.prepared
    }
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
