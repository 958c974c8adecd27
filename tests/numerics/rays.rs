//! Rays along axes and in planes of boxes, and rays of NaN and infinity.

use super::support::{Studio, check, check_that, modes, objects, ray};
use a2::objects::{Aabb, PreparedRay, Ray, T_MAX};
use vecmath::{Real, Vector3};

#[test]
fn rays_in_the_planes_of_a_box_meet_it() {
    // 0 * infinity must make no difference. Corners are powers of two, so nothing is rounded.
    let bounds = Aabb { min: Vector3::new(-1.0, -2.0, -4.0), max: Vector3::new(1.0, 2.0, 4.0) };
    let mut missed = 0;
    for axis in 0..3 {
        for (u, v) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0), (0.0, 1.0), (1.0, 0.0)] {
            for zero in [0.0, -0.0] {
                for sign in [-1.0, 1.0] {
                    let mut origin = bounds.max.scaled_by(Vector3::splat(u)).to_array();
                    origin[(axis + 1) % 3] = bounds.max[(axis + 1) % 3] * v;
                    origin[axis] = -9.0 * sign;
                    let mut direction = [zero; 3];
                    direction[axis] = sign;
                    let ray = Ray { origin: origin.into(), direction: direction.into() };
                    missed += u32::from(bounds.entry(&PreparedRay::new(ray), 0.0, T_MAX).is_none());
                }
            }
        }
    }
    check("rays along the edges and faces of a box: missed", 0.0, f64::from(missed));
}

/// A cube of side 2 around the origin, as an OBJ file.
const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
    f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 4 8 7\nf 4 7 3\nf 1 5 8\nf 1 8 4\nf 2 3 7\nf 2 7 6\n";

#[test]
fn a_cube_is_closed_for_rays_along_the_axes() {
    // Every axis-parallel ray through edges, corners, diagonals and the middle hits the closed cube at t = 1.
    let scene = objects("TriangleMesh { obj_file cube.obj }");
    for mode in modes() {
        let studio = Studio::with_meshes(&scene, &[("cube.obj", CUBE)], mode.flags).at(mode);
        let mut wrong = 0;
        for axis in 0..3 {
            for (u, v) in [(0.0, 0.0), (1.0, 1.0), (-1.0, 1.0), (1.0, 0.0), (0.0, -1.0), (0.5, 0.5), (-0.25, 0.75)]
            {
                for zero in [0.0, -0.0] {
                    let (mut origin, mut direction) = ([0.0; 3], [zero; 3]);
                    (origin[axis], origin[(axis + 1) % 3], origin[(axis + 2) % 3]) = (3.0, u, v);
                    direction[axis] = -1.0;
                    wrong += u32::from(studio.t(&ray(origin, direction)) != Some(2.0));
                }
            }
        }
        check("axis-parallel rays at a cube's edges and corners: wrong answers", 0.0, f64::from(wrong));
    }
}

#[test]
fn rays_of_nan_and_infinity_hit_nothing() {
    let scene = objects(
        "Sphere { center 0 0 0 radius 1 } Plane { normal 0 1 0 offset -1 }
        Triangle { vertex0 -1 -1 0 vertex1 1 -1 0 vertex2 0 1 0 } TriangleMesh { obj_file cube.obj }",
    );
    for mode in modes() {
        let studio = Studio::with_meshes(&scene, &[("cube.obj", CUBE)], mode.flags).at(mode);
        let mut hits = 0;
        for bad in [Real::NAN, Real::INFINITY, Real::NEG_INFINITY] {
            for place in 0..6 {
                let mut numbers = [0.1, 0.2, 5.0, 0.0, -0.1, -1.0];
                numbers[place] = bad;
                let [x, y, z, u, v, w] = numbers;
                let ray = Ray { origin: Vector3::new(x, y, z), direction: Vector3::new(u, v, w) };
                let hit = studio.hit(&ray);
                hits += u32::from(hit.is_some_and(|hit| !(hit.surface.t > 0.0 && hit.surface.t < T_MAX)));
                if bad.is_nan() {
                    hits += u32::from(hit.is_some_and(|hit| hit.object != 1));
                }
            }
        }
        check(
            "rays with NaN and infinities: hits outside of 0 to T_MAX, or of a body by NaN",
            0.0,
            f64::from(hits),
        );
    }
}

#[test]
fn a_hit_counts_at_any_distance_that_is_a_number() {
    for mode in modes() {
        let studio = Studio::new(&objects("Plane { normal 0 1 0 offset -1 }"), mode.flags).at(mode);
        let t = |slope: f64| studio.t(&ray([0.0, 0.0, 0.0], [1.0, -slope, 0.0]));
        check_that("hit at a distance of 3.3e38: counts", t(1.0 / 3.3e38).is_some());
        // Beyond the largest f32, where the starter's search for the nearest hit begins.
        check_that("hit at a distance of 3.5e38: counts", t(1.0 / 3.5e38).is_some());
        check_that("hit at a distance of 1e307: counts", t(1e-307).is_some());
        check_that("hit at a distance beyond all numbers: does not", t(1e-320).is_none());
    }
}

#[test]
fn the_tree_and_the_loop_agree() {
    // Forty triangles and spheres are coplanar, equal, edge-on or thin; rays are random and axis-parallel.
    let mut text = String::new();
    for i in 0..10 {
        let x = 0.1 * f64::from(i);
        text += &format!(
            "Triangle {{ vertex0 {x} 0 0 vertex1 {} 0 0 vertex2 0 {x} 1 }}
            Triangle {{ vertex0 {x} 0 0 vertex1 {} 0 0 vertex2 0 {x} 1 }}
            Triangle {{ vertex0 0 0 {x} vertex1 1 1 {x} vertex2 0.5 0.5000001 {x} }}
            Sphere {{ center {x} {x} {x} radius 0.1 }}\n",
            x + 1.0,
            x + 1.0
        );
    }
    let scene = objects(&text);
    for mode in modes() {
        let studio = Studio::new(&scene, mode.flags).at(mode);
        let mut random = super::support::Random(4);
        let mut different = 0;
        for i in 0..20_000 {
            let (mut from, mut to) = (random.unit(), random.unit());
            if i % 4 == 0 {
                from = from.map(|x| (x * 10.0).round() / 10.0);
                to = to.map(|x| if x.abs() < 0.6 { 0.0 } else { x.signum() });
            }
            if to != [0.0; 3] {
                let ray = ray(from, to);
                different += u32::from(studio.hit(&ray) != studio.hit_by_loop(&ray));
            }
        }
        check("20,000 rays at 40 objects: tree and loop differ", 0.0, f64::from(different));
    }
}
