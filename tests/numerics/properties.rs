//! Properties of random scenes over 18 orders of magnitude.

use super::exact::{Q, V, cross, dot, f, length, q, sub, v};
use super::support::{CAMERA, Studio, check, objects, vector};
use a2::objects::{Ray, SurfacePoint};
use num_traits::Signed as _;
use proptest::prelude::*;

fn magnitude() -> impl Strategy<Value = f64> {
    (-9.0..9.0_f64).prop_map(|power| 10_f64.powf(power))
}

fn point() -> impl Strategy<Value = [f64; 3]> {
    [-1.0..1.0_f64, -1.0..1.0, -1.0..1.0]
}

/// A unit vector. A constant is added to points near zero, which have no good direction.
fn unit() -> impl Strategy<Value = [f64; 3]> {
    point().prop_map(|p| {
        let p = [p[0] + 1e-3, p[1], p[2]];
        let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        p.map(|x| x / length)
    })
}

fn scaled(p: [f64; 3], scale: f64) -> [f64; 3] {
    p.map(|x| x * scale)
}

fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] + b[i])
}

fn words(p: [f64; 3]) -> String {
    format!("{:e} {:e} {:e}", p[0], p[1], p[2])
}

/// Makes a ray to `target` from a distance of `distance`.
fn ray_to(target: [f64; 3], from: [f64; 3], distance: f64) -> Ray {
    let origin = vector(sum(target, scaled(from, distance)));
    Ray { origin, direction: (vector(target) - origin).normalized() }
}

/// Checks a surface point: it is off the surface by at most its error bound; ray origins on either side are on that
/// side by exact arithmetic; and rays that leave from there do not hit the surface again. `height` is the exact
/// height of a point over the surface (its sign is the side), to first order.
fn check_surface_point(
    case: &str,
    studio: &Studio,
    surface: &SurfacePoint,
    height: impl Fn(&V) -> Q,
    convex: bool,
) {
    let error_bound = q(f64::from(surface.error_bound));
    let off = height(&v(surface.point)).abs();
    check(
        &format!("{case}: distance of the point from the surface, of its error bound"),
        1.0,
        f(&(off / &error_bound)),
    );
    for side in [-1.0, 1.0_f64] {
        let direction = surface.normal * side as vecmath::Real;
        let origin = surface.beside(direction);
        let wrong = (height(&v(origin)) * q(side)) <= q(0.0);
        check(&format!("{case}: origins on the wrong side"), 0.0, f64::from(u8::from(wrong)));
        if side > 0.0 || !convex {
            // A ray along the normal, and one along the surface.
            let along = surface.normal.cross(vector([0.3, 0.5, -0.8])).normalized();
            for slope in [1.0, 1e-2, 1e-6] {
                let leaving = Ray { origin, direction: (direction * slope + along).normalized() };
                let again = studio.hit(&leaving).is_some();
                check(&format!("{case}: rays that meet the surface they leave"), 0.0, f64::from(u8::from(again)));
            }
        }
    }
}

