//! The geometry of a polygon's outline: areas, turns, how far they may be off, and corners that enclose nothing.

/// A corner's coordinates are off by half a unit in the last place of an `f32`: 2^-24 of themselves.
const ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// Triangles whose areas add up to more than the polygon's by this part of it overlap.
pub(super) const OVERLAP: f64 = 1e-5;

/// The vector across a polygon by Newell's method: its length is twice the area.
pub(super) fn normal(points: &[[f64; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for edge in points.windows(2) {
        let [a, b] = [edge[0], edge[1]].map(|point| [0, 1, 2].map(|axis| point[axis] - points[0][axis]));
        for (axis, sum) in sum.iter_mut().enumerate() {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            *sum += a[u] * b[v] - a[v] * b[u];
        }
    }
    sum
}

/// Twice the area of a triangle, above zero if it turns left.
pub(super) fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The largest coordinate of a polygon, without its sign.
pub(super) fn size_of(flat: &[[f64; 2]]) -> f64 {
    flat.as_flattened().iter().fold(0.0f64, |size, coordinate| size.max(coordinate.abs()))
}

/// How far [`cross`] may be off because the coordinates, up to `size`, are rounded.
pub(super) fn rounding([a, b, c]: [[f64; 2]; 3], size: f64) -> f64 {
    let edges = [b[0] - a[0], b[1] - a[1], c[0] - b[0], c[1] - b[1]];
    4.0 * ROUNDING * size * edges.iter().map(|edge| edge.abs()).sum::<f64>()
}

/// Whether a polygon turns left at every corner, up to rounding, and goes around once.
pub(super) fn is_convex(flat: &[[f64; 2]]) -> bool {
    let size = size_of(flat);
    let count = flat.len();
    let mut turns_of_direction = 0;
    let mut rightwards = None;
    for at in 0..=count {
        let [a, b, c] = [at, at + 1, at + 2].map(|corner| flat[corner % count]);
        if cross(a, b, c) < -rounding([a, b, c], size) {
            return false;
        }
        let step = b[0] - a[0];
        if step != 0.0 {
            turns_of_direction += usize::from(rightwards.is_some_and(|before| before != (step > 0.0)));
            rightwards = Some(step > 0.0);
        }
    }
    // Small turns to the right, each like rounding, may add up to a notch.
    turns_of_direction <= 2 && is_covered_by_fan(flat)
}

/// Whether the fan around the first corner covers no point twice, up to rounding, as long as the outline goes around once.
fn is_covered_by_fan(flat: &[[f64; 2]]) -> bool {
    let (mut area, mut backwards, mut around) = (0.0, 0.0, 0.0);
    for edge in flat.windows(2) {
        let turned = cross(flat[0], edge[0], edge[1]);
        area += turned;
        backwards -= turned.min(0.0);
        around += (edge[1][0] - edge[0][0]).abs() + (edge[1][1] - edge[0][1]).abs();
    }
    backwards <= OVERLAP * area + 4.0 * ROUNDING * size_of(flat) * around
}

/// Returns the corners of an outline without those that enclose nothing, and the flat triangles that these make: one of two
/// corners at one place, and the tip where an edge goes there and back.
pub(super) fn trimmed(flat: &[[f64; 2]]) -> (Vec<u32>, Vec<[u32; 3]>) {
    let is_same = |a: u32, b: u32| flat[a as usize] == flat[b as usize];
    let (mut kept, mut removed) = (Vec::<u32>::with_capacity(flat.len()), Vec::new());
    for corner in 0..flat.len() as u32 {
        kept.push(corner);
        while let [.., a, b, c] = kept[..]
            && (is_same(b, c) || is_same(a, c))
        {
            removed.push([a, b, c]);
            kept.remove(kept.len() - 2);
        }
    }
    // Across the end of the list.
    let mut ring = &kept[..];
    while let [first, second, .., before, last] = *ring {
        if is_same(last, first) || is_same(before, first) {
            removed.push([before, last, first]);
            ring = &ring[..ring.len() - 1];
        } else if is_same(first, second) || is_same(last, second) {
            removed.push([last, first, second]);
            ring = &ring[1..];
        } else {
            break;
        }
    }
    (ring.to_vec(), removed)
}
