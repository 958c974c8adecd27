//! Sizes, distances and lights near the ends of the range of numbers. Values are computed with exact fractions.

use super::exact::{Q, f, q, sqrt};
use super::support::{CAMERA, Studio, U, check, check_that, modes, objects, ray};
use a2::film::Film;

/// Returns 2^exponent as a fraction.
fn power(exponent: i32) -> Q {
    let two = Q::from_integer(2.into());
    num_traits::Pow::pow(&two, exponent)
}

/// Returns the error of t in u of the exact value; infinite for a miss.
fn error(t: Option<f64>, exact: &Q) -> f64 {
    t.map_or(f64::INFINITY, |t| f(&((q(t) - exact) / exact)).abs() / U)
}

#[test]
fn an_eye_inside_a_sphere_of_any_size_sees_it() {
    // The eye is off the centre by half the radius, or by 1 if that is less. The sphere has 16 u of the diameter.
    for size in [-300, -200, -100, -39, 39, 100, 160, 300] {
        let radius: f64 = format!("1e{size}").parse().unwrap();
        let from = (0.5 * radius).min(1.0);
        for mode in modes() {
            let scene = objects(&format!("Sphere {{ center 0 0 0 radius {radius:e} }}"));
            let studio = Studio::new(&scene, mode.flags).at(mode);
            let along = studio.t(&ray([0.0, 0.0, from], [0.0, 0.0, 1.0]));
            let across = studio.t(&ray([0.0, 0.0, from], [1.0, 0.0, 0.0]));
            let (r, z) = (q(radius), q(from));
            let case = format!("eye inside a sphere of radius 1e{size}: error of t, u");
            check(&case, 32.0, error(along, &(&r - &z)));
            // The root of numbers as small as 1e-600 is taken of multiples of the radius.
            let ratio = &z / &r;
            check(&case, 32.0, error(across, &(sqrt(&(q(1.0) - &ratio * &ratio)) * &r)));
        }
    }
}

#[test]
fn planes_and_triangles_are_hit_at_any_size() {
    // Both are met head-on at a distance of 3 sizes, beside the middle.
    for exponent in [-1000, -500, -300, -126, 126, 300, 500, 1000] {
        let size = f(&power(exponent));
        let triangle = format!(
            "Triangle {{ vertex0 -{size:e} -{size:e} 0 vertex1 {size:e} -{size:e} 0 vertex2 0 {size:e} 0 }}"
        );
        for mode in modes() {
            for shape in [format!("Plane {{ normal 0.5 0 1 offset {:e} }}", 0.125 * size), triangle.clone()] {
                let studio = Studio::new(&objects(&shape), mode.flags).at(mode);
                let t = studio.t(&ray([0.25 * size, 0.0, 3.0 * size], [0.0, 0.0, -1.0]));
                check(
                    &format!("plane and triangle of size 2^{exponent}: error of t, u"),
                    8.0,
                    error(t, &(q(3.0) * power(exponent))),
                );
                let beside = studio.t(&ray([2.0 * size, 0.0, 3.0 * size], [0.0, 0.0, 1.0]));
                check_that(&format!("plane and triangle of size 2^{exponent}: not hit behind"), beside.is_none());
            }
        }
    }
}

const OCTAHEDRON: &str = "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n\
    f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";

#[test]
fn transforms_of_any_scale_are_right() {
    // All shapes have their nearest point at a distance of 1 in object space, straight ahead.
    for exponent in [-1000, -400, 400, 1000] {
        let scale = f(&power(exponent));
        for (shape, object) in [
            ("sphere", "Sphere { center 0 0 0 radius 1 }"),
            ("plane", "Plane { normal 0 0 2 offset 2 }"),
            ("triangle", "Triangle { vertex0 -1 -1 1 vertex1 1 -1 1 vertex2 0 1 1 }"),
            ("mesh", "TriangleMesh { obj_file m.obj }"),
        ] {
            for mode in modes() {
                let scene = objects(&format!("Transform {{ UniformScale {scale:e} {object} }}"));
                let studio = Studio::with_meshes(&scene, &[("m.obj", OCTAHEDRON)], mode.flags).at(mode);
                let seen = studio.seen(&ray([0.0, 0.0, 4.0 * scale], [0.0, 0.0, -1.0]));
                let case = format!("{shape} in a transform of scale 2^{exponent}");
                let t = seen.depth.map(f64::from);
                check(&format!("{case}: error of t, u"), 16.0, error(t, &(q(3.0) * power(exponent))));
                let [x, y, z] = seen.normal.to_array().map(f64::from);
                let z = if shape == "plane" && !mode.robust() { z.min(1.0) } else { z };
                check(&format!("{case}: error of the normal, u"), 16.0, (x.abs() + y.abs() + (z - 1.0).abs()) / U);
            }
        }
    }
}

