//! Transforms that stretch, flatten and mirror objects, and move them far away.

use super::exact::{at, cross, dot, f, q, size, sub, v};
use super::support::{Random, Studio, U, check, check_that, modes, objects, ray, vector};
use a2::objects::Ray;

fn transformed(steps: &str, object: &str) -> String {
    objects(&format!("Transform {{ {steps} {object} }}"))
}

const UNIT_SPHERE: &str = "Sphere { center 0 0 0 radius 1 }";
const UNIT_TRIANGLE: &str = "Triangle { vertex0 -1 -1 0 vertex1 1 -1 0 vertex2 0 1 0 }";

#[test]
fn hits_lie_on_scaled_spheres() {
    // The ray in object space has 4 u of each coordinate, the sphere's own test 16 u of distance and radius.
    for (case, scale) in [("1e-9", 1e-9), ("1e-6", 1e-6), ("1e6", 1e6), ("1e9", 1e9), ("-1e3", -1e3)] {
        for mode in modes() {
            let studio =
                Studio::new(&transformed(&format!("UniformScale {scale:e}"), UNIT_SPHERE), mode.flags).at(mode);
            let mut random = Random(1);
            let mut worst: f64 = 0.0;
            for _ in 0..100 {
                let from = random.unit().map(|x| 4.0 * x);
                let to = random.unit().map(|x| 0.9 * x);
                let scaled = |x: [f64; 3]| x.map(|x| x * scale);
                let direction = vector([0, 1, 2].map(|i| to[i] - from[i])).normalized();
                let direction = if scale < 0.0 { -direction } else { direction };
                let ray = Ray { origin: vector(scaled(from)), direction };
                let Some(t) = studio.t(&ray) else { panic!("missed at {scale}") };
                let point = at(&v(ray.origin), &v(ray.direction), &q(t));
                let height = (dot(&point, &point) - q(scale) * q(scale)) / (q(2.0) * q(scale));
                worst = worst.max(size(&height) / (U * 5.0 * scale.abs()));
            }
            check(&format!("unit sphere scaled by {case}: height of hits, u (distance + radius)"), 24.0, worst);
        }
    }
}

#[test]
fn an_uneven_scaling_along_the_axes_loses_no_digits() {
    // A scaling along the axes has condition number 1 for any factors.
    for mode in modes() {
        let studio = Studio::new(&transformed("Scale 1e9 1 1e-9", UNIT_SPHERE), mode.flags).at(mode);
        let hit = studio.t(&ray([3e8, 5.0, 2e-10], [0.0, -1.0, 0.0]));
        let exact = 5.0 - (1.0 - 0.09 - 0.04_f64).sqrt();
        check(
            "unit sphere scaled by 1e9 1 1e-9: error of t, u",
            100.0,
            hit.map_or(f64::INFINITY, |t| (t - exact).abs()) / U,
        );
        check_that(
            "unit sphere scaled by 1e9 1 1e-9: missed beside it",
            studio.t(&ray([0.0, 5.0, 1.1e-9], [0.0, -1.0, 0.0])).is_none(),
        );
        let normal = studio.seen(&ray([0.0, 5.0, 0.0], [0.0, -1.0, 0.0])).normal;
        check_that("unit sphere scaled by 1e9 1 1e-9: its normal", normal == vector([0.0, 1.0, 0.0]));
    }
}

#[test]
fn hits_on_rotated_needles_are_as_exact_as_the_condition_number_says() {
    // A needle is rotated by 30 degrees, so |M| |M^-1| has row sums near the ratio of its axes. The error bound of a
    // hit is that ratio times 4 u (to object space) plus 16 u (sphere) of the distance. On its axis the tip is at
    // 1e3.
    for (case, thin) in [("1e3", 1e-3), ("1e6", 1e-6)] {
        let steps = format!("ZRotate 30 Scale 1000 {:e} {:e}", 1e3 * thin, 1e3 * thin);
        for mode in modes() {
            let studio = Studio::new(&transformed(&steps, UNIT_SPHERE), mode.flags).at(mode);
            let (sin, cos) = (0.5, 3_f64.sqrt() / 2.0);
            let hit = studio.t(&ray([2e3 * cos, 2e3 * sin, 0.0], [-cos, -sin, 0.0]));
            let error = hit.map_or(f64::INFINITY, |t| (t - 1e3).abs());
            check(
                &format!("needle of 1 to {case} turned by 30 degrees: error of t, u condition distance"),
                40.0,
                error / (U / thin * 3e3),
            );
        }
    }
}

