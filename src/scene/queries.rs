//! Queries of one ray against the [`Geometry`]: the closest hit, or whether there is any.
//!
//! The results are those of a loop over all objects and all triangles, to the last bit. Trees only skip what cannot
//! be hit. [`wide`](crate::wide) has the queries of packets, by the same tests.

use super::Geometry;
use super::tally::{Tally, TestCounts};
use crate::bvh::{Bvh, DONE, Entry, TriangleBlock};
use crate::objects::{Hit, PreparedRay, Ray, SurfaceHit, SurfacePoint, T_MAX, intersect_triangle};
use crate::simd::{InstructionSet, Simd, with_simd};
use std::cell::RefCell;
use vecmath::{Real, Vector3};

impl Geometry {
    /// Finds the nearest hit with 0 < t < [`T_MAX`]; of several at the same t, the first object's.
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        with_simd!(self.instruction_set, simd => self.closest_hit_with(simd, ray, &()))
    }

    /// Returns whether anything is hit at a t up to and including `t_max`.
    pub fn any_hit(&self, ray: &Ray, t_max: Real) -> bool {
        with_simd!(self.instruction_set, simd => self.any_hit_with(simd, ray, t_max, &()))
    }

    /// Counts what [`closest_hit`](Self::closest_hit) tests.
    pub fn count_closest_hit(&self, ray: &Ray, counts: &RefCell<TestCounts>) {
        self.closest_hit_with(InstructionSet::baseline_token(), ray, counts);
    }

    /// Counts what [`any_hit`](Self::any_hit) tests.
    pub fn count_any_hit(&self, ray: &Ray, t_max: Real, counts: &RefCell<TestCounts>) {
        self.any_hit_with(InstructionSet::baseline_token(), ray, t_max, counts);
    }

    /// Returns the normal at a hit; see [`Object::normal`](crate::objects::Object::normal).
    pub fn normal(&self, ray: &Ray, hit: &Hit) -> Vector3 {
        self.objects[hit.object as usize].normal(&self.meshes, ray, &hit.surface)
    }

    /// Finds the point of the surface that was hit, with its error bound.
    pub fn surface_point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.objects[hit.object as usize].surface_point(&self.meshes, ray, &hit.surface)
    }

    fn closest_hit_with<S: Simd>(&self, simd: S, ray: &Ray, tally: &impl Tally) -> Option<Hit> {
        let ray = PreparedRay::new(*ray);
        let mut closest: Option<Hit> = None;
        self.for_each_object(simd, &ray, T_MAX, tally, |index| {
            let t_max = closest.map_or(T_MAX, |closest| closest.surface.t);
            // Of two hits at the same t the first object's counts, whatever the order of the tests.
            let comes_first = closest.is_some_and(|closest| index < closest.object);
            let limit = if comes_first { t_max.next_up() } else { t_max };
            match self.closest_hit_of_object(simd, index, &ray, limit, tally) {
                None => t_max,
                Some(surface) => {
                    closest = Some(Hit { object: index, surface });
                    surface.t
                }
            }
        });
        closest
    }

    fn any_hit_with<S: Simd>(&self, simd: S, ray: &Ray, t_max: Real, tally: &impl Tally) -> bool {
        let ray = PreparedRay::new(*ray);
        let t_max = t_max.min(T_MAX.next_down());
        let mut found = false;
        self.for_each_object(simd, &ray, t_max, tally, |index| {
            found = found || self.any_hit_of_object(simd, index, &ray, t_max, tally);
            if found { Real::NEG_INFINITY } else { t_max }
        });
        found
    }

    /// Intersects a ray with one object: the nearest hit with t < `t_max`.
    pub fn closest_hit_of_object<S: Simd>(
        &self,
        simd: S,
        index: u32,
        ray: &PreparedRay,
        t_max: Real,
        tally: &impl Tally,
    ) -> Option<SurfaceHit> {
        let object = &self.objects[index as usize];
        let hit =
            object.closest_hit(ray, t_max, |mesh, ray| self.closest_hit_of_mesh(simd, mesh, ray, t_max, tally));
        tally.object(object, ray, t_max, hit.is_some());
        hit
    }

    /// Returns whether a ray hits one object at a t up to and including `t_max`.
    pub fn any_hit_of_object<S: Simd>(
        &self,
        simd: S,
        index: u32,
        ray: &PreparedRay,
        t_max: Real,
        tally: &impl Tally,
    ) -> bool {
        let object = &self.objects[index as usize];
        let is_hit = object.any_hit(ray, t_max, |mesh, ray| self.any_hit_of_mesh(simd, mesh, ray, t_max, tally));
        tally.object(object, ray, t_max, is_hit);
        is_hit
    }

    /// Returns the nearest hit with t < `t_max`; of several at the same t, the first triangle's.
    fn closest_hit_of_mesh<S: Simd>(
        &self,
        simd: S,
        mesh: u32,
        ray: &PreparedRay,
        mut t_max: Real,
        tally: &impl Tally,
    ) -> Option<SurfaceHit> {
        let (mesh, tree) = self.mesh_and_tree(mesh);
        let mut closest: Option<SurfaceHit> = None;
        for_each_triangle(simd, tree, mesh.triangle_count(), ray, t_max, tally, |triangle| {
            if let Some(hit) = intersect_triangle(ray, mesh.corners(triangle)) {
                let comes_first = closest.is_some_and(|closest| triangle < closest.triangle);
                if hit.t < t_max || (hit.t == t_max && comes_first) {
                    t_max = hit.t;
                    closest = Some(SurfaceHit { triangle, ..hit });
                }
            }
            t_max
        });
        closest
    }

    /// Returns any hit at a t up to and including `t_max`.
    fn any_hit_of_mesh<S: Simd>(
        &self,
        simd: S,
        mesh: u32,
        ray: &PreparedRay,
        t_max: Real,
        tally: &impl Tally,
    ) -> Option<SurfaceHit> {
        let (mesh, tree) = self.mesh_and_tree(mesh);
        let mut found = None;
        for_each_triangle(simd, tree, mesh.triangle_count(), ray, t_max, tally, |triangle| {
            found = found.or_else(|| intersect_triangle(ray, mesh.corners(triangle)).filter(|hit| hit.t <= t_max));
            if found.is_some() { Real::NEG_INFINITY } else { t_max }
        });
        found
    }

    /// Calls `test` with every object that the ray may hit at a t up to and including `t_max`, and perhaps others.
    /// `test` returns the new `t_max`; minus infinity ends the query.
    fn for_each_object<S: Simd>(
        &self,
        simd: S,
        ray: &PreparedRay,
        mut t_max: Real,
        tally: &impl Tally,
        mut test: impl FnMut(u32) -> Real,
    ) {
        for &index in &self.object_tree.always {
            t_max = test(index);
            if t_max == Real::NEG_INFINITY {
                return;
            }
        }
        let Some(bvh) = &self.object_tree.bvh else { return };
        match bvh.space.enter(ray, t_max) {
            Entry::Missed => {}
            Entry::Unbounded => {
                let _ = bvh.leaves.iter().any(|&index| test(index) == Real::NEG_INFINITY);
            }
            Entry::Entered(culling_ray) => {
                bvh.traverse(
                    simd,
                    &culling_ray,
                    culling_ray.limit(t_max),
                    |node| tally.node(node),
                    #[inline(always)]
                    |index, _| culling_ray.limit(test(*index)),
                );
            }
        }
    }
}

