//! What a query must find, by loops over all triangles, for [`queries`](super::queries).

use a2::objects::{Mesh, Object, PreparedRay, Ray, SurfaceHit, T_MAX, intersect_triangle};
use a2::scene::Geometry;
use vecmath::Real;

/// All numbers of a hit as bits, so that NaN equals NaN.
pub type Bits = (u32, u64, [u64; 3]);

pub fn bits(hit: &Option<SurfaceHit>) -> Option<Bits> {
    hit.map(|hit| (hit.triangle, hit.t.to_bits(), hit.barycentric.map(Real::to_bits)))
}

/// Finds the closest hit by the definition: the nearest hit of all triangles, and the first one of equals.
fn closest_by_loop(mesh: &Mesh, ray: &PreparedRay, t_max: Real) -> Option<SurfaceHit> {
    let mut closest: Option<SurfaceHit> = None;
    for triangle in 0..mesh.triangle_count() as u32 {
        let Some(hit) = intersect_triangle(ray, mesh.corners(triangle)) else { continue };
        if hit.t < closest.map_or(t_max, |closest| closest.t) {
            closest = Some(SurfaceHit { triangle, ..hit });
        }
    }
    closest
}

/// Returns how many rays hit anything.
pub fn count_hits(geometry: &Geometry, rays: &[Ray]) -> usize {
    rays.iter().filter(|ray| any_by_loop(&geometry.meshes[0], &PreparedRay::new(**ray), T_MAX)).count()
}

pub fn any_by_loop(mesh: &Mesh, ray: &PreparedRay, t_max: Real) -> bool {
    let mut triangles = 0..mesh.triangle_count() as u32;
    triangles.any(|triangle| intersect_triangle(ray, mesh.corners(triangle)).is_some_and(|hit| hit.t <= t_max))
}

/// Finds an object's closest hit, with a loop over the triangles of its mesh.
pub fn closest_of_object(object: &Object, meshes: &[Mesh], ray: &PreparedRay, t_max: Real) -> Option<SurfaceHit> {
    object.closest_hit(ray, t_max, |mesh, ray| closest_by_loop(&meshes[mesh as usize], ray, t_max))
}

pub fn any_of_object(object: &Object, meshes: &[Mesh], ray: &PreparedRay, t_max: Real) -> bool {
    let t_max = t_max.min(T_MAX.next_down());
    object.any_hit(ray, t_max, |mesh, ray| {
        any_by_loop(&meshes[mesh as usize], ray, t_max).then_some(SurfaceHit::at(t_max))
    })
}