#[test]
fn world_bounds_contain_the_surface_of_the_rounded_inverse() {
    // The surface is the set of points that the rounded inverse takes to the triangle. Its corners are computed here
    // without rounding. Rays through points near these corners must enter the world bounds.
    let mut random = Random(9);
    let corners = [vector([-1.0, -1.0, 0.0]), vector([1.0, -1.0, 0.0]), vector([0.0, 1.0, 0.0])];
    let (mut lost, mut hits) = (0, 0);
    for _ in 0..60 {
        let a = random.unit();
        let stretch = 10_f64.powf(5.0 + random.signed());
        let steps = format!(
            "Rotate {{ {} {} {} {} }} Scale {stretch:e} 1 {:e} Rotate {{ {} {} {} 50 }}",
            a[0],
            a[1],
            a[2],
            90.0 * random.signed(),
            1.0 / stretch,
            a[1],
            a[2],
            a[0]
        );
        let studio = Studio::new(&transformed(&steps, UNIT_TRIANGLE), "");
        let transform = studio.scene.geometry.objects[0].transform.as_ref().unwrap();
        let columns = transform.object_from_world.columns.map(|c| [c.x, c.y, c.z].map(|x| q(f64::from(x))));
        let volume = dot(&columns[0], &cross(&columns[1], &columns[2]));
        for i in 0..150 {
            // The target is a point of the triangle near a corner.
            let corner = corners[i % 3];
            let inside = corner * (1.0 - 10_f64.powf(-9.0 + 6.0 * random.signed()) as vecmath::Real);
            let image = sub(&v(inside), &columns[3]);
            // Cramer's rule.
            let world = [
                dot(&image, &cross(&columns[1], &columns[2])),
                dot(&columns[0], &cross(&image, &columns[2])),
                dot(&columns[0], &cross(&columns[1], &image)),
            ];
            let target = vector(world.map(|x| f(&(x / &volume))));
            let origin = target + vector(random.unit()) * (2.0 * target.max_abs());
            let ray = Ray { origin, direction: (target - origin).normalized() };
            let prepared = a2::objects::PreparedRay::new(transform.ray_to_object(&ray));
            if a2::objects::intersect_triangle(&prepared, corners).is_some() {
                hits += 1;
                lost += u32::from(studio.t(&ray).is_none());
            }
        }
    }
    assert!(hits > 2000, "{hits}");
    check("triangles with condition numbers up to 1e12: hits lost at world bounds", 0.0, f64::from(lost));
}

#[test]
fn mirrored_and_sheared_normals_stay_outward() {
    for mode in modes() {
        for (case, steps) in
            [("mirrored", "Scale -1 1 1"), ("sheared", "Matrix4f { 1 0 0 0  0.7 1 0 0  0 0.3 1 0  0 0 0 1 }")]
        {
            let studio = Studio::new(&transformed(steps, UNIT_SPHERE), mode.flags).at(mode);
            let mut random = Random(2);
            let mut wrong = 0;
            for _ in 0..200 {
                let (from, jitter) = (random.unit().map(|x| 6.0 * x), random.unit());
                let to = [0, 1, 2].map(|i| 0.2 * jitter[i] - from[i]);
                let ray = Ray { origin: vector(from), direction: vector(to).normalized() };
                let normal = studio.seen(&ray).normal;
                // Seen from outside, every visible normal of a convex body points to the eye's side.
                wrong += u32::from(normal.dot(ray.direction) >= 0.0 || (normal.length() - 1.0).abs() > 1e-6);
            }
            check(&format!("{case} sphere: normals that look away from the eye"), 0.0, f64::from(wrong));
        }
    }
}