/// Makes a scene of every shape, all sizes times 2^`exponent`.
fn scaled_scene(exponent: i32, lamp: &str) -> String {
    let times = |x: f64| format!("{:e}", f(&(q(x) * power(exponent))));
    let at = |x: f64, y: f64, z: f64| format!("{} {} {}", times(x), times(y), times(z));
    format!(
        "PerspectiveCamera {{ center {} direction 0 -0.2 -1 up 0 1 0 angle 40 }}
        Lights {{ numLights 2 {lamp} DirectionalLight {{ direction 1 -2 -1 color 0.3 0.3 0.4 }} }}
        Background {{ color 0.1 0.2 0.4 ambientLight 0.1 0.1 0.1 }}
        Materials {{ numMaterials 2 Material {{ diffuseColor 0.7 0.3 0.2 specularColor 0.5 0.5 0.5 shininess 20 }}
            Material {{ diffuseColor 0.3 0.6 0.3 }} }}
        Group {{ numObjects 5 MaterialIndex 0 Sphere {{ center {} radius {} }}
            Plane {{ normal 0 1 0 offset {} }}
            MaterialIndex 1 Triangle {{ vertex0 {} vertex1 {} vertex2 {} }}
            Transform {{ Translate {} UniformScale {} Scale 1 0.5 2 Sphere {{ center 0 0 0 radius 1 }} }}
            Transform {{ Translate {} UniformScale {} YRotate 30 TriangleMesh {{ obj_file m.obj }} }} }}",
        at(0.0, 1.0, 8.0),
        at(-1.2, 0.5, 0.0),
        times(1.0),
        times(-0.7),
        at(0.5, -0.5, -2.0),
        at(2.5, -0.5, -2.0),
        at(1.5, 2.0, -3.0),
        at(0.6, 0.1, 1.0),
        times(0.5),
        at(1.8, 0.3, 0.5),
        times(0.75),
    )
}

#[test]
fn a_scene_scaled_by_a_power_of_two_is_the_same_picture() {
    let film = |exponent: i32, has_falloff: bool, flags: &str| -> Film {
        let flags = format!("-size 48 32 -shadows -bounces 4 -robust {flags}");
        let lamp = if has_falloff {
            let [x, y, z, falloff] = [(2.0, 1), (4.0, 1), (3.0, 1), (0.05, -2)]
                .map(|(number, dimension)| f(&(q(number) * power(dimension * exponent))));
            format!("PointLight {{ position {x:e} {y:e} {z:e} color 0.9 0.8 0.7 falloff {falloff:e} }}")
        } else {
            "DirectionalLight { direction -1 -3 -2 color 0.9 0.8 0.7 }".to_owned()
        };
        Studio::with_meshes(&scaled_scene(exponent, &lamp), &[("m.obj", OCTAHEDRON)], &flags).film()
    };
    for flags in ["", "-plain"] {
        for exponent in [-900, -500, -300, -126, -64, 64, 126, 300, 500, 900] {
            // A falloff of 2^1800 is no number.
            let has_falloff = i32::abs(exponent) <= 500;
            let (usual, scaled) = (film(0, has_falloff, flags), film(exponent, has_falloff, flags));
            let colors: std::collections::BTreeSet<_> = usual.color.as_ref().unwrap().chunks(3).collect();
            assert!(colors.len() > 200, "{}", colors.len());
            check_that(
                &format!("scene scaled by 2^{exponent}: the same picture"),
                scaled.color == usual.color && scaled.normals == usual.normals,
            );
        }
    }
}

/// Makes a scene of a floor under one light, with ambient light of 1/4.
fn floor(material: &str, light: &str) -> String {
    format!(
        "{CAMERA}Lights {{ numLights 1 {light} }} Background {{ color 0 0 0 ambientLight 0.25 0.25 0.25 }}
        Materials {{ numMaterials 1 Material {{ {material} }} }}
        Group {{ numObjects 1 MaterialIndex 0 Plane {{ normal 0 1 0 offset 0 }} }}"
    )
}