/// Runs a test for 150 rays that hit. A miss does not count as a case; too many misses make the test fail.
fn hits() -> ProptestConfig {
    ProptestConfig { cases: 150, max_global_rejects: 150, failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(hits())]

    #[test]
    fn points_of_spheres(
        radius in magnitude(), away in magnitude(), center in point(), inside in point(), from in unit(), distance in 1.5..1e4_f64,
    ) {
        let center = scaled(center, away);
        // A sphere must be larger than the rounding of its centre.
        prop_assume!(radius > away * 1e-12);
        let studio = Studio::new(&objects(&format!("Sphere {{ center {} radius {radius:e} }}", words(center))), "");
        let ray = ray_to(sum(center, scaled(inside, 0.5 * radius)), from, distance * radius);
        let hit = studio.hit(&ray).ok_or_else(|| TestCaseError::reject("a miss"))?;
        let surface = studio.surface_point(&ray, &hit);
        let height = |p: &V| length(&sub(p, &v(vector(center)))) - q(f64::from(radius as vecmath::Real));
        check_surface_point("random sphere", &studio, &surface, height, true);
    }

    #[test]
    fn points_of_planes(normal in unit(), long in magnitude(), offset in magnitude(), side in unit(), from in unit(), distance in magnitude()) {
        let given = scaled(normal, long);
        let studio = Studio::new(&objects(&format!("Plane {{ normal {} offset {:e} }}", words(given), offset * long)), "");
        let foot = scaled(normal, offset);
        let ray = ray_to(sum(foot, scaled(side, 0.1 * offset)), from, distance);
        let hit = studio.hit(&ray).ok_or_else(|| TestCaseError::reject("a miss"))?;
        let surface = studio.surface_point(&ray, &hit);
        let n = v(vector(given));
        let of_unit = length(&n);
        let height = |p: &V| (dot(&n, p) - q(f64::from((offset * long) as vecmath::Real))) / &of_unit;
        check_surface_point("random plane", &studio, &surface, height, false);
    }

    #[test]
    fn points_of_triangles(
        size in magnitude(), away in magnitude(), center in point(), a in point(), b in point(), c in point(),
        weights in [0.01..1.0_f64, 0.01..1.0, 0.01..1.0], from in unit(), distance in 0.1..1e4_f64,
    ) {
        prop_assume!(size > away * 1e-10);
        let center = scaled(center, away);
        let corners = [a, b, c].map(|corner| sum(center, scaled(corner, size)));
        let exact = corners.map(|corner| v(vector(corner)));
        let normal = cross(&sub(&exact[1], &exact[0]), &sub(&exact[2], &exact[0]));
        let long = length(&normal);
        // Slivers have tests of their own. Here the aspect is at most about a thousand.
        prop_assume!(f(&long) > 1e-3 * size * size);
        let text = format!("Triangle {{ vertex0 {} vertex1 {} vertex2 {} }}", words(corners[0]), words(corners[1]), words(corners[2]));
        let studio = Studio::new(&objects(&text), "");
        let total: f64 = weights.iter().sum();
        let target = [0, 1, 2].map(|i| (0..3).map(|k| weights[k] / total * corners[k][i]).sum::<f64>());
        let ray = ray_to(target, from, distance * size);
        let hit = studio.hit(&ray).ok_or_else(|| TestCaseError::reject("a miss"))?;
        let surface = studio.surface_point(&ray, &hit);
        let height = |p: &V| dot(&normal, &sub(p, &exact[0])) / &long;
        check_surface_point("random triangle", &studio, &surface, height, false);
    }

    #[test]
    fn points_of_transformed_spheres(
        size in magnitude(), away in magnitude(), center in point(), axis in unit(), degrees in -180.0..180.0_f64,
        stretch in [-2.0..2.0_f64, -2.0..2.0, -2.0..2.0], inside in point(), from in unit(),
    ) {
        prop_assume!(size > away * 1e-8);
        let center = scaled(center, away);
        let stretch = stretch.map(|power| size * 10_f64.powf(power));
        let text = format!(
            "Transform {{ Translate {} Rotate {{ {} {degrees:e} }} Scale {} Sphere {{ center 0 0 0 radius 1 }} }}",
            words(center), words(axis), words(stretch),
        );
        let studio = Studio::new(&objects(&text), "");
        let transform = studio.scene.geometry.objects[0].transform.clone().unwrap();
        // The surface is the set of points that the rounded inverse takes to the unit sphere. The height over it in
        // world space is the height in object space, divided by the length of the transformed normal.
        let columns = transform.object_from_world.columns.map(|c| [c.x, c.y, c.z].map(|x| q(f64::from(x))));
        let image = |p: &V| -> V {
            [0, 1, 2].map(|i| &columns[0][i] * &p[0] + &columns[1][i] * &p[1] + &columns[2][i] * &p[2] + &columns[3][i])
        };
        let shortest = stretch.into_iter().fold(f64::INFINITY, f64::min);
        let ray = ray_to(sum(center, scaled(inside, 0.2 * shortest)), from, 4.0 * size * 100.0);
        let hit = studio.hit(&ray).ok_or_else(|| TestCaseError::reject("a miss"))?;
        let surface = studio.surface_point(&ray, &hit);
        let at = v(surface.point);
        let local = image(&at);
        let back = [0, 1, 2].map(|k| dot(&local, &columns[k]));
        let per_world_unit = length(&back) / length(&local);
        let height = |p: &V| (length(&image(p)) - q(1.0)) / &per_world_unit;
        check_surface_point("random transformed sphere", &studio, &surface, height, true);
    }
}

