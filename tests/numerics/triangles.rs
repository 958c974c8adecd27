//! Single triangles: slivers, tiny ones, edges and corners, rays in their planes. `leaks` tests neighbours.

use super::exact::{Q, at, cross, dot, f, q, size, sub, v};
use super::support::{Random, Studio, U, check, check_that, modes, objects, ray, vector};
use a2::objects::Ray;

type Corners = [[f64; 3]; 3];

fn text([a, b, c]: Corners) -> String {
    let corner = |name: &str, [x, y, z]: [f64; 3]| format!("{name} {x:e} {y:e} {z:e} ");
    format!("Triangle {{ {}{}{} }}\n", corner("vertex0", a), corner("vertex1", b), corner("vertex2", c))
}

/// Returns the exact t of the triangle's plane.
fn exact_t(corners: Corners, ray: &Ray) -> Q {
    let [a, b, c] = corners.map(|corner| v(vector(corner)));
    let normal = cross(&sub(&b, &a), &sub(&c, &a));
    dot(&normal, &sub(&a, &v(ray.origin))) / dot(&normal, &v(ray.direction))
}

/// Makes a ray from `origin` to the point of the triangle with these barycentric coordinates.
fn ray_to(corners: Corners, weights: [f64; 3], origin: [f64; 3]) -> Ray {
    let to = [0, 1, 2].map(|i| (0..3).map(|k| weights[k] * corners[k][i]).sum::<f64>() - origin[i]);
    Ray { origin: vector(origin), direction: vector(to).normalized() }
}

#[test]
fn t_is_exact_for_ordinary_and_for_thin_triangles() {
    // t is a mean of the corners' depths; the weights are edge functions over their sum. For thin triangles the
    // weights lose digits, but the corners lie in a plane. With a slant s of the triangle against the ray the error
    // bound is 6 u of the distance (the depths) plus 60 u l^2 / A of l s (l longest edge, A area).
    for (case, corners, origin) in [
        ("triangle of size 1", [[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.2, 1.0, 0.3]], [0.3, 0.4, 3.0]),
        ("triangle of size 1e-6", [[0.0, 0.0, 0.0], [1e-6, 1e-7, 0.0], [2e-7, 1e-6, 3e-7]], [3e-7, 4e-7, 3e-6]),
        ("triangle of size 1e9", [[0.0, 0.0, 0.0], [1e9, 1e8, 0.0], [2e8, 1e9, 3e8]], [3e8, 4e8, 3e9]),
        ("triangle 1e9 away", [[1e9, 0.0, 0.0], [1e9, 1e3, 0.0], [1e9, 0.0, 1e3]], [0.0, 0.0, 0.0]),
        ("sliver of aspect 1e4", [[0.0, 0.0, 0.0], [1.0, 0.3, 0.2], [0.5, 0.1501, 0.1]], [0.3, 0.1, 3.0]),
        ("sliver of aspect 1e8", [[0.0, 0.0, 0.0], [1.0, 0.3, 0.2], [0.5, 0.150_000_01, 0.1]], [0.3, 0.1, 3.0]),
    ] {
        let [a, b, c] = corners.map(|corner| v(vector(corner)));
        let longest = [sub(&a, &b), sub(&b, &c), sub(&c, &a)]
            .map(|e| f(&dot(&e, &e)).sqrt())
            .into_iter()
            .fold(0.0, f64::max);
        let normal = cross(&sub(&b, &a), &sub(&c, &a));
        let shape = longest * longest / (f(&dot(&normal, &normal)).sqrt() / 2.0);
        for mode in modes() {
            let studio = Studio::new(&objects(&text(corners)), mode.flags).at(mode);
            let ray = ray_to(corners, [0.3, 0.25, 0.45], origin);
            let exact = exact_t(corners, &ray);
            let error = studio.t(&ray).map_or(f64::INFINITY, |t| size(&(q(t) - &exact)));
            let bound = 6.0 * f(&exact) + 60.0 * shape * longest;
            check(&format!("{case}: error of t, u (6 t + 60 l^3 / A)"), 1.0, error / (U * bound));
        }
    }
}

#[test]
fn the_surface_point_of_a_sliver_lies_in_its_plane() {
    // The surface point is a mean of the corners. It lies in the plane within 8 u of the coordinates, at any aspect.
    for power in [2, 4, 6, 8] {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.3, 0.2], [0.5, 0.15 + 10_f64.powi(-power), 0.1]];
        for mode in modes() {
            let studio = Studio::new(&objects(&text(corners)), mode.flags).at(mode);
            let ray = ray_to(corners, [0.3, 0.25, 0.45], [0.3, 0.1, 3.0]);
            let Some(hit) = studio.hit(&ray) else { panic!("missed") };
            let [a, b, c] = corners.map(|corner| v(vector(corner)));
            let normal = cross(&sub(&b, &a), &sub(&c, &a));
            let off = dot(&normal, &sub(&v(studio.surface_point(&ray, &hit).point), &a));
            let off = size(&off) / f(&dot(&normal, &normal)).sqrt();
            check(&format!("sliver of aspect 1e{power}: distance of the point from its plane, u"), 8.0, off / U);
        }
    }
}

