//! Planes, and normals of any length.

use super::exact::{at, dot, q, size, v};
use super::support::{Random, Studio, U, check, check_that, modes, objects, ray, vector};
use a2::objects::Ray;
use vecmath::Vector3;

fn plane(normal: [f64; 3], offset: f64) -> String {
    let [x, y, z] = normal;
    objects(&format!("Plane {{ normal {x:e} {y:e} {z:e} offset {offset:e} }}"))
}

/// Returns |n . hit - offset| in u of |n| . (|o| + t |d|) + |offset|. t = (offset - n.o)/(n.d) has 4 u in the
/// numerator, and 3 u + 1 u of |n| . |t d| in the denominator: 8 u.
fn residual(normal: Vector3, offset: f64, ray: &Ray, t: Option<f64>) -> f64 {
    let Some(t) = t else { return f64::INFINITY };
    let (n, point) = (v(normal), at(&v(ray.origin), &v(ray.direction), &q(t)));
    let abs = |v: Vector3| v.map(|x| x.abs());
    let terms = abs(normal).dot(abs(ray.origin) + abs(ray.direction) * t as vecmath::Real);
    size(&(dot(&n, &point) - q(offset))) / (U * (f64::from(terms) + offset.abs()))
}

#[test]
fn hits_lie_on_the_plane_at_every_angle() {
    let turned = [0.6, 0.64, -0.48];
    for (case, normal, offset, slope) in [
        ("plane met head-on", turned, 2.0, 1.0),
        ("plane at an angle of 1e-9", turned, 2.0, 1e-9),
        ("plane at an angle of 1e-14", [0.0, 1.0, 0.0], -1.0, 1e-14),
        ("plane 1e9 away", turned, 1e9, 0.3),
        ("plane with a normal of length 1e200", [6e199, 6.4e199, -4.8e199], 2e200, 0.3),
        ("plane with a normal of length 1e-200", [6e-201, 6.4e-201, -4.8e-201], 2e-200, 0.3),
    ] {
        for mode in modes() {
            let studio = Studio::new(&plane(normal, offset), mode.flags).at(mode);
            let n = vector(normal).normalized();
            let along = Vector3::new(0.3, 0.2, 0.9).cross(n).normalized();
            let towards = n * if offset < 0.0 { -1.0 } else { 1.0 };
            let direction = (along + towards * slope as vecmath::Real).normalized();
            let ray = Ray { origin: vector([0.1, 0.2, 0.3]), direction };
            // The length of the normal does not matter, so the exact numbers need not be a unit vector.
            let scale = f64::from(vector(normal).max_abs());
            let given = vector(normal.map(|x| x / scale));
            let worst = residual(given, offset / scale, &ray, studio.t(&ray));
            check(&format!("{case}: distance of the hit, u of the terms"), 8.0, worst);
        }
    }
}

#[test]
fn planes_through_the_eye_and_parallel_ones_are_not_seen() {
    for mode in modes() {
        let studio = Studio::new(&plane([0.0, 1.0, 0.0], 0.0), mode.flags).at(mode);
        let level = [ray([3.0, 0.0, 5.0], [0.0, 0.0, -1.0]), ray([3.0, 0.0, 5.0], [1.0, 0.0, 0.0])];
        check_that("plane through the eye: no hit along it", level.iter().all(|ray| studio.t(ray).is_none()));
        let leaving = [ray([0.0, 0.0, 5.0], [0.6, -0.8, 0.0]), ray([0.0, -0.0, 5.0], [0.6, 0.8, -0.0])];
        check_that("plane through the eye: no hit leaving it", leaving.iter().all(|ray| studio.t(ray).is_none()));
        let above = [ray([0.0, 1.0, 5.0], [1.0, 0.0, 0.0]), ray([0.0, -1.0, 5.0], [-0.6, -0.0, 0.8])];
        check_that("plane parallel to the ray: no hit", above.iter().all(|ray| studio.t(ray).is_none()));
    }
}

#[test]
fn a_normal_of_any_length_gives_the_same_plane() {
    // The starter shades with the normal as given: |N| times as bright and with a longer mirrored ray. So does the
    // default. With -robust the pictures of a unit normal and of a longer one are the same.
    let scene = |length: f64| {
        format!(
            "PerspectiveCamera {{ center 0 1 5 direction 0 -0.2 -1 up 0 1 0 angle 60 }}
            Lights {{ numLights 1 PointLight {{ position 1 3 1 color 2 2 2 falloff 1 }} }}
            Background {{ color 0.2 0.3 0.4 }}
            Materials {{ numMaterials 1 Material {{ diffuseColor 0.5 0.5 0.5 specularColor 0.5 0.5 0.5 shininess 8 }} }}
            Group {{ numObjects 2 MaterialIndex 0 Plane {{ normal 0 {length} 0 offset 0 }}
                Sphere {{ center 0 1 0 radius 0.5 }} }}"
        )
    };
    let film = |length: f64, flags: &str| {
        Studio::new(&scene(length), &format!("-size 40 30 -shadows -bounces 3 {flags}")).film()
    };
    for (case, length) in [("4", 4.0), ("0.25", 0.25)] {
        let (unit, longer) = (film(1.0, "-robust"), film(length, "-robust"));
        check_that(
            &format!("plane normal of length {case} with -robust: the picture of a unit normal"),
            unit.color == longer.color && unit.normals == longer.normals && unit.depth == longer.depth,
        );
        let (unit, longer) = (film(1.0, ""), film(length, ""));
        check_that(&format!("plane normal of length {case} without: the same depth"), unit.depth == longer.depth);
        check_that(
            &format!("plane normal of length {case} without: the starter's shading"),
            unit.color != longer.color,
        );
    }
}

#[test]
fn a_normal_that_is_not_a_unit_vector_gets_a_hint() {
    let hints = |flags: &str| Studio::new(&plane([0.0, 2.0, 0.0], 0.0), flags).warnings.join("\n");
    let said = hints("");
    check_that(
        "plane normal of length 2: a hint names -robust",
        said.contains("not a unit vector") && said.contains("-robust"),
    );
    check_that("plane normal of length 2: no hint with -robust", !hints("-robust").contains("unit vector"));
    let unit = Studio::new(&plane([0.0, 0.6, -0.8], 0.0), "").warnings.join("\n");
    check_that("plane normal of length 1: no hint", !unit.contains("unit vector"));
    let refused = Studio::refusal(&plane([0.0, 0.0, 0.0], 1.0));
    check_that("plane normal of length 0: an error", refused.contains("'normal' has no length"));
}

#[test]
fn hits_of_random_planes_and_rays_lie_on_the_plane() {
    let mut random = Random(11);
    for _ in 0..200 {
        let (normal, offset) = (random.unit(), random.signed() * 10_f64.powf(9.0 * random.signed()));
        let studio = Studio::new(&plane(normal, offset), "");
        // The program parses the numbers of the text to the last bit.
        for _ in 0..5 {
            let ray = Ray { origin: vector(random.unit()), direction: vector(random.unit()) };
            if let Some(t) = studio.t(&ray) {
                check(
                    "random planes 1e-9 to 1e9 away: distance of hits, u of the terms",
                    8.0,
                    residual(vector(normal), offset, &ray, Some(t)),
                );
            }
        }
    }
}
