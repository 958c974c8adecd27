//! Extreme lights, highlights and mirrors.

use super::support::{CAMERA, Studio, U, check, check_that, modes, ray};
use a2::objects::Ray;

/// Makes a scene of a floor y = 0 with a material and lights.
fn floor(material: &str, lights: &str, count: u32) -> String {
    format!(
        "{CAMERA}Lights {{ numLights {count} {lights} }}
        Background {{ color 0 0 0 }}
        Materials {{ numMaterials 1 Material {{ {material} }} }}
        Group {{ numObjects 1 MaterialIndex 0 Plane {{ normal 0 1 0 offset 0 }} }}"
    )
}

fn down(x: f64) -> Ray {
    ray([x, 2.0, 0.0], [0.0, -1.0, 0.0])
}

const FROM_ABOVE: &str = "DirectionalLight { direction 0 -1 0 color 1 1 1 }";

#[test]
fn highlights_are_right_for_any_shininess() {
    // R.L is the cosine of the slant. 0^0 is 1; a very high power is 0 except in the direction of the mirrored ray.
    for mode in modes() {
        let highlight = |shininess: &str, slant: f64| {
            let scene =
                floor(&format!("diffuseColor 0 0 0 specularColor 1 1 1 shininess {shininess}"), FROM_ABOVE, 1);
            Studio::new(&scene, mode.flags).at(mode).color(&ray([0.0, 2.0, 0.0], [slant.sin(), -slant.cos(), 0.0]))
                [0]
        };
        check_that("shininess 0: the highlight is everywhere", highlight("0", 1.2) == 1.0);
        for shininess in ["1", "1e3", "1e10", "1e30"] {
            check_that(
                &format!("shininess {shininess}: whole when looked at straight"),
                highlight(shininess, 0.0) == 1.0,
            );
        }
        check_that("shininess 1e30: nothing at a slant of 1e-3", highlight("1e30", 1e-3) == 0.0);
        // cos(1e-5)^1e10 = exp(-0.5) up to 1e-11. The cosine of two unit vectors has about 4 u, times 1e10.
        let error = (highlight("1e10", 1e-5) - (-0.5_f64).exp()).abs();
        check("shininess 1e10 at a slant of 1e-5: error, u", 8e10, error / U);
    }
    let refused = Studio::refusal(&floor("shininess -1", FROM_ABOVE, 1));
    check_that(
        "shininess -1: an error at its place",
        refused.starts_with("s.txt:") && refused.contains("'shininess' must be 0 or above"),
    );
}

#[test]
fn a_light_in_a_surface_gives_no_light_to_it() {
    // The light grazes the floor, and its own position gets none; nothing is NaN.
    for mode in modes() {
        let lamp = "PointLight { position 0.5 0 0 color 1 1 1 falloff 1 }";
        let studio =
            Studio::new(&floor("diffuseColor 1 1 1", lamp, 1), &format!("-shadows {}", mode.flags)).at(mode);
        check_that("light in the floor: no light along it", studio.color(&down(0.0)) == [0.0; 3]);
        check_that("light in the floor: none in its own place", studio.color(&down(0.5)) == [0.0; 3]);
    }
}

#[test]
fn a_light_on_the_surface_of_a_body_lights_other_bodies() {
    // The lamp is at a sphere's lowest point, one unit above the floor. The starter measures the distance from the
    // offset origin, so the sphere blocks its own lamp. Measured from the surface, it does not block it for floor
    // points below.
    let scene = floor("diffuseColor 1 1 1", "PointLight { position 0 1 0 color 1 1 1 falloff 1 }", 1)
        .replace("numObjects 1", "numObjects 2 ")
        .replace("offset 0 } }", "offset 0 } Sphere { center 0 1.7 0 radius 0.7 } }");
    for mode in modes() {
        let studio = Studio::new(&scene, &format!("-shadows {}", mode.flags)).at(mode);
        let lit = (0..100)
            .filter(|&i| studio.color(&ray([0.8, 0.5, 0.0], [f64::from(i) * 0.01 - 0.9, -0.5, 0.01])) != [0.0; 3])
            .count();
        let case = "lamp on the lowest point of a sphere";
        if mode.robust() {
            check(&format!("{case}, -robust: dark points of 100"), 0.0, 100.0 - lit as f64);
        } else {
            check(&format!("{case}, the starter's distance: lit points of 100"), 0.0, lit as f64);
        }
    }
}

