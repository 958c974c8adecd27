//! [`TriangleTree`]: from a ray to the few triangles of a mesh that it might hit.

use super::beam::{Beam, BeamWalk, FEW, GROUPS, Leaves};
use super::build;
use super::frame::{CullRay, Entry, Frame};
use super::kept::Kept;
use super::shaft::Shaft;
use super::simd::{Lanes, Level, WIDTH};
use super::split::Item;
use super::tree::Tree;
use super::triangles::Block;
use super::walk::{DONE, Visit, walk_all};
use crate::objects::run::{Numbers, PreparedRun, is_dense, numbers_in};
use crate::objects::{Aabb, PreparedRay};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use vecmath::{Real, Vector3};

thread_local! {
    static BEAM: Kept<Beam> = const { Kept::new(None) };
}

/// The triangles of a mesh, sorted for finding hits. Whoever asks gets candidates and decides: see
/// [`candidates`](Self::candidates).
#[derive(Debug)]
pub struct TriangleTree {
    /// `None` where positions are not finite: every triangle is a candidate.
    culled: Option<Culled>,
    count: u32,
    level: Level,
}

#[derive(Debug)]
struct Culled {
    frame: Frame,
    tree: Tree,
    /// One a leaf.
    blocks: Vec<Block>,
    /// Whether the corners in the blocks are the mesh's, to the last bit.
    is_exact: bool,
}

impl TriangleTree {
    /// A tree over triangles 0 to `count`, which lie in `bounds`. The coordinates of their corners are numbers of `f32`.
    pub fn build(count: usize, bounds: &Aabb, corners: impl Fn(u32) -> [Vector3; 3] + Sync) -> Self {
        let culled = Frame::of_positions(*bounds).and_then(|frame| Culled::build(frame, count, &corners));
        Self { culled, count: count as u32, level: Level::detected() }
    }

    /// Culls at this processor level from now on.
    pub fn set_level(&mut self, level: Level) {
        self.level = level;
    }

    /// Calls `decide` with every triangle that the ray may hit at a t up to and including `t_max`, and perhaps others;
    /// with some of them again, perhaps. `decide` returns the new `t_max`: minus infinity ends the search.
    #[inline]
    pub fn candidates(&self, ray: &PreparedRay, t_max: Real, mut decide: impl FnMut(u32) -> Real) {
        let entry = self.culled.as_ref().map(|culled| (culled, culled.frame.enter(ray, t_max)));
        match entry {
            None | Some((_, Entry::Unknown)) => {
                let _ = (0..self.count).any(|triangle| decide(triangle) == Real::NEG_INFINITY);
            }
            Some((_, Entry::Missed)) => {}
            Some((culled, Entry::Met(cull_ray))) => {
                let (limit, center) = (cull_ray.limit(t_max), culled.frame.scaled_center());
                let decide = |triangle| cull_ray.limit(decide(triangle));
                let mut visit = BlockVisit { blocks: &culled.blocks, center, ray: &cull_ray, limit, decide };
                walk_all(self.level, &culled.tree, &cull_ray, limit, &mut visit);
            }
        }
    }

    /// [`candidates`](Self::candidates) of the rays of a mask.
    pub fn candidates_of_many(&self, rays: PreparedRun, mask: u64, decide: &mut impl Decide) {
        let mut unknown = mask;
        if let Some(culled @ Culled { frame, tree, .. }) = &self.culled {
            let mut beam = BEAM.take().unwrap_or_else(|| Box::new(Beam::EMPTY));
            let met;
            (met, unknown) = frame.enter_many(self.level, rays, mask, decide.t_max(), &mut beam);
            if met != 0 {
                let leaves = BlockLeaves { culled, center: frame.scaled_center(), decide };
                self.level.run(BeamWalk { tree, beam: &mut beam, mask: met, leaves });
            }
            BEAM.set(Some(beam));
        }
        for number in numbers_in(unknown) {
            for triangle in 0..self.count {
                if decide.t_max()[number] > Real::NEG_INFINITY {
                    decide.one(number, triangle, None);
                }
            }
        }
    }

    /// Bytes on the heap.
    pub fn bytes(&self) -> usize {
        self.culled
            .as_ref()
            .map_or(0, |culled| size_of_val(culled.tree.nodes.as_slice()) + size_of_val(culled.blocks.as_slice()))
    }

    /// Whether the tree's structure is sound and every triangle is in it once; see [`Tree::validate`].
    ///
    /// # Errors
    /// The first flaw in words.
    pub fn validate(&self, corners: impl Fn(u32) -> [Vector3; 3]) -> Result<(), String> {
        let Some(culled) = &self.culled else { return Ok(()) };
        let planes = |leaf: usize| {
            let points = culled.blocks[leaf].numbers().iter().flat_map(|&number| corners(number));
            culled.frame.planes(&Aabb::of_points(points))
        };
        culled.tree.validate(culled.blocks.len(), planes)?;
        let mut seen = vec![false; self.count as usize];
        for &number in culled.blocks.iter().flat_map(Block::numbers) {
            if std::mem::replace(&mut seen[number as usize], true) {
                return Err(format!("triangle {number} is in two leaves"));
            }
        }
        if seen.contains(&false) { Err("a triangle is in no leaf".into()) } else { Ok(()) }
    }
}

