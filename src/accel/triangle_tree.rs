//! [`TriangleTree`]: from a ray to the few triangles of a mesh that it might hit.

use super::beam::{BEAM_RAYS, Beam, BeamWalk, Leaves, numbers_in};
use super::build::{self, Item};
use super::frame::{CullRay, Entry, Frame, Planes};
use super::kept::Kept;
use super::simd::{Lanes, Level, WIDTH};
use super::tree::{Child, Tree};
use super::triangles::Block;
use super::walk::{DONE, Visit, Walk};
use crate::objects::{Aabb, PreparedRay};
use rayon::prelude::*;
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
}

impl TriangleTree {
    /// A tree over triangles 0 to `count`, which lie in `bounds`.
    pub fn build(count: usize, bounds: &Aabb, corners: impl Fn(u32) -> [Vector3; 3] + Sync) -> Self {
        let is_finite = |triangle| corners(triangle).iter().all(|corner| corner.is_finite());
        let all_finite = (0..count as u32).into_par_iter().all(is_finite);
        let frame = Frame::new(*bounds).filter(|_| all_finite);
        let culled = frame.map(|frame| Culled::build(frame, count, &corners));
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
                let limit = cull_ray.limit(t_max);
                let decide = |triangle| cull_ray.limit(decide(triangle));
                let (tree, start) = (&culled.tree, Child::node(0));
                let mut visit = BlockVisit { blocks: &culled.blocks, ray: &cull_ray, limit, decide };
                if !tree.nodes.is_empty() {
                    self.level.run(Walk { tree, start, ray: &cull_ray, limit, visit: &mut visit });
                }
            }
        }
    }

    /// [`candidates`](Self::candidates) of several rays, at most 64: those of `mask`. `decide` is told the ray's number
    /// as well. `near` are places where rays enter a box not much larger than the mesh's, if such are known.
    #[inline]
    pub fn candidates_of_many(
        &self,
        rays: &[PreparedRay],
        mask: u64,
        near: Option<&[Real; BEAM_RAYS]>,
        t_max: &[Real],
        mut decide: impl FnMut(usize, u32) -> Real,
    ) {
        let mut unknown = mask;
        if let Some(culled) = &self.culled {
            let mut beam = BEAM.take().unwrap_or_else(|| Box::new(Beam::EMPTY));
            beam.clear();
            let mut met = 0;
            unknown = 0;
            for number in numbers_in(mask) {
                let entry = match near {
                    Some(near) => culled.frame.enter_at(&rays[number].ray, near[number]),
                    None => culled.frame.enter(&rays[number], t_max[number]),
                };
                match entry {
                    Entry::Missed => {}
                    Entry::Unknown => unknown |= 1 << number,
                    Entry::Met(ray) => {
                        met |= 1 << number;
                        beam.set(number, ray, t_max[number]);
                    }
                }
            }
            let leaves = BlockLeaves { blocks: &culled.blocks, decide: &mut decide };
            if met != 0 {
                self.level.run(BeamWalk { tree: &culled.tree, beam: &mut beam, mask: met, leaves });
            }
            BEAM.set(Some(beam));
        }
        for number in numbers_in(unknown) {
            let _ = (0..self.count).any(|triangle| decide(number, triangle) == Real::NEG_INFINITY);
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
    fn build(frame: Frame, count: usize, corners: &(impl Fn(u32) -> [Vector3; 3] + Sync)) -> Self {
        let numbers = (0..count as u32).into_par_iter();
        let planes = |number| -> Planes { frame.planes(&Aabb::of_points(corners(number))) };
        let items: Vec<Item> = numbers.map(|number| Item::new(number, &planes(number))).collect();
        let built = build::build(items, WIDTH);
        let block = |&(start, length): &(u32, u32)| {
            let numbers = &built.numbers[start as usize..(start + length) as usize];
            Block::new(&frame, numbers.iter().map(|&number| (number, corners(number))))
        };
        let blocks = built.leaves.par_iter().map(block).collect();
        Self { frame, tree: built.tree, blocks }
    }
}

/// Leaves that are blocks of triangles, for one ray. `decide` returns the limit in the frame.
struct BlockVisit<'a, D> {
    blocks: &'a [Block],
    ray: &'a CullRay,
    limit: f32,
    decide: D,
}

impl<D: FnMut(u32) -> f32> Visit for BlockVisit<'_, D> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, l: L, leaf: usize) -> f32 {
        let block = &self.blocks[leaf];
        let mut survivors = block.survivors(l, self.ray.origin, self.ray.direction, self.limit);
        while survivors != 0 && self.limit > DONE {
            self.limit = (self.decide)(block.number(survivors.trailing_zeros()));
            survivors &= survivors - 1;
        }
        self.limit
    }
}

/// Leaves that are blocks of triangles.
struct BlockLeaves<'a, D> {
    blocks: &'a [Block],
    decide: &'a mut D,
}

impl<D: FnMut(usize, u32) -> Real> Leaves for BlockLeaves<'_, D> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, l: L, leaf: usize, rays: u64, beam: &mut Beam) {
        let block = &self.blocks[leaf];
        for number in numbers_in(rays) {
            let ray = beam.ray(number);
            let mut survivors = block.survivors(l, ray.origin, ray.direction, beam.limit(number));
            while survivors != 0 && beam.limit(number) > DONE {
                let t_max = (self.decide)(number, block.number(survivors.trailing_zeros()));
                beam.set_t_max(number, t_max);
                survivors &= survivors - 1;
            }
        }
    }
}
