//! The normals where many rays have hit one object: the definition of [`Object::normal`], asked for the rays of a run
//! at once.

use super::SurfaceRun;
use super::run::{RayRun, Vectors, around, numbers_in};
use super::{Mesh, Object, Placement, Shape, Sphere};
use crate::accel::simd::{Lanes, Level, Task};
use vecmath::Vector3;

/// So few rays are asked about one by one.
const FEW: u32 = 3;

impl Object {
    /// [`normal`](Self::normal) where the rays of a mask have hit this object.
    pub fn normals(
        &self,
        meshes: &[Mesh],
        level: Level,
        rays: &RayRun,
        mask: u64,
        hits: &SurfaceRun,
        normals: &mut Vectors,
    ) {
        if mask.count_ones() <= FEW {
            for number in numbers_in(mask) {
                normals.set(number, self.normal(meshes, &rays.get(number), &hits.get(number)));
            }
            return;
        }
        let placement = self.placement.as_deref();
        match &self.shape {
            Shape::Plane(_) | Shape::Triangle(_) => {
                let number = mask.trailing_zeros() as usize;
                let normal = self.normal(meshes, &rays.get(number), &hits.get(number));
                numbers_in(mask).for_each(|number| normals.set(number, normal));
            }
            Shape::Sphere(sphere) => level.run(SphereNormals { sphere, placement, rays, hits, mask, normals }),
            Shape::Mesh(mesh) => {
                let mut left_out = 0;
                let mesh = &meshes[*mesh as usize];
                let corners = [Vectors::ZERO; 3];
                level.run(MeshNormals { mesh, placement, hits, mask, corners, normals, left_out: &mut left_out });
                for number in numbers_in(left_out) {
                    normals.set(number, self.normal(meshes, &rays.get(number), &hits.get(number)));
                }
            }
        }
    }
}

/// Copies the vectors of a mask.
#[inline(always)]
fn copy(from: &Vectors, mask: u64, to: &mut Vectors) {
    for number in around(mask) {
        let vector = if mask >> number & 1 == 1 { from.get(number) } else { to.get(number) };
        to.set(number, vector);
    }
}

/// Takes the normals of a mask to world space.
#[inline(always)]
fn to_world(normals: &mut Vectors, mask: u64, placement: Option<&Placement>) {
    if let Some(placement) = placement {
        for number in around(mask) {
            normals.set(number, placement.across_world(normals.get(number)));
        }
        normals.normalize(mask);
    }
}

struct SphereNormals<'a> {
    sphere: &'a Sphere,
    placement: Option<&'a Placement>,
    rays: &'a RayRun,
    hits: &'a SurfaceRun,
    mask: u64,
    normals: &'a mut Vectors,
}

impl Task for SphereNormals<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { sphere, placement, rays, hits, mask, normals } = self;
        let mut found = Vectors::ZERO;
        match placement {
            None => {
                for number in around(mask) {
                    found.set(number, rays.get(number).at(hits.t[number]) - sphere.center);
                }
            }
            Some(placement) => {
                for number in around(mask) {
                    let ray = placement.ray_to_object(&rays.get(number));
                    found.set(number, ray.at(hits.t[number]) - sphere.center);
                }
            }
        }
        found.normalize(mask);
        to_world(&mut found, mask, placement);
        copy(&found, mask, normals);
    }
}

struct MeshNormals<'a> {
    mesh: &'a Mesh,
    placement: Option<&'a Placement>,
    hits: &'a SurfaceRun,
    mask: u64,
    /// Normals of the corners of the triangles that are hit.
    corners: [Vectors; 3],
    normals: &'a mut Vectors,
    /// Rays whose normals are not simply those of the corners, weighted.
    left_out: &'a mut u64,
}

impl Task for MeshNormals<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { mesh, placement, hits, mask, mut corners, normals, left_out } = self;
        for number in numbers_in(mask) {
            let mut is_usual = true;
            for (corner, normal) in mesh.corner_normals(hits.triangle[number]).into_iter().enumerate() {
                corners[corner].set(number, normal);
                is_usual &= normal != Vector3::ZERO;
            }
            *left_out |= u64::from(!is_usual) << number;
        }
        let mut found = Vectors::ZERO;
        let mut all_usual = true;
        for number in around(mask) {
            let weights = hits.barycentric.get(number);
            let sum = Vector3::ZERO + corners[0].get(number) * weights.x;
            let sum = sum + corners[1].get(number) * weights.y + corners[2].get(number) * weights.z;
            let largest = sum.max_abs();
            let is_usual = (largest > 0.0) & sum.is_finite();
            all_usual &= is_usual | (mask >> number & 1 == 0);
            let scaled = sum / if is_usual { largest } else { 1.0 };
            let length = scaled.length();
            found.set(number, scaled / if is_usual { length } else { 1.0 });
        }
        to_world(&mut found, mask, placement);
        copy(&found, mask, normals);
        if !all_usual {
            *left_out = mask;
        }
    }
}
