//! The normals where a packet has hit one object: [`Object::normal`] for many lanes at once.

use super::hit_packet::HitPacket;
use crate::objects::{Mesh, Object, Shape, Surface, Transform, match_surface};
use crate::simd::packet::{PACKET, RayPacket, Vectors, has_lane, lanes_equal, lanes_in, span};
use crate::simd::{Simd, vectorize};
use vecmath::Vector3;

/// So few lanes are computed one by one.
const FEW: u32 = 3;

/// Scratch of computing normals.
pub struct NormalScratch {
    found: Vectors,
    /// Normals of the corners of the triangles that are hit. Made for the first mesh.
    corners: Option<Box<[Vectors; 3]>>,
}

impl NormalScratch {
    pub const EMPTY: Self = Self { found: Vectors::ZERO, corners: None };
}

/// Computes the normals of the active lanes, which have hit this object. Those of other lanes may be lost, unless they
/// are to be `kept`.
#[expect(clippy::too_many_arguments)]
pub fn normals<S: Simd>(
    simd: S,
    object: &Object,
    meshes: &[Mesh],
    rays: &RayPacket,
    active: u64,
    hits: &HitPacket,
    kept: bool,
    NormalScratch { found, corners }: &mut NormalScratch,
    normals: &mut Vectors,
) {
    let single = |lane: usize| object.normal(meshes, &rays.get(lane), &hits.surface(lane));
    if active.count_ones() <= FEW {
        return lanes_in(active).for_each(|lane| normals.set(lane, single(lane)));
    }
    let transform = object.transform.as_deref();
    let to = if kept { &mut *found } else { &mut *normals };
    match_surface!(&object.shape,
        surface => normals_of_surface(simd, surface, transform, rays, active, hits, to),
        Shape::Triangle(_) => {
            let normal = single(active.trailing_zeros() as usize);
            return lanes_in(active).for_each(|lane| normals.set(lane, normal));
        }
        Shape::Mesh(mesh) => {
            let unusual = normals_of_mesh(simd, &meshes[*mesh as usize], transform, active, hits, corners, to);
            lanes_in(unusual).for_each(|lane| to.set(lane, single(lane)));
        }
    );
    if kept {
        copy(simd, found, active, normals);
    }
}

/// Copies the vectors of the active lanes.
fn copy<S: Simd>(simd: S, from: &Vectors, active: u64, to: &mut Vectors) {
    vectorize!(simd, {
        for lane in span(active) {
            let vector = if has_lane(active, lane) { from.get(lane) } else { to.get(lane) };
            to.set(lane, vector);
        }
    });
}

/// Takes the normals of the active lanes to world space.
#[inline(always)]
fn to_world(normals: &mut Vectors, active: u64, transform: Option<&Transform>) {
    if let Some(transform) = transform {
        for lane in span(active) {
            normals.set(lane, transform.normal_direction_to_world(normals.get(lane)));
        }
        normals.normalize(active);
    }
}

fn normals_of_surface<S: Simd, F: Surface>(
    simd: S,
    surface: &F,
    transform: Option<&Transform>,
    rays: &RayPacket,
    active: u64,
    hits: &HitPacket,
    found: &mut Vectors,
) {
    vectorize!(simd, {
        match transform {
            None => {
                for lane in span(active) {
                    found.set(lane, surface.gradient(rays.get(lane).at(hits.t[lane])));
                }
            }
            Some(transform) => {
                for lane in span(active) {
                    let ray = transform.ray_to_object(&rays.get(lane));
                    found.set(lane, surface.gradient(ray.at(hits.t[lane])));
                }
            }
        }
        if F::NORMALIZES {
            found.normalize(active);
        }
        to_world(found, active, transform);
    });
}

/// Interpolates the corners' normals. Returns the lanes for which [`Mesh::normal`] must do it.
fn normals_of_mesh<S: Simd>(
    simd: S,
    mesh: &Mesh,
    transform: Option<&Transform>,
    active: u64,
    hits: &HitPacket,
    corners: &mut Option<Box<[Vectors; 3]>>,
    found: &mut Vectors,
) -> u64 {
    let first = hits.triangle[active.trailing_zeros() as usize % PACKET];
    if active & !lanes_equal(simd, &hits.triangle, first) == 0 {
        // The usual case, with many rays a pixel.
        let normals = mesh.corner_normals(first);
        let is_usual = !normals.contains(&Vector3::ZERO)
            && vectorize!(simd, {
                let all_usual = interpolate(
                    #[inline(always)]
                    |_| normals,
                    active,
                    hits,
                    found,
                );
                to_world(found, active, transform);
                all_usual
            });
        return if is_usual { 0 } else { active };
    }
    let corners = corners.get_or_insert_with(|| Box::new([Vectors::ZERO; 3]));
    vectorize!(simd, {
        let mut unusual = 0;
        for lane in lanes_in(active) {
            let mut is_usual = true;
            for (corner, normal) in mesh.corner_normals(hits.triangle[lane]).into_iter().enumerate() {
                corners[corner].set(lane, normal);
                is_usual &= normal != Vector3::ZERO;
            }
            unusual |= u64::from(!is_usual) << lane;
        }
        let all_usual = interpolate(
            #[inline(always)]
            |lane| [corners[0].get(lane), corners[1].get(lane), corners[2].get(lane)],
            active,
            hits,
            found,
        );
        to_world(found, active, transform);
        if all_usual { unusual } else { active }
    })
}

/// Interpolates the corners' normals where the sum has a direction. Returns whether it has in all active lanes.
#[inline(always)]
fn interpolate(
    normals: impl Fn(usize) -> [Vector3; 3],
    active: u64,
    hits: &HitPacket,
    found: &mut Vectors,
) -> bool {
    let mut all_usual = true;
    for lane in span(active) {
        let ([a, b, c], weights) = (normals(lane), hits.barycentric.get(lane));
        let sum = Vector3::ZERO + a * weights.x;
        let sum = sum + b * weights.y + c * weights.z;
        let largest = sum.max_abs();
        let is_usual = (largest > 0.0) & sum.is_finite();
        all_usual &= is_usual | !has_lane(active, lane);
        let scaled = sum / if is_usual { largest } else { 1.0 };
        let length = scaled.length();
        found.set(lane, scaled / if is_usual { length } else { 1.0 });
    }
    all_usual
}