impl Culled {
    /// `None` where a corner is not finite.
    fn build(frame: Frame, count: usize, corners: &(impl Fn(u32) -> [Vector3; 3] + Sync)) -> Option<Self> {
        let (all_finite, is_exact) = (AtomicBool::new(true), AtomicBool::new(true));
        let item = |number| {
            let corners = corners(number);
            if !corners.iter().all(|corner| corner.is_finite()) {
                all_finite.store(false, Ordering::Relaxed);
            }
            if !corners.iter().all(|&corner| frame.unscaled(frame.scaled(corner)) == corner) {
                is_exact.store(false, Ordering::Relaxed);
            }
            Item::new(number, &frame.planes(&Aabb::of_points(corners)))
        };
        let items: Vec<Item> = (0..count as u32).into_par_iter().map(item).collect();
        if !all_finite.into_inner() {
            return None;
        }
        let built = build::build::<WIDTH>(items);
        let block = |&(start, length): &(u32, u32)| {
            let numbers = &built.numbers[start as usize..(start + length) as usize];
            Block::new(&frame, numbers.iter().map(|&number| (number, corners(number))))
        };
        let blocks = built.leaves.par_iter().map(block).collect();
        Some(Self { frame, tree: built.tree, blocks, is_exact: is_exact.into_inner() })
    }
}

/// Leaves that are blocks of triangles, for one ray. `decide` returns the limit in the frame.
struct BlockVisit<'a, D> {
    blocks: &'a [Block],
    center: [f32; 3],
    ray: &'a CullRay,
    limit: f32,
    decide: D,
}

impl<D: FnMut(u32) -> f32> Visit for BlockVisit<'_, D> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, l: L, leaf: usize) -> f32 {
        let block = &self.blocks[leaf];
        let mut survivors = block.survivors(l, self.center, self.ray.in_all_lanes(l), self.limit);
        while survivors != 0 && self.limit > DONE {
            self.limit = (self.decide)(block.number(survivors.trailing_zeros()));
            survivors &= survivors - 1;
        }
        self.limit
    }
}

/// Who decides, in [`Real`], which triangles rays hit.
pub trait Decide {
    /// How far each ray still looks; minus infinity if no further.
    fn t_max(&self) -> &Numbers;
    /// Asks a triangle about a ray, perhaps not for the first time. Its corners are given if they are at hand.
    fn one(&mut self, number: usize, triangle: u32, corners: Option<[Vector3; 3]>);
    /// Asks a triangle about the rays of a mask.
    fn many<L: Lanes>(&mut self, lanes: L, mask: u64, triangle: u32, corners: Option<[Vector3; 3]>);
}

/// Leaves that are blocks of triangles.
struct BlockLeaves<'a, D> {
    culled: &'a Culled,
    /// See [`Frame::scaled_center`].
    center: [f32; 3],
    decide: &'a mut D,
}

impl<D: Decide> BlockLeaves<'_, D> {
    #[inline(always)]
    fn corners(&self, block: &Block, place: u32) -> Option<[Vector3; 3]> {
        self.culled.is_exact.then(|| block.corners_of(&self.culled.frame, place))
    }

    /// All rays and one triangle.
    #[inline(always)]
    fn visit_many<L: Lanes>(&mut self, l: L, block: &Block, place: u32, mask: u64, beam: &mut Beam) {
        let mut survivors = 0;
        let triangle = block.in_all_lanes(l, self.center, place);
        for group in 0..GROUPS {
            let here = mask >> (WIDTH * group) & 0xff;
            if here != 0 {
                let bits = block.may_hit(l, triangle, beam.group(l, group), l.load(&beam.limit[group]));
                survivors |= (here & u64::from(bits)) << (WIDTH * group);
            }
        }
        // Rays between those that survive are asked too, to no purpose.
        if is_dense(survivors, 4) {
            self.decide.many(l, survivors, block.number(place), self.corners(block, place));
            return beam.set_t_maxes(survivors, self.decide.t_max());
        }
        for number in numbers_in(survivors) {
            if beam.limit(number) > DONE {
                self.decide.one(number, block.number(place), self.corners(block, place));
                beam.set_t_max(number, self.decide.t_max()[number]);
            }
        }
    }
}

impl<D: Decide> Leaves for BlockLeaves<'_, D> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, l: L, leaf: usize, rays: u64, shaft: Option<&Shaft>, beam: &mut Beam) {
        let block = &self.culled.blocks[leaf];
        let mut places = block.all();
        if let (Some(shaft), true) = (shaft, rays.count_ones() > FEW) {
            (places, _) = shaft.boxes(l, &block.boxes(l, self.center), beam.largest_limit(l));
            places &= block.all();
            let groups = rays | rays >> 1 | rays >> 2 | rays >> 3;
            let groups = ((groups | groups >> 4) & 0x0101_0101_0101_0101).count_ones();
            if places.count_ones() * groups < rays.count_ones() {
                while places != 0 {
                    self.visit_many(l, block, places.trailing_zeros(), rays, beam);
                    places &= places - 1;
                }
                return;
            }
        }
        if places != 0 {
            for number in numbers_in(rays) {
                self.visit_one(l, leaf, number, beam);
            }
        }
    }

    #[inline(always)]
    fn survivors<L: Lanes>(&self, l: L, leaf: usize, number: usize, beam: &Beam) -> u32 {
        let ray = beam.in_all_lanes(l, number);
        self.culled.blocks[leaf].survivors(l, self.center, ray, beam.limit(number))
    }

    #[inline(always)]
    fn ask<L: Lanes>(&mut self, _: L, leaf: usize, place: u32, number: usize, beam: &mut Beam) {
        let block = &self.culled.blocks[leaf];
        self.decide.one(number, block.number(place), self.corners(block, place));
        beam.set_t_max(number, self.decide.t_max()[number]);
    }
}