/// Calls `test` with every triangle that the ray may hit at a t up to and including `t_max`, and perhaps others, some of
/// them more than once. `test` returns the new `t_max`; minus infinity ends the query.
fn for_each_triangle<S: Simd>(
    simd: S,
    tree: Option<&Bvh<TriangleBlock>>,
    count: usize,
    ray: &PreparedRay,
    t_max: Real,
    tally: &impl Tally,
    mut test: impl FnMut(u32) -> Real,
) {
    let mut test = |triangle| {
        tally.exact_triangle();
        test(triangle)
    };
    match tree.map(|tree| (tree, tree.space.enter(ray, t_max))) {
        Some((_, Entry::Missed)) => {}
        None | Some((_, Entry::Unbounded)) => {
            tally.triangles(count as u32);
            let _ = (0..count as u32).any(|triangle| test(triangle) == Real::NEG_INFINITY);
        }
        Some((tree, Entry::Entered(culling_ray))) => {
            let center = tree.space.scaled_center();
            tree.traverse(
                simd,
                &culling_ray,
                culling_ray.limit(t_max),
                |node| tally.node(node),
                #[inline(always)]
                |block, mut limit| {
                    tally.triangles(block.count());
                    let mut candidates = block.candidates(simd, center, culling_ray.splat(simd), limit);
                    while candidates != 0 && limit > DONE {
                        limit = culling_ray.limit(test(block.index(candidates.trailing_zeros())));
                        candidates &= candidates - 1;
                    }
                    limit
                },
            );
        }
    }
}