/// Makes a scene of spheres, a floor and triangles, at a scale and in an order.
fn still_life(scale: f64, reversed: bool) -> String {
    let s = |x: f64| format!("{:e}", x * scale);
    let mut members = [
        format!("Sphere {{ center {} {} {} radius {} }}", s(-1.0), s(0.5), s(0.25), s(0.5)),
        format!("Sphere {{ center {} {} {} radius {} }}", s(0.75), s(0.25), s(0.5), s(0.25)),
        format!("Plane {{ normal 0 1 0 offset {} }}", s(-0.125)),
        format!(
            "Triangle {{ vertex0 {} {} {} vertex1 {} {} {} vertex2 {} {} {} }}",
            s(0.0),
            s(0.0),
            s(-1.0),
            s(1.5),
            s(0.0),
            s(-0.75),
            s(0.5),
            s(1.5),
            s(-0.5)
        ),
        format!(
            "Transform {{ Translate {} {} {} YRotate 30 Scale {} {} {} Sphere {{ center 0 0 0 radius 1 }} }}",
            s(-0.25),
            s(0.25),
            s(1.0),
            s(0.25),
            s(0.125),
            s(0.5)
        ),
        format!("Sphere {{ center {} {} {} radius {} }}", s(0.125), s(1.25), s(-1.5), s(0.5)),
    ];
    if reversed {
        members.reverse();
    }
    format!(
        "PerspectiveCamera {{ center {} {} {} direction 0 -0.125 -1 up 0 1 0 angle 40 }}
        Lights {{ numLights 2 DirectionalLight {{ direction -0.5 -1 -0.25 color 0.5 0.5 0.5 }}
            PointLight {{ position {} {} {} color 1 1 0.5 falloff {:e} }} }}
        Background {{ color 0.25 0.25 0.5 ambientLight 0.125 0.125 0.125 }}
        Materials {{ numMaterials 1 Material {{ diffuseColor 0.5 0.75 1 specularColor 0.25 0.25 0.25 shininess 16 }} }}
        Group {{ numObjects 6 MaterialIndex 0 {} }}",
        s(0.0), s(0.75), s(5.0), s(2.0), s(4.0), s(3.0), 0.125 / scale / scale, members.join("\n")
    )
}

#[test]
fn a_rescaled_scene_gives_the_same_picture() {
    // A power of two changes no rounding anywhere, so all bytes are equal.
    let film =
        |scale: f64| Studio::new(&still_life(scale, false), "-size 60 45 -shadows -bounces 4 -robust").film();
    let usual = film(1.0);
    for power in [-30, -20, -3, 10, 30] {
        let other = film(2_f64.powi(power));
        let differing =
            usual.color.iter().flatten().zip(other.color.iter().flatten()).filter(|(a, b)| a != b).count();
        check(&format!("scene scaled by 2^{power}, -robust: bytes that change"), 0.0, differing as f64);
    }
    // The starter's 0.01 is another share of the scene, which changes the picture.
    let starters =
        |scale: f64| Studio::new(&still_life(scale, false), "-size 60 45 -shadows -bounces 4").film().color;
    assert_ne!(starters(1.0), starters(2_f64.powi(-10)));
}

#[test]
fn a_permuted_scene_gives_the_same_picture() {
    for flags in ["", "-robust"] {
        let film = |reversed| {
            Studio::new(&still_life(1.0, reversed), &format!("-size 60 45 -shadows -bounces 4 {flags}")).film()
        };
        let (a, b) = (film(false), film(true));
        let same = a.color == b.color && a.normals == b.normals && a.depth == b.depth;
        check("scene with its objects in reverse: pictures that change", 0.0, f64::from(u8::from(!same)));
    }
}

#[test]
fn a_moved_scene_gives_the_same_picture_up_to_rounding() {
    // After a translation by 2^12 points are rounded to 2^-41 instead of 2^-53. Colours change by up to 1e-12 / 1e-2
    // where a highlight is steep: one byte in a million changes by a level. At the edge of a shadow or of an object a
    // pixel may change completely.
    let scene = |shift: f64| {
        let text = format!(
            "{}Lights {{ numLights 1 DirectionalLight {{ direction -0.5 -1 -0.25 color 0.75 0.75 0.75 }} }}
            Materials {{ numMaterials 1 Material {{ diffuseColor 0.5 0.75 1 specularColor 0.25 0.25 0.25 shininess 16 }} }}
            Group {{ numObjects 2 MaterialIndex 0 Sphere {{ center {1:e} {2:e} {1:e} radius 0.5 }}
                Sphere {{ center {3:e} {1:e} {1:e} radius 0.75 }} }}",
            CAMERA.replace("center 0 0 5", &format!("center {:e} {:e} {:e}", shift, shift, shift + 5.0)),
            shift, shift + 0.75, shift - 0.5,
        );
        Studio::new(&text, "-size 100 100 -shadows -bounces 2 -robust").film().color.unwrap()
    };
    let (here, there) = (scene(0.0), scene(4096.0));
    let differing = here.iter().zip(&there).filter(|(a, b)| a.abs_diff(**b) > 0).count();
    check("scene moved by 2^12, -robust: bytes of 30,000 that change", 3.0, differing as f64);
}
