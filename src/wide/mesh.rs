//! What many rays hit of a mesh: the definitions of [`Mesh`], asked for the rays of a run at once.

use super::SurfaceRun;
use super::ray::ShearAxes;
use super::run::{Numbers, PreparedRun, around, numbers_in};
use super::triangle::TriangleHits;
use super::{Mesh, ObjectHit, triangle_hit};
use crate::accel::Decide;
use crate::accel::simd::Lanes;
use vecmath::{Real, Vector3};

impl Mesh {
    /// [`closest_hit`](Self::closest_hit) of the rays of a mask. `hits` says how far each ray looks (t below its t), and
    /// takes what it finds; the output are those that have found anything. There is room for what is found on the way in
    /// `found`.
    pub fn closest_hits(
        &self,
        rays: PreparedRun,
        mask: u64,
        found: &mut TriangleHits,
        hits: &mut SurfaceRun,
    ) -> u64 {
        let mut closest = Closest { asking: Asking::new(self, rays, mask, found), hits, hit: 0 };
        self.ask(rays, mask, &mut closest);
        closest.hit
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
            self.indices().for_each(|triangle| decide.one(number, triangle, None));
        }
    }
}

/// Rays that ask a mesh.
struct Asking<'a> {
    mesh: &'a Mesh,
    rays: PreparedRun<'a>,
    mask: u64,
    /// Of the mask, once they are asked for.
    by_shear_axis: Option<[u64; 3]>,
    found: &'a mut TriangleHits,
}

impl<'a> Asking<'a> {
    fn new(mesh: &'a Mesh, rays: PreparedRun<'a>, mask: u64, found: &'a mut TriangleHits) -> Self {
        Self { mesh, rays, mask, by_shear_axis: None, found }
    }

    /// Asks a triangle about those rays of a mask that are sheared along an axis, and returns them, but for those that
    /// must be asked by themselves.
    #[inline(always)]
    fn triangle(&mut self, mask: u64, axis: usize, corners: [Vector3; 3]) -> (u64, u64) {
        let Self { rays, mask: all, .. } = *self;
        let here = mask & self.by_shear_axis.get_or_insert_with(|| rays.by_shear_axis(all))[axis];
        if here == 0 {
            return (0, 0);
        }
        self.found.find(&ShearAxes::along(axis), &self.rays, here, corners);
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
    /// Rays that have hit something.
    hit: u64,
}

impl Decide for Closest<'_> {
    fn t_max(&self) -> &Numbers {
        &self.hits.t
    }

    fn one(&mut self, number: usize, triangle: u32, corners: Option<[Vector3; 3]>) {
        let Self { asking: Asking { mesh, rays, .. }, hits, hit: any } = self;
        let corners = corners.unwrap_or_else(|| mesh.corners(triangle));
        if let Some(hit) = triangle_hit(&rays.get(number), corners) {
            let comes_first = *any >> number & 1 == 1 && triangle < hits.triangle[number];
            if hit.t < hits.t[number] || (hit.t == hits.t[number] && comes_first) {
                *any |= 1 << number;
                hits.set(number, ObjectHit { t: hit.t, triangle, barycentric: hit.barycentric });
            }
        }
    }

    #[inline(always)]
    fn many<L: Lanes>(&mut self, _: L, mask: u64, triangle: u32, corners: Option<[Vector3; 3]>) {
        let corners = corners.unwrap_or_else(|| self.asking.mesh.corners(triangle));
        for axis in 0..3 {
            let (here, alone) = self.asking.triangle(mask, axis, corners);
            let (found, hits) = (&*self.asking.found, &mut *self.hits);
            if here != 0 {
                let before_all = self.hit;
                let mut taken = 0;
                for number in around(here) {
                    let (new, old) = (found.t[number], hits.t[number]);
                    let before = hits.triangle[number];
                    let comes_first = (before_all >> number & 1 == 1) & (triangle < before);
                    let is_nearer = (new < old) | ((new == old) & comes_first);
                    let takes = (found.verdict[number] > 0.0) & is_nearer & (here >> number & 1 == 1);
                    taken |= u64::from(takes) << number;
                    hits.t[number] = if takes { new } else { old };
                    hits.triangle[number] = if takes { triangle } else { before };
                    for corner in 0..3 {
                        let weight = &mut hits.barycentric.0[corner][number];
                        *weight = if takes { found.barycentric[corner][number] } else { *weight };
                    }
                }
                self.hit |= taken;
            }
            numbers_in(alone).for_each(|number| self.one(number, triangle, Some(corners)));
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

    fn one(&mut self, number: usize, triangle: u32, corners: Option<[Vector3; 3]>) {
        let Asking { mesh, rays, .. } = &self.asking;
        let corners = corners.unwrap_or_else(|| mesh.corners(triangle));
        let hit = triangle_hit(&rays.get(number), corners);
        self.take(number, hit.is_some_and(|hit| hit.t <= self.t_max[number]));
    }

    #[inline(always)]
    fn many<L: Lanes>(&mut self, _: L, mask: u64, triangle: u32, corners: Option<[Vector3; 3]>) {
        let corners = corners.unwrap_or_else(|| self.asking.mesh.corners(triangle));
        for axis in 0..3 {
            let (here, alone) = self.asking.triangle(mask, axis, corners);
            for number in numbers_in(here) {
                let TriangleHits { t, verdict, .. } = &*self.asking.found;
                self.take(number, verdict[number] > 0.0 && t[number] <= self.t_max[number]);
            }
            numbers_in(alone).for_each(|number| self.one(number, triangle, Some(corners)));
        }
    }
}
