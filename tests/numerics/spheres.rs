//! Spheres of any size, at any distance.
//!
//! The error bound of all cases: the hit o + t d, computed without further rounding, is off the surface by at most 16
//! u of the radius plus the distance between origin and centre. With f = o - c (1 u) and t = c / q, c and q have 7 u
//! each, and from outside no digits cancel. The discriminant, computed from the point nearest to the centre, has 3 u
//! of |f| in each coordinate, and moves the hit by as much across the surface.

use super::exact::{at, dot, f, q, size, sqrt, sub, v};
use super::support::{Mode, Random, Studio, U, check, check_that, modes, objects, ray, vector};
use a2::objects::Ray;

const ROUNDINGS: f64 = 16.0;

fn sphere(center: [f64; 3], radius: f64) -> String {
    let [x, y, z] = center;
    objects(&format!("Sphere {{ center {x:e} {y:e} {z:e} radius {radius:e} }}"))
}

/// Returns the distance of the hit from the sphere, in u of distance and radius; infinite for a miss.
fn height(ray: &Ray, t: Option<f64>, center: [f64; 3], radius: f64) -> f64 {
    let Some(t) = t else { return f64::INFINITY };
    let offset = sub(&at(&v(ray.origin), &v(ray.direction), &q(t)), &v(vector(center)));
    let height = (dot(&offset, &offset) - q(radius) * q(radius)) / (q(2.0) * q(radius));
    let start = sub(&v(ray.origin), &v(vector(center)));
    size(&height) / (U * (f(&dot(&start, &start)).sqrt() + radius))
}

/// Sends random rays from around `origin` to points inside the sphere, and returns the largest height of a hit.
fn worst_height(center: [f64; 3], radius: f64, origin: [f64; 3], mode: Mode) -> f64 {
    let studio = Studio::new(&sphere(center, radius), mode.flags).at(mode);
    let mut random = Random(7);
    let mut worst: f64 = 0.0;
    for _ in 0..300 {
        let inside = random.unit().map(|x| 0.97 * x * random.signed());
        let from = [0, 1, 2].map(|i| origin[i] + 0.1 * radius * random.signed());
        let to = [0, 1, 2].map(|i| center[i] + radius * inside[i] - from[i]);
        let ray = Ray { origin: vector(from), direction: vector(to).normalized() };
        worst = worst.max(height(&ray, studio.t(&ray), center, radius));
    }
    worst
}

#[test]
fn hits_lie_on_spheres_of_every_size_from_every_distance() {
    for (case, center, radius, origin) in [
        ("sphere of radius 1e-6 from 5e-6", [0.0, 0.0, 0.0], 1e-6, [0.0, 0.0, 5e-6]),
        ("sphere of radius 1e-6 from 1", [0.0, 0.0, 0.0], 1e-6, [0.0, 0.0, 1.0]),
        ("sphere of radius 1 from 1e6", [0.0, 0.0, 0.0], 1.0, [0.0, 0.0, 1e6]),
        ("sphere of radius 1e9 from 3e9", [0.0, 0.0, 0.0], 1e9, [0.0, 0.0, 3e9]),
        ("sphere of radius 1e9 from 1 above it", [0.0, 0.0, 0.0], 1e9, [0.0, 0.0, 1.1e9 + 1.0]),
        ("sphere 1e9 from the origin, seen from there", [1e9, 0.0, 0.0], 1e3, [0.0, 0.0, 0.0]),
        ("sphere 1e9 from the origin, seen from beside", [1e9, 1e9, 0.0], 1.0, [1e9, 1e9, 4.0]),
        ("sphere of radius 1e-6 from inside", [0.0, 0.0, 0.0], 1e-6, [1e-7, 0.0, 0.0]),
        ("sphere of radius 1e9 from inside", [0.0, 0.0, 0.0], 1e9, [5e8, 0.0, 0.0]),
    ] {
        for mode in modes() {
            let worst = worst_height(center, radius, origin, mode);
            check(&format!("{case}: height of hits, u (distance + radius)"), ROUNDINGS, worst);
        }
    }
}

#[test]
fn a_camera_above_a_planet_sees_its_horizon() {
    // 2 m above a sphere of radius 6.4e6 the horizon is 5060 m away: sqrt(2 r h + h^2). Rays a little below it hit
    // within 16 u of the sphere, and rays a little above it miss. They are 1e-9 radians apart, many times the error
    // bound.
    let (radius, above) = (6.4e6_f64, 2.0);
    let dip = (radius / (radius + above)).acos();
    for mode in modes() {
        let studio = Studio::new(&sphere([0.0, -radius, 0.0], radius), mode.flags).at(mode);
        let towards = |angle: f64| ray([0.0, above, 0.0], [angle.cos(), -angle.sin(), 0.0]);
        let below = towards(dip + 1e-7);
        check(
            "planet of radius 6.4e6 from 2 above it: height at the horizon, u (distance + radius)",
            ROUNDINGS,
            height(&below, studio.t(&below), [0.0, -radius, 0.0], radius),
        );
        check_that(
            "planet of radius 6.4e6 from 2 above it: sky above the horizon",
            studio.t(&towards(dip - 1e-7)).is_none(),
        );
    }
}

