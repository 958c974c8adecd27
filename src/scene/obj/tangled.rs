//! Whether cutting a polygon would take long: `earcut` has no limit of its own.
//!
//! It needs time that grows with the square of the number of corners where it finds ears, and with the third power where
//! the outline runs over itself again and again. Four corners, named in turn 10,000 times, took it a minute. What
//! passes here took 0.4 s at most in 150 hard outlines: stars, spirals, combs, holes on bridges, tours of grids. It took
//! 1.8 s where one of 10,000 corners stood 100,000 times as far away as all others were from each other.

use super::outline::{cross, rounding, size_of};

/// Why a polygon is not cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Doubt {
    FarFromFlat,
    TooManyCorners,
    CrossesItself,
}

impl Doubt {
    /// Returns what the polygon does or is.
    pub fn words(self) -> &'static str {
        match self {
            Self::FarFromFlat => "is far from flat",
            Self::TooManyCorners => "has more than 10,000 corners",
            Self::CrossesItself => "crosses or touches itself",
        }
    }
}

/// A polygon of more corners is not cut, if it is not convex.
const MOST_CORNERS: usize = 10_000;
/// A polygon of so few corners is cut in 3 ms, whatever it is.
const FEW_CORNERS: usize = 256;
/// So many pairs of edges may cross, or lie on each other. `earcut` mends small crossings.
const MOST_CROSSINGS: usize = 64;

/// Returns why a polygon that is not convex might take long to cut.
pub(super) fn doubt(flat: &[[f64; 2]]) -> Option<Doubt> {
    match flat.len() {
        count if count > MOST_CORNERS => Some(Doubt::TooManyCorners),
        count if count > FEW_CORNERS && crosses_often(flat) => Some(Doubt::CrossesItself),
        _ => None,
    }
}

/// An edge with its bounds.
struct Edge {
    ends: [[f64; 2]; 2],
    low: [f64; 2],
    high: [f64; 2],
}

impl Edge {
    fn new(a: [f64; 2], b: [f64; 2]) -> Self {
        Self { ends: [a, b], low: [a[0].min(b[0]), a[1].min(b[1])], high: [a[0].max(b[0]), a[1].max(b[1])] }
    }

    fn along(&self) -> [f64; 2] {
        let [a, b] = self.ends;
        [b[0] - a[0], b[1] - a[1]]
    }

    /// The side of a point: 1 is left, -1 right, 0 on the line up to rounding.
    fn side(&self, point: [f64; 2], size: f64) -> f64 {
        let [a, b] = self.ends;
        let turn = cross(a, b, point);
        if turn.abs() <= rounding([a, b, point], size) { 0.0 } else { turn.signum() }
    }

    /// Whether two edges cross, or lie on each other with the same direction. A bridge to a hole goes there and back.
    fn collides(&self, other: &Self, size: f64) -> bool {
        let sides = [
            self.side(other.ends[0], size),
            self.side(other.ends[1], size),
            other.side(self.ends[0], size),
            other.side(self.ends[1], size),
        ];
        if sides == [0.0; 4] {
            let (a, b) = (self.along(), other.along());
            let axis = usize::from(a[1].abs() > a[0].abs());
            let is_shared = self.high[axis].min(other.high[axis]) > self.low[axis].max(other.low[axis]);
            return is_shared && a[0] * b[0] + a[1] * b[1] > 0.0;
        }
        sides[0] * sides[1] < 0.0 && sides[2] * sides[3] < 0.0
    }
}

/// Whether more than [`MOST_CROSSINGS`] pairs of edges collide.
fn crosses_often(flat: &[[f64; 2]]) -> bool {
    let size = size_of(flat);
    let next = flat.iter().cycle().skip(1);
    let mut edges: Vec<Edge> = flat.iter().zip(next).map(|(&a, &b)| Edge::new(a, b)).collect();
    edges.sort_unstable_by(|a, b| a.low[0].total_cmp(&b.low[0]));
    let mut crossings = 0;
    for (number, edge) in edges.iter().enumerate() {
        let near = edges[number + 1..].iter().take_while(|other| other.low[0] <= edge.high[0]);
        let near = near.filter(|other| other.low[1] <= edge.high[1] && other.high[1] >= edge.low[1]);
        crossings += near.filter(|other| edge.collides(other, size)).count();
        if crossings > MOST_CROSSINGS {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(count: usize, radius: impl Fn(usize) -> f64) -> impl Fn(usize) -> [f64; 2] {
        move |i| {
            let angle = std::f64::consts::TAU * (i % count) as f64 / count as f64;
            [radius(i) * angle.cos(), radius(i) * angle.sin()]
        }
    }

    fn must_be(expected: Option<Doubt>, what: &str, outline: &[[f64; 2]]) {
        let backwards: Vec<_> = outline.iter().rev().copied().collect();
        for outline in [outline, &backwards] {
            assert_eq!(doubt(outline), expected, "{what}, {} corners", outline.len());
        }
    }

    #[test]
    fn outlines_that_run_over_themselves_are_tangled() {
        for count in [FEW_CORNERS + 1, 1000, 3000, 9999] {
            let outline = |corner: &dyn Fn(usize) -> [f64; 2]| (0..count).map(corner).collect::<Vec<_>>();
            for different in [3, 4, 7, 100] {
                must_be(Some(Doubt::CrossesItself), "around", &outline(&circle(different, |_| 1.0)));
                let star = circle(different, |i| if i % 2 == 0 { 1.0 } else { 0.3 });
                must_be(Some(Doubt::CrossesItself), "a star, around", &outline(&star));
                let nearly = circle(different, |i| 1.0 + 1e-3 * (i as f64).sin());
                must_be(Some(Doubt::CrossesItself), "nearly around", &outline(&nearly));
            }
            must_be(Some(Doubt::CrossesItself), "across", &outline(&|i| circle(count, |_| 1.0)(7919 * i)));
        }
    }

    #[test]
    fn simple_outlines_are_not_tangled() {
        for count in [FEW_CORNERS + 2, 1000, 3000, 5000, MOST_CORNERS] {
            let spikes = circle(count, |i| if i % 2 == 0 { 1.0 } else { 0.3 });
            must_be(None, "spikes", &(0..count).map(spikes).collect::<Vec<_>>());
            let comb = |i| match i {
                0 => [0.0, 0.0],
                1 => [count as f64, 0.0],
                _ => [(count - i) as f64, if i % 2 == 0 { 3.0 } else { 1.0 }],
            };
            must_be(None, "comb", &(0..count).map(comb).collect::<Vec<_>>());
        }
        must_be(None, "four corners, around, few", &(0..FEW_CORNERS).map(circle(4, |_| 1.0)).collect::<Vec<_>>());
        let spikes = circle(MOST_CORNERS + 2, |i| if i % 2 == 0 { 1.0 } else { 0.3 });
        must_be(Some(Doubt::TooManyCorners), "too many", &(0..MOST_CORNERS + 2).map(spikes).collect::<Vec<_>>());
    }
}
