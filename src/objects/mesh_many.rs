//! What many rays hit of a mesh: the definitions of [`Mesh`], asked for the rays of a run at once.

use super::ray::ShearAxes;
use super::run::{Numbers, PreparedRun, SurfaceRun, around, numbers_in};
use super::triangle::TriangleHits;
use super::{Mesh, ObjectHit, triangle_hit};
use crate::accel::Decide;
use crate::accel::simd::Lanes;
use vecmath::Real;

/// The index of no triangle: hits with it are limits.
pub const NO_TRIANGLE: u32 = u32::MAX;

impl Mesh {
    /// [`closest_hit`](Self::closest_hit) of the rays of a mask. `hits` says how far each ray looks (t below its t), and
    /// takes what it finds. There is room for what is found on the way in `found`.
    pub fn closest_hits(&self, rays: PreparedRun, mask: u64, found: &mut TriangleHits, hits: &mut SurfaceRun) {
        for number in numbers_in(mask) {
            hits.triangle[number] = NO_TRIANGLE;
        }
        self.ask(rays, mask, &mut Closest { asking: Asking::new(self, rays, mask, found), hits });
    }

    /// [`any_hit`](Self::any_hit) of the rays of a mask; as a mask.
    pub fn any_hits(&self, rays: PreparedRun, mask: u64, found: &mut TriangleHits, t_max: &Numbers) -> u64 {
        let mut any = Any { asking: Asking::new(self, rays, mask, found), t_max: *t_max, hit: 0 };
        self.ask(rays, mask, &mut any);
        any.hit
    }

    fn ask(&self, rays: PreparedRun, mask: u64, decide: &mut impl Decide) {
        if let Some(tree) = self.tree() {
            return tree.candidates_of_many(rays, mask, decide);
        }
        for number in numbers_in(mask) {
            self.indices().for_each(|triangle| decide.one(number, triangle));
        }
    }
}

/// Rays that ask a mesh.
struct Asking<'a> {
    mesh: &'a Mesh,
    rays: PreparedRun<'a>,
    by_shear_axis: [u64; 3],
    found: &'a mut TriangleHits,
}

impl<'a> Asking<'a> {
    fn new(mesh: &'a Mesh, rays: PreparedRun<'a>, mask: u64, found: &'a mut TriangleHits) -> Self {
        Self { mesh, rays, by_shear_axis: rays.by_shear_axis(mask), found }
    }

    /// Asks a triangle about those rays of a mask that are sheared along an axis, and returns them, but for those that
    /// must be asked by themselves.
    #[inline(always)]
    fn triangle(&mut self, mask: u64, axis: usize, triangle: u32) -> (u64, u64) {
        let here = mask & self.by_shear_axis[axis];
        if here == 0 {
            return (0, 0);
        }
        self.found.find(&ShearAxes::along(axis), &self.rays, here, self.mesh.corners(triangle));
        let mut alone = 0;
        for number in numbers_in(here) {
            alone |= u64::from(self.found.verdict[number] < 0.0) << number;
        }
        (here & !alone, alone)
    }
}

/// The nearest hits.
struct Closest<'a> {
    asking: Asking<'a>,
    hits: &'a mut SurfaceRun,
}

impl Decide for Closest<'_> {
    fn t_max(&self) -> &Numbers {
        &self.hits.t
    }

    fn one(&mut self, number: usize, triangle: u32) {
        let Self { asking: Asking { mesh, rays, .. }, hits } = self;
        if let Some(hit) = triangle_hit(&rays.get(number), mesh.corners(triangle)) {
            let comes_first = hits.triangle[number] != NO_TRIANGLE && triangle < hits.triangle[number];
            if hit.t < hits.t[number] || (hit.t == hits.t[number] && comes_first) {
                hits.set(number, ObjectHit { t: hit.t, triangle, barycentric: hit.barycentric });
            }
        }
    }

    #[inline(always)]
    fn many<L: Lanes>(&mut self, _: L, mask: u64, triangle: u32) {
        for axis in 0..3 {
            let (here, alone) = self.asking.triangle(mask, axis, triangle);
            let (found, hits) = (&*self.asking.found, &mut *self.hits);
            if here != 0 {
                for number in around(here) {
                    let (new, old) = (found.t[number], hits.t[number]);
                    let before = hits.triangle[number];
                    let comes_first = (before != NO_TRIANGLE) & (triangle < before);
                    let is_nearer = (new < old) | ((new == old) & comes_first);
                    let takes = (found.verdict[number] > 0.0) & is_nearer & (here >> number & 1 == 1);
                    hits.t[number] = if takes { new } else { old };
                    hits.triangle[number] = if takes { triangle } else { before };
                    for corner in 0..3 {
                        let weight = &mut hits.barycentric.0[corner][number];
                        *weight = if takes { found.barycentric[corner][number] } else { *weight };
                    }
                }
            }
            numbers_in(alone).for_each(|number| self.one(number, triangle));
        }
    }
}

/// Whether there is any hit.
struct Any<'a> {
    asking: Asking<'a>,
    /// Minus infinity where there is.
    t_max: Numbers,
    hit: u64,
}

impl Any<'_> {
    #[inline(always)]
    fn take(&mut self, number: usize, is_hit: bool) {
        if is_hit {
            self.t_max[number] = Real::NEG_INFINITY;
            self.hit |= 1 << number;
        }
    }
}

impl Decide for Any<'_> {
    fn t_max(&self) -> &Numbers {
        &self.t_max
    }

    fn one(&mut self, number: usize, triangle: u32) {
        let Asking { mesh, rays, .. } = &self.asking;
        let hit = triangle_hit(&rays.get(number), mesh.corners(triangle));
        self.take(number, hit.is_some_and(|hit| hit.t <= self.t_max[number]));
    }

    #[inline(always)]
    fn many<L: Lanes>(&mut self, _: L, mask: u64, triangle: u32) {
        for axis in 0..3 {
            let (here, alone) = self.asking.triangle(mask, axis, triangle);
            for number in numbers_in(here) {
                let TriangleHits { t, verdict, .. } = &*self.asking.found;
                self.take(number, verdict[number] > 0.0 && t[number] <= self.t_max[number]);
            }
            numbers_in(alone).for_each(|number| self.one(number, triangle));
        }
    }
}
