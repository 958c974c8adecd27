//! Warnings about the vertices of a whole mesh: they are rounded away, or span no area.

use super::outline::normal;
use crate::objects::Aabb;
use std::path::Path;
use vecmath::Real;

/// Steps of the coordinates, in diagonals of the mesh's box, from which rounding may show.
const COARSE: Real = 1.0 / 50_000.0;

/// Warns of a mesh that is small and far from the origin: between the numbers that a coordinate can be there lies a part of
/// it that can be seen. `bounds` are those of the vertices that faces use.
pub(super) fn rounded_away(path: &Path, bounds: &Aabb) -> Option<String> {
    let size = bounds.size();
    // Rounding moves a flat mesh across its plane and does not deform it.
    let is_extended = |axis: &usize| size[*axis] > 0.0;
    let farthest = |axis| bounds.min[axis].abs().max(bounds.max[axis].abs());
    let farthest = (0..3).filter(is_extended).map(farthest).fold(0.0, Real::max) as f32;
    let step = farthest - farthest.next_down();
    if farthest == 0.0 || Real::from(step) <= COARSE * size.length() {
        return None;
    }
    let [x, y, z] = bounds.center().to_array().map(|coordinate| coordinate as f32);
    let (path, across) = (path.display(), size.length() as f64);
    Some(format!(
        "{path}: coordinates are rounded to steps of {step:?}, for they go up to {farthest:?}, and this mesh is only \
         {across:.1e} across: subtract {x:?} {y:?} {z:?} from its vertices, and either from camera and lights, too, or move \
         the mesh back by Translate {x:?} {y:?} {z:?}"
    ))
}

/// Warns of a mesh with triangles of which none has an area.
pub(super) fn without_area(path: &Path, positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Option<String> {
    let corner = |corner: u32| positions[corner as usize].map(f64::from);
    let has_area = |triangle: &[u32; 3]| normal(&triangle.map(corner)) != [0.0; 3];
    // Nearly always the first one has.
    let is_nothing = !triangles.is_empty() && !triangles.iter().any(has_area);
    let path = path.display();
    is_nothing.then(|| format!("{path}: no picture shows this mesh, for none of its triangles has an area"))
}
