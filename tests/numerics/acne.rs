//! Convex bodies in full light: every point that faces the light is lit, at every scale. A dark point there is acne.

use super::leaks::ball;
use super::support::{Mode, Random, Studio, check, modes, vector};
use a2::objects::Ray;

const SCALES: [(&str, f64); 7] =
    [("1e-6", 1e-6), ("1e-4", 1e-4), ("1e-2", 1e-2), ("1", 1.0), ("1e3", 1e3), ("1e6", 1e6), ("1e9", 1e9)];

/// Sends 4,000 rays at a convex body of about this scale. Counts the points that face the light but are not lit, and
/// the points that face away but are lit.
fn wrong(body: &str, scale: f64, center: [f64; 3], mode: Mode) -> u32 {
    let [x, y, z] = [0.48, 0.6, 0.64];
    let scene = format!(
        "{}Lights {{ numLights 1 DirectionalLight {{ direction {} {} {} color 1 1 1 }} }}
        Materials {{ numMaterials 1 Material {{ diffuseColor 1 1 1 }} }}
        Group {{ numObjects 1 MaterialIndex 0 {body} }}",
        super::support::CAMERA,
        -x,
        -y,
        -z
    );
    let ball = ball(3, 0);
    let meshes = [("ball.obj", ball.as_str()), ("cube.obj", CUBE)];
    let studio = Studio::with_meshes(&scene, &meshes, &format!("-shadows {}", mode.flags)).at(mode);
    let mut random = Random(21);
    let (mut wrong, mut towards, mut away_from) = (0, 0, 0);
    for _ in 0..4000 {
        let to = [0, 1, 2].map(|i| center[i] + scale * 0.5 * random.signed());
        let away = random.unit();
        let from = [0, 1, 2].map(|i| center[i] + scale * 4.0 * away[i]);
        let ray = Ray { origin: vector(from), direction: (vector(to) - vector(from)).normalized() };
        let Some(hit) = studio.hit(&ray) else { continue };
        // The normal of the face decides whether a point faces the light, not the smooth normal.
        let surface = studio.surface_point(&ray, &hit);
        let outward = if surface.normal.dot(ray.direction) > 0.0 { -surface.normal } else { surface.normal };
        let (facing, shaded) = (outward.dot(vector([x, y, z])), studio.seen(&ray).normal.dot(vector([x, y, z])));
        let lit = studio.color(&ray)[0] > 0.0;
        // Within 1e-6 of a right angle the light grazes the surface, and both results are right.
        if facing > 1e-6 && shaded > 1e-6 {
            towards += 1;
            wrong += u32::from(!lit);
        } else if facing < -1e-6 && mode.robust() {
            // The starter lights a point that faces away if its offset of 0.01 leads out of the body, or through a
            // plane.
            away_from += 1;
            wrong += u32::from(lit);
        }
    }
    // A test in which nothing is hit would pass.
    assert!(
        towards > 1000 && (away_from > 1000 || !mode.robust()),
        "{towards} points face the light, {away_from} do not"
    );
    wrong
}

const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 4 8 7 3\nf 1 5 8 4\nf 2 3 7 6\n";

/// Checks that there is no acne: with -robust at any scale; by default at the scales where the starter's 0.01 is
/// small against the body and large against rounding.
fn at_every_scale(name: &str, body: impl Fn(f64) -> String, center: impl Fn(f64) -> [f64; 3]) {
    for (case, scale) in SCALES {
        for mode in modes() {
            if mode.robust() || (1.0..1e4).contains(&scale) {
                let rays = if mode.robust() { "-robust" } else { "the starter's rays" };
                let wrong = wrong(&body(scale), scale, center(scale), mode);
                check(&format!("{name} of size {case}, {rays}: acne in 4,000 points"), 0.0, f64::from(wrong));
            }
        }
    }
}

#[test]
fn lit_spheres_have_no_acne() {
    at_every_scale("lit sphere", |scale| format!("Sphere {{ center 0 0 0 radius {scale:e} }}"), |_| [0.0; 3]);
}

#[test]
fn lit_spheres_away_from_the_origin_have_no_acne() {
    at_every_scale(
        "lit sphere 1000 radii from the origin",
        |scale| format!("Sphere {{ center {:e} {:e} 0 radius {scale:e} }}", 1e3 * scale, -1e3 * scale),
        |scale| [1e3 * scale, -1e3 * scale, 0.0],
    );
}

#[test]
fn lit_spheres_in_transforms_have_no_acne() {
    at_every_scale(
        "lit sphere, turned and stretched,",
        |scale| {
            format!(
                "Transform {{ UniformScale {scale:e} Rotate {{ 1 2 3 40 }} Scale 1 0.5 0.8 Sphere {{ center 0 0 0 radius 1 }} }}"
            )
        },
        |_| [0.0; 3],
    );
}

#[test]
fn lit_meshes_have_no_acne() {
    at_every_scale(
        "lit mesh of 512 faces",
        |scale| format!("Transform {{ UniformScale {scale:e} TriangleMesh {{ obj_file ball.obj }} }}"),
        |_| [0.0; 3],
    );
}

#[test]
fn lit_boxes_have_no_acne() {
    at_every_scale(
        "lit box, turned,",
        |scale| {
            format!(
                "Transform {{ Rotate {{ 3 1 2 70 }} UniformScale {scale:e} TriangleMesh {{ obj_file cube.obj }} }}"
            )
        },
        |_| [0.0; 3],
    );
}

#[test]
fn lit_boxes_far_from_the_origin_have_no_acne() {
    at_every_scale(
        "lit box 1e6 sizes from the origin",
        |scale| {
            format!(
                "Transform {{ Translate {:e} 0 {:e} UniformScale {scale:e} TriangleMesh {{ obj_file cube.obj }} }}",
                1e6 * scale,
                1e6 * scale
            )
        },
        |scale| [1e6 * scale, 0.0, 1e6 * scale],
    );
}

#[test]
fn lit_separate_triangles_have_no_acne() {
    // A tetrahedron of four Triangle objects.
    let body = |s: f64| {
        let p = [[s, s, s], [s, -s, -s], [-s, s, -s], [-s, -s, s]];
        let face = |i: [usize; 3]| {
            let corner = |k: usize| {
                let [x, y, z] = p[i[k]];
                format!("vertex{k} {x:e} {y:e} {z:e} ")
            };
            format!("Triangle {{ {}{}{} }} ", corner(0), corner(1), corner(2))
        };
        format!(
            "Group {{ numObjects 4 {}{}{}{} }}",
            face([0, 1, 2]),
            face([0, 3, 1]),
            face([0, 2, 3]),
            face([1, 3, 2])
        )
    };
    at_every_scale("lit tetrahedron of separate triangles", body, |_| [0.0; 3]);
}

#[test]
fn lit_planes_have_no_acne() {
    // A plane is lit at every point that is seen from the light's side.
    let body = |s: f64| format!("Plane {{ normal 0.36 0.48 0.8 offset {:e} }}", 0.3 * s);
    at_every_scale("lit plane at a slant", body, |_| [0.0; 3]);
}