#[test]
fn tangent_rays_hit_or_miss_by_their_distance() {
    // Rays pass the centre at (1 + s) radii. The discriminant has 3 u of |f| = 5 and a few u of r, so 32 u are
    // enough.
    for mode in modes() {
        let studio = Studio::new(&sphere([0.0, 0.0, 0.0], 1.0), mode.flags).at(mode);
        let mut wrong = 0;
        for step in 1..200 {
            let away = f64::from(step) * 32.0 * U;
            wrong += u32::from(studio.t(&ray([1.0 + away, 0.0, 5.0], [0.0, 0.0, -1.0])).is_some());
            wrong += u32::from(studio.t(&ray([1.0 - away, 0.0, 5.0], [0.0, 0.0, -1.0])).is_none());
        }
        check("rays 32 u from tangent: wrong decisions", 0.0, f64::from(wrong));
    }
}

#[test]
fn rays_from_the_surface_miss_outward_and_hit_the_far_side_inward() {
    // The far side is at 2 cos(angle), with 16 u of 2.
    for mode in modes() {
        let studio = Studio::new(&sphere([0.0, 0.0, 0.0], 1.0), mode.flags).at(mode);
        let outward = studio.t(&ray([0.0, 0.0, 1.0], [0.6, 0.0, 0.8]));
        check_that("ray from a sphere outward: no hit", outward.is_none());
        let inward = studio.t(&ray([0.0, 0.0, 1.0], [0.6, 0.0, -0.8])).unwrap_or(f64::NAN);
        check("ray from a sphere inward: error of t", 2.0 * ROUNDINGS * U, (inward - 1.6).abs());
    }
}

#[test]
fn t_agrees_with_a_computation_in_eighty_digits() {
    // For rays through the centre t itself is as exact as the height.
    for (case, radius, distance) in [
        ("small and near", 1e-6, 2e-6),
        ("small and far", 1e-3, 1e6),
        ("large", 1e9, 1.5e9),
        ("huge and near", 1e9, 1.0e9 + 1.0),
    ] {
        for mode in modes() {
            let studio = Studio::new(&sphere([0.0, 0.0, 0.0], radius), mode.flags).at(mode);
            let direction = vector([1e-3 * radius / distance, 2e-3 * radius / distance, -1.0]).normalized();
            let ray = Ray { origin: vector([0.0, 0.0, distance]), direction };
            let (o, d) = (v(ray.origin), v(ray.direction));
            let (a, b, c) = (dot(&d, &d), dot(&o, &d), dot(&o, &o) - q(radius) * q(radius));
            let exact = (-&b - sqrt(&(&b * &b - &a * &c))) / &a;
            let error = studio.t(&ray).map_or(f64::INFINITY, |t| size(&(q(t) - exact)));
            let case = format!("{case} sphere against 80 digits: error of t, u (distance + radius)");
            check(&case, ROUNDINGS, error / (U * (distance + radius)));
        }
    }
}

#[test]
fn normals_are_unit_vectors_that_point_outward() {
    // p is off by 16 u (d + r). So the direction of p - c is off by that over r, and the length by 4 u.
    for (case, center, radius, distance) in [
        ("radius 1e-6", [0.0, 0.0, 0.0], 1e-6, 4e-6),
        ("radius 1e9", [0.0, 0.0, 0.0], 1e9, 4e9),
        ("radius 1e3, 1e9 away", [1e9, 0.0, 0.0], 1e3, 4e3),
    ] {
        for mode in modes() {
            let studio = Studio::new(&sphere(center, radius), mode.flags).at(mode);
            let origin = [center[0] + 0.3 * radius, center[1] - 0.2 * radius, distance];
            let seen = studio.seen(&ray(origin, [0.0, 0.0, -1.0]));
            let (x, y) = ((origin[0] - center[0]) / radius, (origin[1] - center[1]) / radius);
            let expected = vector([x, y, (1.0 - x * x - y * y).sqrt()]);
            let error = f64::from((seen.normal - expected).max_abs());
            let reach = center[0].abs().max(distance) + 5.0 * radius;
            check(
                &format!("sphere of {case}: error of the normal, u (reach / radius)"),
                32.0,
                error / (U * reach / radius),
            );
        }
    }
}
