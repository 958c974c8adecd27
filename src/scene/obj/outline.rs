//! The geometry of a polygon's outline: areas, turns, and how far they may be off.

/// A corner's coordinates are off by half a unit in the last place of an `f32`: 2^-24 of themselves.
const ROUNDING: f64 = 1.0 / (1 << 24) as f64;

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