#[test]
fn objects_behind_a_light_cast_no_shadow() {
    // A ceiling is 0.005 behind the lamp. The starter measures the distance from an origin 0.01 nearer.
    let scene = floor("diffuseColor 1 1 1", "PointLight { position 0 1 0 color 1 1 1 falloff 1 }", 1)
        .replace("numObjects 1", "numObjects 2 ")
        .replace("offset 0 } }", "offset 0 } Plane { normal 0 -1 0 offset -1.005 } }");
    for mode in modes() {
        let studio = Studio::new(&scene, &format!("-shadows {}", mode.flags)).at(mode);
        let lit = studio.color(&ray([0.1, 0.9, 0.0], [0.0, -1.0, 0.0])) != [0.0; 3];
        check_that(
            "ceiling 0.005 behind a lamp: lit with -robust, dark as the starter has it",
            lit == mode.robust(),
        );
    }
}

#[test]
fn light_is_right_for_any_falloff() {
    for mode in modes() {
        let light = |falloff: &str, color: &str| {
            format!("PointLight {{ position 0 1 0 color {color} falloff {falloff} }}")
        };
        let seen = |material: &str, falloff: &str, color: &str| {
            Studio::new(&floor(material, &light(falloff, color), 1), mode.flags).at(mode).color(&down(0.0))
        };
        let white = "diffuseColor 1 1 1 specularColor 1 1 1";
        let is_huge = |color: f64| color > 1e30;
        check_that("falloff 0: a huge light", seen(white, "0", "1 1 1").into_iter().all(is_huge));
        let dull = seen("diffuseColor 1 1 0", "0", "1 1 1");
        check_that(
            "falloff 0 and no highlight: huge, and 0 where the material is black",
            is_huge(dull[0]) && is_huge(dull[1]) && dull[2] == 0.0,
        );
        check_that("falloff 1e300: no light", seen("diffuseColor 1 1 1", "1e300", "1 1 1")[0] < 1e-299);
        check_that(
            "falloff 1e-300 and colour 1e-300: as 1 and 1",
            (seen("diffuseColor 1 1 1", "1e-300", "1e-300 1 1")[0] - 1.0).abs() < 1e-12,
        );
        check_that("falloff -1: light is taken away", seen("diffuseColor 1 1 1", "-1", "1 1 1") == [-1.0; 3]);
    }
}

#[test]
fn colours_out_of_range_become_bytes() {
    // 1e30 is clamped to 255, negative values are 0, infinity minus infinity is NaN and 0.
    for mode in modes() {
        let byte = |color: &str| {
            let scene =
                floor("diffuseColor 1 1 1", &format!("DirectionalLight {{ direction 0 -1 0 color {color} }}"), 1)
                    .replace("center 0 0 5 direction 0 0 -1 up 0 1 0", "center 0 5 0 direction 0 -1 0 up 0 0 1");
            Studio::new(&scene, &format!("-size 1 1 {}", mode.flags)).at(mode).film().color.unwrap()
        };
        check_that("colour 1e30 0.5 -1: bytes 255 127 0", byte("1e30 0.5 -1") == [255, 127, 0]);
        check_that("colour 1e308 twice as bright: 255", byte("1.7e308 1 0") == [255, 255, 0]);
        let lights = "PointLight { position 0 1 0 color 1 1 1 } PointLight { position 0 2 0 color -1 1 0 }";
        let scene = floor("diffuseColor 1 1 1 specularColor 1 1 1", lights, 2)
            .replace("center 0 0 5 direction 0 0 -1 up 0 1 0", "center 0 5 0 direction 0 -1 0 up 0 0 1");
        let bytes = Studio::new(&scene, &format!("-size 1 1 {}", mode.flags)).at(mode).film().color.unwrap();
        check_that("huge light less huge light: black", bytes[0] == 0 && bytes[1] == 255);
    }
}

#[test]
fn a_hundred_thousand_bounces_between_two_mirrors_sum_to_the_series() {
    // Each bounce adds a = ambient * diffuse, and multiplies the throughput by the specular colour s: a (1 - s^(n+1))
    // / (1 - s). Throughput and sum have 2 u for each bounce; the error is below n u of the sum.
    let n: i32 = 100_000;
    for (case, s) in [("0.5", 0.5), ("0.999", 0.999), ("0.99999", 0.999_99), ("1", 1.0)] {
        let scene = format!(
            "{CAMERA}Lights {{ numLights 1 DirectionalLight {{ direction 1 0 0 color 0 0 0 }} }}
            Background {{ color 0 0 0 ambientLight 0.25 0.25 0.25 }}
            Materials {{ numMaterials 1 Material {{ diffuseColor 1 1 1 specularColor {s} {s} {s} }} }}
            Group {{ numObjects 2 MaterialIndex 0 Plane {{ normal 0 1 0 offset -1 }} Plane {{ normal 0 -1 0 offset -1 }} }}"
        );
        let exact =
            if s == 1.0 { 0.25 * f64::from(n + 1) } else { 0.25 * (1.0 - f64::powi(s, n + 1)) / (1.0 - s) };
        for mode in modes() {
            let studio = Studio::new(&scene, &format!("-bounces {n} {}", mode.flags)).at(mode);
            let error = (studio.color(&ray([0.0, 0.0, 0.0], [0.0, -1.0, 0.0]))[0] / exact - 1.0).abs();
            check(&format!("100,000 bounces between mirrors of {case}: error of the series, u"), 2e5, error / U);
        }
    }
}

