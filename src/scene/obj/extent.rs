//! Warnings about a mesh as a whole: its vertices are rounded too much, or span no area.

use super::outline::normal;
use crate::objects::Mesh;
use std::path::Path;
use vecmath::{Real, Vector3};

/// Steps of the coordinates, in lengths of a triangle's longest edge, from which rounding may show.
const COARSE: Real = 1.0 / 256.0;
/// So many triangles are looked at, evenly spaced. A fourth of them must be too small for a warning: meshes of machine parts have
/// some tiny ones at their rounded edges.
const MOST_TRIANGLES: usize = 4096;
/// A mesh whose coordinates go up to so many times its size is far from the origin as a whole.
const FAR: Real = 4.0;

/// Warns of triangles that are small and far from the origin: between the numbers that a coordinate can be there lies a part of
/// them that can be seen.
pub(super) fn rounded_away(path: &Path, mesh: &Mesh) -> Option<String> {
    let bounds = mesh.bounds();
    let size = bounds.size();
    // Rounding moves a flat mesh across its plane and does not deform it.
    let is_extended = size.to_array().map(|size| size > 0.0);
    let count = mesh.triangle_count();
    let looked_at = (0..count).step_by(count.div_ceil(MOST_TRIANGLES).max(1));
    let mut total = 0;
    let extents = looked_at.filter_map(|triangle| Extent::of(mesh.corners(triangle as u32), is_extended));
    let extents = extents.inspect(|_| total += 1);
    let rounded: Vec<Extent> = extents.filter(|extent| extent.step > COARSE * extent.longest).collect();
    if 4 * rounded.len() <= total {
        return None;
    }
    let Extent { step, farthest, longest } = rounded.into_iter().max_by(|a, b| a.step.total_cmp(&b.step))?;
    let path = path.display();
    let cure = if farthest > FAR * size.max_abs() {
        let [x, y, z] = bounds.center().to_array().map(|coordinate| coordinate as f32);
        format!(
            "subtract {x:?} {y:?} {z:?} from its vertices, and either from camera and lights, too, or move the mesh back by \
             Translate {x:?} {y:?} {z:?}"
        )
    } else {
        "give parts that are far apart files of their own, near the origin, and move them by Translate".to_owned()
    };
    Some(format!(
        "{path}: coordinates that go up to {:?} are rounded to steps of {:?}, and triangles there are only {:.1e} long: {cure}",
        farthest as f32, step as f32, longest as f64
    ))
}

/// How large a triangle is, and how far from the origin.
struct Extent {
    longest: Real,
    farthest: Real,
    /// Between the largest coordinate and the one below.
    step: Real,
}

impl Extent {
    /// `None` for a triangle that is a point.
    fn of(corners: [Vector3; 3], is_extended: [bool; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let longest = [b - a, c - b, a - c].map(Vector3::length).into_iter().fold(0.0, Real::max);
        let extended =
            |corner: Vector3| (0..3).filter(|&axis| is_extended[axis]).map(move |axis| corner[axis].abs());
        let farthest = corners.into_iter().flat_map(extended).fold(0.0, Real::max);
        let step = Real::from(farthest as f32 - (farthest as f32).next_down());
        (longest > 0.0).then_some(Self { longest, farthest, step })
    }
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
