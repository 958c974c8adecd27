//! Faces of more than three corners into triangles that stay inside their outline.
//!
//! Convex polygons stay the fans around their first corner that the readers make of them. Others are cut by the crate
//! `earcut`, which may leave corners out that stand on a straight line between their neighbours; they are put back, for a
//! neighbouring face may use them. So every polygon of n corners becomes n - 2 triangles.
//!
//! A polygon is looked at in its projection along the axis that is nearest to its normal. That keeps two coordinates
//! exactly as the file has them.

use super::Polygon;
use super::outline::{OVERLAP, cross, is_convex, normal, trimmed};
use super::tangled::{Doubt, doubt};
use earcut::Earcut;
use rayon::prelude::*;

/// How often polygons were not simply fans.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Cuts {
    /// Polygons that were cut inside their outline.
    pub concave: usize,
    /// Polygons that cross themselves or are crooked, and stay fans.
    pub doubtful: usize,
    /// The number of the first one's face, and what is the matter with it.
    pub first_doubtful: Option<(usize, Doubt)>,
}

/// How a polygon is cut.
#[derive(Debug, PartialEq)]
enum Cut {
    Fan,
    /// Triangles of corners by their number in the polygon.
    Inside(Vec<[u32; 3]>),
    /// There is no good way: a fan, too.
    Doubtful(Doubt),
}

/// A corner that is farther from the polygon's plane than this part of the polygon's size makes it crooked.
const CROOKED: f64 = 0.25;
/// Cuts polygons, whose fans stand in `triangles`, as they need it.
pub(super) fn cut(positions: &[[f32; 3]], triangles: &mut [[u32; 3]], polygons: &[Polygon]) -> Cuts {
    let cut_one = |polygon: &Polygon| {
        let corners = corners(&triangles[polygon.range()]);
        let points: Vec<[f64; 3]> =
            corners.iter().map(|&corner| positions[corner as usize].map(f64::from)).collect();
        match cut_points(&points) {
            Cut::Fan => None,
            Cut::Inside(parts) => {
                let parts = parts.into_iter().map(|part| part.map(|corner| corners[corner as usize]));
                Some((*polygon, Ok(parts.collect::<Vec<_>>())))
            }
            Cut::Doubtful(doubt) => Some((*polygon, Err(doubt))),
        }
    };
    let found: Vec<_> = polygons.par_iter().filter_map(cut_one).collect();
    let mut cuts = Cuts::default();
    for (polygon, parts) in found {
        match parts {
            Ok(parts) => {
                triangles[polygon.range()].copy_from_slice(&parts);
                cuts.concave += 1;
            }
            Err(doubt) => {
                cuts.first_doubtful.get_or_insert((polygon.face, doubt));
                cuts.doubtful += 1;
            }
        }
    }
    cuts
}

/// The corners of a fan.
fn corners(fan: &[[u32; 3]]) -> Vec<u32> {
    let first = fan[0];
    [first[0], first[1]].into_iter().chain(fan.iter().map(|triangle| triangle[2])).collect()
}