#[test]
fn a_hundred_nested_transforms_lose_few_digits() {
    // Fifty pairs of transforms undo each other in exact arithmetic: powers of two, and quarter turns about the axes.
    // A quarter turn has 1 u in its cosine, so 100 of them have about 200 u; the sphere adds 24 u of the distance.
    let deep = |object: &str| {
        let open = "Transform { UniformScale 2 YRotate 90 Transform { YRotate -90 UniformScale 0.5 ".repeat(50);
        objects(&format!("{open}{object}{}", "} }".repeat(50))).replace("numObjects 100", "numObjects 1")
    };
    for mode in modes() {
        let plain = Studio::new(&objects(UNIT_SPHERE), mode.flags).at(mode);
        let nested = Studio::new(&deep(UNIT_SPHERE), mode.flags).at(mode);
        let ray = ray([0.3, 0.2, 5.0], [0.0, 0.0, -1.0]);
        let error = (plain.t(&ray).unwrap_or(0.0) - nested.t(&ray).unwrap_or(f64::INFINITY)).abs();
        check("100 transforms deep: error of t, u", 500.0, error / U);
    }
}

#[test]
fn a_triangle_moved_1e9_away_is_hit_exactly() {
    for mode in modes() {
        let studio = Studio::new(&transformed("Translate 1e9 -1e9 1e9", UNIT_TRIANGLE), mode.flags).at(mode);
        let hit = studio.t(&ray([1e9 + 0.25, -1e9 - 0.25, 1e9 + 3.0], [0.0, 0.0, -1.0]));
        // All of these numbers are exact.
        check("triangle carried 1e9 away: error of t", 0.0, hit.map_or(f64::INFINITY, |t| (t - 3.0).abs()));
        let aside = studio.t(&ray([1e9 + 1.01, -1e9, 1e9 + 3.0], [0.0, 0.0, -1.0]));
        check_that("triangle carried 1e9 away: missed beside it", aside.is_none());
    }
}

#[test]
fn translations_and_scalings_there_and_back_cancel() {
    // The matrix of a translation by 1e9 there and back has no rounding.
    for mode in modes() {
        let steps = "Translate 1e9 0 0 Scale 1e9 1e9 1e9 Scale 1e-9 1e-9 1e-9 Translate -1e9 0 0";
        let studio = Studio::new(&transformed(steps, UNIT_TRIANGLE), mode.flags).at(mode);
        let hit = studio.t(&ray([0.0, 0.0, 3.0], [0.0, 0.0, -1.0]));
        // The scalings leave a factor of at most 1 + 2 u, so the translation back leaves 2e9 u, but not along the
        // ray.
        check(
            "moved and scaled by 1e9 there and back: error of t, u",
            16.0,
            hit.map_or(f64::INFINITY, |t| (t - 3.0).abs()) / U,
        );
    }
}

#[test]
fn matrices_without_inverse_are_refused_with_place_and_condition_number() {
    for (case, steps) in [
        ("Scale 1 0 1", "Scale 1 0 1"),
        ("rank 2", "Matrix4f { 1 2 3 0  4 5 6 0  7 8 9 0  0 0 0 1 }"),
        ("columns alike but for 1e-16", "Matrix4f { 1 2 3 0  1 2 3.0000000000000004 0  7 8 1 0  0 0 0 1 }"),
    ] {
        let said = Studio::refusal(&transformed(steps, UNIT_SPHERE));
        let holds =
            said.starts_with("s.txt:4:13: ") && said.contains("no inverse") && said.contains("condition number");
        check_that(&format!("singular matrix ({case}): refused at its place, with the condition number"), holds);
    }
    let product = Studio::refusal(&transformed("ZRotate 45 Scale 1e9 1e-9 1 ZRotate 45", UNIT_SPHERE));
    check_that(
        "singular product of regular matrices: refused",
        product.contains("no inverse") && product.contains("condition number"),
    );
    let nearly =
        Studio::new(&transformed("Matrix4f { 1 2 3 0  1 2 3.0000000001 0  7 8 1 0  0 0 0 1 }", UNIT_SPHERE), "");
    check_that(
        "nearly singular matrix: a warning with the condition number",
        nearly.warnings.iter().any(|w| w.contains("nearly singular: condition number")),
    );
}