#[test]
fn lights_are_right_at_the_ends_of_the_range() {
    // The light is straight above the lit point. Its light has 8 u, and the sum with ambient light is near it.
    for [position, color, falloff] in [
        ["1e200", "1", "1"],
        ["1e200", "1e300", "1e-100"],
        ["1e200", "1e20", "1e-308"],
        ["1e160", "3e-1", "1e-320"],
        ["2", "1e308", "1e308"],
        ["2", "1e-300", "1e-300"],
        ["2", "1", "1e308"],
        ["2", "1e308", "1e-308"],
        ["1e-200", "1e-200", "1e200"],
        ["1e-300", "1e-308", "1e290"],
        ["1e-160", "1", "-1"],
        ["2", "-1e308", "1e308"],
        ["1e307", "1e300", "1e-300"],
    ] {
        let [p, c, k] = [position, color, falloff].map(|number| q(number.parse().unwrap()));
        let exact = q(0.25) + c / (k * &p * &p);
        let light = format!("PointLight {{ position 0 {position} 0 color {color} {color} 0 falloff {falloff} }}");
        for mode in modes() {
            for shadows in ["", "-shadows"] {
                let flags = format!("{} {shadows} -epsilon auto", mode.flags);
                let studio = Studio::new(&floor("diffuseColor 1 1 1", &light), &flags).at(mode);
                let height = 1.0_f64.min(position.parse::<f64>().unwrap() * 0.5);
                let [red, green, blue] = studio.color(&ray([0.0, height, 0.0], [0.0, -1.0, 0.0]));
                let case = format!("light of {color} at {position} with falloff {falloff}");
                check_that(&format!("{case}: none where its colour is 0"), blue == 0.25 && red == green);
                // What is beyond the numbers of a picture file need only be so too.
                let shown = |exact: &Q| (f(exact).abs() > 1e39).then(|| f(exact).signum());
                let is_near = match shown(&exact) {
                    Some(sign) => red * sign > 1e39,
                    None => f(&(q(red) - &exact)).abs() <= 8.0 * U * (1.0 + red.abs()),
                };
                check_that(&format!("{case}: right, or too bright to show"), is_near);
            }
        }
    }
}

#[test]
fn no_light_is_nan_on_the_dark_side() {
    for material in ["diffuseColor 1 1 1", "diffuseColor 10 1e200 0 specularColor 1 0 1e200 shininess 3"] {
        for light in [
            "PointLight { position 0 -2 0 color 0.5 1e-300 1 }",
            "PointLight { position 0 -2 0 color 1e308 1e308 1e308 falloff 1e-320 }",
            "PointLight { position 0 -1e-308 0 color 1 1 1 falloff 1 }",
            "DirectionalLight { direction 0 1 0 color 1e308 1e308 1e308 }",
        ] {
            for mode in modes() {
                let studio = Studio::new(&floor(material, light), mode.flags).at(mode);
                // Looked at along the floor, so that the highlight is elsewhere.
                let seen = studio.color(&ray([-1.0, 0.1, 0.0], [1.0, -0.1, 0.0]));
                let ambient = studio.scene.materials[0].diffuse.to_array().map(|c| 0.25 * f64::from(c));
                let case = format!("{light} below a floor: no NaN");
                check_that(&case, seen.iter().all(|c| !c.is_nan()));
                if !material.contains("specular") {
                    check_that(&format!("{light} below a floor: ambient light"), seen == ambient);
                }
            }
        }
    }
}

#[test]
fn a_highlight_that_overflows_is_no_nan() {
    // The mirrored ray is 199 times as long as the ray where the normal is 10 long, and 199^1000 is no number.
    let light = "DirectionalLight { direction 0 -1 0 color 0.5 0.5 0.5 }";
    for (specular, is_bright) in [("0 0 0", false), ("1 0 0", true)] {
        let scene = floor(&format!("diffuseColor 0.5 0.5 0.5 specularColor {specular} shininess 1000"), light);
        let scene = scene.replace("normal 0 1 0", "normal 0 10 0");
        for mode in modes().filter(|mode| !mode.robust()) {
            let studio = Studio::new(&scene, &format!("-size 1 1 {}", mode.flags)).at(mode);
            let [red, green, blue] = studio.color(&ray([0.0, 1.0, 0.0], [0.0, -1.0, 0.0]));
            check_that("highlight that overflows: only where the surface shines", (red > 1e30) == is_bright);
            check_that("highlight that overflows: the rest as without it", green == 2.625 && blue == green);
        }
    }
}

#[test]
fn a_light_without_falloff_is_white_whatever_its_colour() {
    for color in ["1 1 1", "1e-300 1e-300 1e-300", "1e308 1 1e-320"] {
        let light = format!("PointLight {{ position 0 2 0 color {color} }}");
        for mode in modes() {
            let studio = Studio::new(&floor("diffuseColor 0.5 0.5 0.5", &light), mode.flags).at(mode);
            let seen = studio.color(&ray([0.0, 1.0, 0.0], [0.0, -1.0, 0.0]));
            check_that(&format!("falloff 0 and colour {color}: white"), seen.iter().all(|&c| c > 1.0));
        }
    }
}