fn cut_points(points: &[[f64; 3]]) -> Cut {
    let across = normal(points);
    let length = dot(across, across).sqrt();
    if is_crooked(points, across.map(|component| component / length)) {
        return Cut::Doubtful(Doubt::FarFromFlat);
    }
    let flat = projected(points, across);
    // Without an area there is nothing to see of a fan, unless the polygon crosses itself.
    let is_nothing = || points.windows(2).all(|edge| normal(&[points[0], edge[0], edge[1]]) == [0.0; 3]);
    if is_convex(&flat) || (length == 0.0 && is_nothing()) {
        return Cut::Fan;
    }
    let (kept, mut parts) = trimmed(&flat);
    let flat: Vec<[f64; 2]> = kept.iter().map(|&corner| flat[corner as usize]).collect();
    if let Some(doubt) = doubt(&flat) {
        return Cut::Doubtful(doubt);
    }
    let mut cut = Vec::new();
    Earcut::new().earcut(flat.iter().copied(), &[], &mut cut);
    let Some(cut) = inside(&flat, cut.as_chunks().0.to_vec()) else {
        return Cut::Doubtful(Doubt::CrossesItself);
    };
    parts.extend(cut.into_iter().map(|part| part.map(|corner| kept[corner as usize])));
    Cut::Inside(parts)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn is_crooked(points: &[[f64; 3]], unit_normal: [f64; 3]) -> bool {
    let range = |along: &dyn Fn(&[f64; 3]) -> f64| {
        let bounds = (f64::INFINITY, f64::NEG_INFINITY);
        let (least, most) = points.iter().map(along).fold(bounds, |(least, most), x| (least.min(x), most.max(x)));
        most - least
    };
    let size = [0, 1, 2].map(|axis| range(&|point| point[axis]));
    // Both sides of the plane count.
    range(&|point| dot(*point, unit_normal)) > 2.0 * CROOKED * dot(size, size).sqrt()
}

/// Leaves out the axis nearest to the normal, so that the area is positive.
fn projected(points: &[[f64; 3]], normal: [f64; 3]) -> Vec<[f64; 2]> {
    let size = normal.map(f64::abs);
    let axis = (0..3).fold(0, |largest, axis| if size[axis] > size[largest] { axis } else { largest });
    let (mut u, mut v) = ((axis + 1) % 3, (axis + 2) % 3);
    if normal[axis] < 0.0 {
        (u, v) = (v, u);
    }
    points.iter().map(|point| [point[u], point[v]]).collect()
}

/// Puts the corners back that `parts` leave out; `None` if the triangles are then not what is inside of the polygon.
fn inside(flat: &[[f64; 2]], mut parts: Vec<[u32; 3]>) -> Option<Vec<[u32; 3]>> {
    let count = flat.len() as u32;
    let mut is_used = vec![false; flat.len()];
    parts.as_flattened().iter().for_each(|&corner| is_used[corner as usize] = true);
    let first = is_used.iter().position(|&used| used)? as u32;
    let mut before = first;
    for step in 1..=count {
        let corner = (first + step) % count;
        if is_used[corner as usize] {
            before = corner;
            continue;
        }
        let next = (1..count).map(|ahead| (corner + ahead) % count).find(|&ahead| is_used[ahead as usize])?;
        let split = parts.iter_mut().find_map(|part| {
            let at = (0..3).find(|&at| part[at] == before && part[(at + 1) % 3] == next)?;
            let opposite = part[(at + 2) % 3];
            *part = [before, corner, opposite];
            Some([corner, next, opposite])
        });
        parts.push(split?);
        before = corner;
    }
    let area: f64 = flat.windows(2).map(|edge| cross(flat[0], edge[0], edge[1])).sum();
    let areas = parts.iter().map(|part| {
        let [a, b, c] = part.map(|corner| flat[corner as usize]);
        cross(a, b, c).abs()
    });
    let is_whole = (areas.sum::<f64>() - area).abs() <= OVERLAP * area;
    (is_whole && parts.len() == flat.len() - 2).then_some(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Turns a flat outline into space, and scales it.
    fn placed(outline: &[[f64; 2]], turned: bool) -> Vec<[f64; 3]> {
        let place = |&[x, y]: &[f64; 2]| if turned { [y - 3.0, 7.0 - x, x + 2.0 * y] } else { [x, y, 0.5] };
        outline.iter().map(place).map(|point| point.map(|coordinate| f64::from(coordinate as f32))).collect()
    }

    fn area(points: &[[f64; 3]], parts: &[[u32; 3]]) -> f64 {
        let area = |part: &[u32; 3]| {
            let across = normal(&part.map(|corner| points[corner as usize]));
            0.5 * dot(across, across).sqrt()
        };
        parts.iter().map(area).sum()
    }

    /// The cut must cover the area of the outline, with n - 2 triangles that use every corner.
    fn must_be_inside(outline: &[[f64; 2]], flat_area: f64) {
        let count = outline.len();
        for turned in [false, true] {
            for start in 0..count {
                for backwards in [false, true] {
                    let mut outline = outline.to_vec();
                    outline.rotate_left(start);
                    if backwards {
                        outline.reverse();
                    }
                    let points = placed(&outline, turned);
                    let Cut::Inside(parts) = cut_points(&points) else { panic!("{outline:?}") };
                    let expected = if turned { flat_area * 6f64.sqrt() } else { flat_area };
                    assert!((area(&points, &parts) - expected).abs() < 1e-9, "{outline:?} {parts:?}");
                    assert_eq!(parts.len(), count - 2);
                    let used = |corner| parts.as_flattened().contains(&corner);
                    assert!((0..count as u32).all(used), "{outline:?} {parts:?}");
                    // Every edge of the outline is an edge of one triangle, in the same direction.
                    for corner in 0..count as u32 {
                        let edge = [corner, (corner + 1) % count as u32];
                        let has_edge = |part: &&[u32; 3]| (0..3).any(|at| [part[at], part[(at + 1) % 3]] == edge);
                        assert_eq!(parts.iter().filter(has_edge).count(), 1, "{edge:?} {parts:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn concave_polygons_are_cut_inside_their_outline() {
        // An arrow head, an L, a comb, a hexagon with a notch.
        must_be_inside(&[[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [0.5, 1.0]], 1.5);
        must_be_inside(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]], 4.0);
        let comb = [
            [0.0, 0.0],
            [5.0, 0.0],
            [5.0, 3.0],
            [4.0, 3.0],
            [4.0, 1.0],
            [3.0, 1.0],
            [3.0, 3.0],
            [2.0, 3.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [0.0, 3.0],
        ];
        must_be_inside(&comb, 11.0);
    }

    /// A U without and with corners that enclose nothing, at every start and in both directions: by equal corners, by one
    /// edge there and back, by several.
    #[test]
    fn corners_that_enclose_nothing_change_nothing() {
        let u = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [3.0, 4.0], [3.0, 1.0], [1.0, 1.0], [1.0, 4.0], [0.0, 4.0]];
        let with = |at: usize, further: &[[f64; 2]]| {
            let mut outline = u.to_vec();
            outline.splice(at + 1..at + 1, further.iter().copied());
            outline
        };
        for (at, &here) in u.iter().enumerate() {
            must_be_inside(&with(at, &[here]), 10.0);
            must_be_inside(&with(at, &[here, here, here]), 10.0);
            must_be_inside(&with(at, &[[2.5, 0.5], here]), 10.0);
            must_be_inside(&with(at, &[[2.5, 0.5], [2.5, 0.25], [2.5, 0.5], here]), 10.0);
        }
        must_be_inside(&u.iter().flat_map(|&corner| [corner, corner]).collect::<Vec<_>>(), 10.0);
    }

    #[test]
    fn a_notch_of_small_turns_is_cut() {
        for (count, size, radius) in [(5000_usize, 2.0, 1.8), (700, 50.0, 1.0)] {
            let around = (0..=count).map(|i| (std::f64::consts::PI * i as f64 / count as f64).sin_cos());
            let notch = around.map(|(sin, cos)| [radius * cos, size - radius * sin]);
            let corners =
                [[-size, -size], [size, -size], [size, size]].into_iter().chain(notch).chain([[-size, size]]);
            let points = placed(&corners.collect::<Vec<_>>(), false);
            let Cut::Inside(parts) = cut_points(&points) else { panic!("not cut") };
            let expected = 4.0 * size * size - 0.5 * std::f64::consts::PI * radius * radius;
            assert!((area(&points, &parts) - expected).abs() < 1e-4 * radius, "{count}");
        }
    }

    #[test]
    fn polygons_of_thousands_of_corners_are_cut() {
        let corner = |i: usize, inner: f64| {
            let angle = std::f64::consts::TAU * i as f64 / 5000.0;
            let radius = if i.is_multiple_of(2) { 10.0 } else { inner };
            [radius * angle.cos(), radius * angle.sin()]
        };
        for inner in [3.0, 0.1] {
            let points = placed(&(0..5000).map(|i| corner(i, inner)).collect::<Vec<_>>(), false);
            let Cut::Inside(parts) = cut_points(&points) else { panic!("not cut") };
            let expected = 2500.0 * 10.0 * inner * (std::f64::consts::TAU / 5000.0).sin();
            assert!((area(&points, &parts) / expected - 1.0).abs() < 1e-5);
        }
        let around: Vec<_> = (0..5000).map(|i| corner(1250 * i, 3.0)).collect();
        assert_eq!(cut_points(&placed(&around, false)), Cut::Doubtful(Doubt::CrossesItself));
    }

    #[test]
    fn corners_on_straight_edges_are_kept() {
        let notched = [
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [3.0, 0.0],
            [3.0, 2.0],
            [2.0, 2.0],
            [1.5, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ];
        must_be_inside(&notched, 5.5);
    }

    #[test]
    fn convex_polygons_stay_fans() {
        for count in [4, 5, 6, 17, 1000] {
            let corner = |i: usize| {
                let angle = std::f64::consts::TAU * i as f64 / count as f64;
                [10.0 + angle.cos(), 3.0 + angle.sin()]
            };
            let circle: Vec<_> = (0..count).map(corner).collect();
            for turned in [false, true] {
                assert_eq!(cut_points(&placed(&circle, turned)), Cut::Fan, "{count}");
            }
        }
        let with_straight_edges =
            [[0.1, 0.1], [0.2, 0.1], [0.3, 0.1], [0.3, 0.3], [0.2, 0.3], [0.1, 0.3], [0.1, 0.2]];
        assert_eq!(cut_points(&placed(&with_straight_edges, true)), Cut::Fan);
    }

    #[test]
    fn without_an_area_there_is_nothing_to_cut() {
        for points in [vec![[1.0; 3]; 6], vec![[0.0; 3], [1.0; 3], [3.0; 3], [2.0; 3]]] {
            assert_eq!(cut_points(&points), Cut::Fan, "{points:?}");
        }
    }

    #[test]
    fn polygons_that_cross_themselves_or_are_crooked_are_doubtful() {
        let bow_tie = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        let uneven_bow_tie = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 3.0]];
        let star = [0, 2, 4, 1, 3].map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i) / 5.0;
            [angle.cos(), angle.sin()]
        });
        for outline in [&bow_tie[..], &uneven_bow_tie, &star] {
            for turned in [false, true] {
                assert_eq!(
                    cut_points(&placed(outline, turned)),
                    Cut::Doubtful(Doubt::CrossesItself),
                    "{outline:?}"
                );
            }
        }
        let height = |corner: usize| if corner.is_multiple_of(2) { 1.0 } else { -1.0 };
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let crooked: Vec<_> = square.iter().enumerate().map(|(i, [x, y])| [*x, *y, height(i)]).collect();
        assert_eq!(cut_points(&crooked), Cut::Doubtful(Doubt::FarFromFlat));
    }
}