#[test]
fn a_corner_of_mirrors_sends_rays_back() {
    // Three mirrors at right angles send any ray back: the fourth ray hits what is behind the eye. At scales of 1e-6
    // and 1e9 the starter's ray offset of 0.01 is too large or too small; with -robust the ray comes back at every
    // scale.
    for (case, scale) in [("1e-6", 1e-6), ("1", 1.0), ("1e9", 1e9)] {
        let scene = format!(
            "{CAMERA}Lights {{ numLights 1 DirectionalLight {{ direction 1 1 1 color 0 0 0 }} }}
            Background {{ color 0 0 0 ambientLight 1 1 1 }}
            Materials {{ numMaterials 2 Material {{ diffuseColor 0 0 0 specularColor 1 1 1 }} Material {{ diffuseColor 0.5 0 0 }} }}
            Group {{ numObjects 4 MaterialIndex 0 Plane {{ normal 1 0 0 offset 0 }} Plane {{ normal 0 1 0 offset 0 }}
                Plane {{ normal 0 0 1 offset 0 }} MaterialIndex 1 Sphere {{ center {0:e} {0:e} {0:e} radius {1:e} }} }}",
            3.0 * scale, 1.5 * scale
        );
        let studio = Studio::new(&scene, "-bounces 3 -robust");
        let mut dark = 0;
        for i in 0..400 {
            let (x, y) = (0.2 + 0.03 * f64::from(i % 20), 0.2 + 0.03 * f64::from(i / 20));
            // Between this origin and the corner there are only mirrors.
            let back = ray([x * scale, y * scale, 0.9 * scale], [-1.0, -1.1, -0.9]);
            dark += u32::from(studio.color(&back) != [0.5, 0.0, 0.0]);
        }
        check(&format!("corner of mirrors of size {case}, -robust: rays lost of 400"), 0.0, f64::from(dark));
    }
}

#[test]
fn smooth_normals_that_cancel_are_replaced_by_the_face_s() {
    // The vertex normals of two faces back to back cancel out, and each face's own normal is used.
    let obj = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n";
    for mode in modes() {
        let scene = super::support::objects("TriangleMesh { obj_file m.obj }");
        let studio = Studio::with_meshes(&scene, &[("m.obj", obj)], mode.flags).at(mode);
        let seen = studio.seen(&ray([0.0, 0.0, 3.0], [0.0, 0.0, -1.0]));
        check_that(
            "mesh normals that cancel out: the face's own",
            seen.normal == super::support::vector([0.0, 0.0, 1.0]),
        );
    }
}

#[test]
fn cameras_that_see_nothing_are_refused_with_a_message() {
    let refused = |old: &str, new: &str| Studio::refusal(&floor("", FROM_ABOVE, 1).replace(old, new));
    for (old, new, reason) in [
        ("direction 0 0 -1", "direction 0 0 0", "'direction' has no length"),
        ("up 0 1 0", "up 0 0 0", "'up' has no length"),
        ("up 0 1 0", "up 0 0 -7", "'up' is parallel to 'direction'"),
        ("angle 30", "angle 0", "'angle' must be above 0 and below 180"),
        ("angle 30", "angle 180", "'angle' must be above 0 and below 180"),
        ("angle 30", "angle 720", "'angle' must be above 0 and below 180"),
        ("direction 0 -1 0 color", "direction 0 0 0 color", "'direction' has no length"),
    ] {
        check_that(&format!("{new}: {reason}"), refused(old, new).contains(reason));
    }
    for mode in modes() {
        // Vectors whose squares overflow or underflow are directions too.
        let film = |direction: &str, up: &str| {
            let scene = floor("diffuseColor 0.5 0.7 0.9", FROM_ABOVE, 1).replace(
                "center 0 0 5 direction 0 0 -1 up 0 1 0",
                &format!("center 0 1 0 direction {direction} up {up}"),
            );
            Studio::new(&scene, &format!("-size 8 8 {}", mode.flags)).at(mode).film().color
        };
        let usual = film("0 -0.5 -1", "0 1 0");
        check_that(
            "camera direction of length 1e200: the same picture",
            film("0 -0.5e200 -1e200", "0 1 0") == usual,
        );
        check_that(
            "camera direction of length 1e-300: the same picture",
            film("0 -0.5e-300 -1e-300", "0 1 0") == usual,
        );
        check_that("angle 179.9: a picture", film("0 -0.5 -1", "0 1 0").is_some());
    }
}