#[test]
fn corners_and_edges_belong_to_the_triangle() {
    // All numbers are exact here.
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    for mode in modes() {
        let studio = Studio::new(&objects(&text(corners)), mode.flags).at(mode);
        let inside = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.5], [0.5, 0.0], [0.0, 0.25], [0.75, 0.25]];
        let hit = |[x, y]: [f64; 2]| studio.t(&ray([x, y, 1.0], [0.0, 0.0, -1.0])).is_some();
        check_that("corners and edges of a triangle: hit", inside.into_iter().all(hit));
        let just = f64::EPSILON;
        let outside = [[-just, 0.0], [0.5 + just, 0.5], [0.5, -just], [1.0 + just, 0.0], [0.0, 1.0 + just]];
        check_that("one bit beyond corners and edges: missed", !outside.into_iter().any(hit));
    }
}

#[test]
fn a_ray_in_the_plane_of_a_triangle_and_beside_it_misses() {
    // For a triangle seen edge-on all edge functions are nothing but rounding, and often two of them are exactly
    // zero, as at a corner. The ray lies in the triangle's plane, up to rounding, and passes well beside the
    // triangle's box.
    let mut random = Random(3);
    let (mut false_hits, mut edge_on) = (0, 0);
    for _ in 0..20_000 {
        let (e1, e2, at) = (random.unit(), random.unit(), random.unit());
        let point = |x: f64, y: f64| vector([0, 1, 2].map(|i| at[i] + x * e1[i] + y * e2[i]));
        let corners = [point(0.0, 0.0), point(1.0, 0.0), point(0.0, 1.0)];
        let from = point(-2.0, -2.0);
        let ray = Ray { origin: from, direction: (point(2.0, -3.0) - from).normalized() };
        let prepared = a2::objects::PreparedRay::new(ray);
        let bounds = a2::objects::Aabb::of_points(corners);
        if bounds.entry(&prepared, 1e-9, a2::objects::T_MAX).is_none() {
            edge_on += 1;
            false_hits += u32::from(a2::objects::intersect_triangle(&prepared, corners).is_some());
        }
    }
    assert!(edge_on > 5000, "{edge_on}");
    check("20,000 rays in a triangle's plane and beside its box: hits", 0.0, f64::from(false_hits));
}

#[test]
fn a_triangle_without_area_is_left_out_with_a_warning() {
    let line = text([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [3.0, 3.0, 0.0]]);
    let studio = Studio::new(&objects(&line), "");
    check_that("triangle without area: left out", studio.scene.geometry.objects.is_empty());
    check_that("triangle without area: a warning", studio.warnings.iter().any(|w| w.contains("no area")));
}

#[test]
fn the_first_of_equal_triangles_is_hit() {
    let same = text([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).repeat(30);
    for mode in modes() {
        let studio = Studio::new(&objects(&same), mode.flags).at(mode);
        let hit = studio.hit(&ray([0.25, 0.25, 3.0], [0.0, 0.0, -1.0]));
        check_that("thirty equal triangles: the first is hit", hit.is_some_and(|hit| hit.object == 0));
    }
}

#[test]
fn a_triangle_of_the_size_of_the_smallest_f32_is_hit() {
    // The coordinates are a few 1e-45, the smallest numbers of an OBJ file. Their products, 1e-90, are ordinary in
    // f64.
    let corners = "v 0 0 0\nv 4e-45 0 0\nv 0 4e-45 0\nf 1 2 3\n";
    let scene = objects("TriangleMesh { obj_file m.obj }");
    for mode in modes() {
        let studio = Studio::with_meshes(&scene, &[("m.obj", corners)], mode.flags).at(mode);
        let hit = studio.hit(&ray([1e-45, 1e-45, 1e-44], [0.0, 0.0, -1.0]));
        check_that(
            "triangle of size 4e-45: hit",
            hit.is_some_and(|hit| (f64::from(hit.surface.t) / 1e-44 - 1.0).abs() < 1e-12),
        );
        check_that(
            "triangle of size 4e-45: missed beside it",
            studio.hit(&ray([4e-45, 4e-45, 1e-44], [0.0, 0.0, -1.0])).is_none(),
        );
        let seen = studio.seen(&ray([1e-45, 1e-45, 1e-44], [0.0, 0.0, -1.0]));
        check_that("triangle of size 4e-45: its normal", seen.normal == vector([0.0, 0.0, 1.0]));
    }
}

#[test]
fn hits_of_random_slivers_lie_within_their_boxes() {
    let mut random = Random(5);
    let mut worst: f64 = 0.0;
    for _ in 0..300 {
        let (a, e) = (random.unit(), random.unit());
        let thin = 10_f64.powf(-4.0 + 4.0 * random.signed());
        let w = random.unit();
        let corners = [a, [0, 1, 2].map(|i| a[i] + e[i]), [0, 1, 2].map(|i| a[i] + 0.5 * e[i] + thin * w[i])];
        let studio = Studio::new(&objects(&text(corners)), "");
        let ray = ray_to(corners, [0.3, 0.3, 0.4], random.unit().map(|x| 3.0 * x));
        if let Some(t) = studio.t(&ray) {
            let point = at(&v(ray.origin), &v(ray.direction), &q(t));
            for axis in 0..3 {
                let coordinates = corners.map(|corner| corner[axis]);
                let low = coordinates.into_iter().fold(f64::INFINITY, f64::min);
                let high = coordinates.into_iter().fold(f64::NEG_INFINITY, f64::max);
                worst = worst.max((low - f(&point[axis])).max(f(&point[axis]) - high));
            }
        }
    }
    // The box is grown by 32 u of the coordinates (up to 4 here), and t itself has 3 u of at most 5.
    check("random slivers of aspect 1 to 1e8: hits outside the box by, u", 160.0, worst / U);
}
