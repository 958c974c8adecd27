//! The bound of the brightness of a scene: no ray sees more, and some see nearly as much.

use super::support::{CAMERA, Random, Studio, U, ray};

fn scene(materials: &str, lights: &str, objects: &str) -> String {
    let count = |text: &str, words: &[&str]| words.iter().map(|word| text.matches(word).count()).sum::<usize>();
    let (materials_count, lights_count) =
        (count(materials, &["Material {"]), count(lights, &["PointLight {", "DirectionalLight {"]));
    let objects_count = count(objects, &["Sphere {", "Plane {", "Triangle {"]);
    format!(
        "{CAMERA}Background {{ color 0 0 0 ambientLight 0.25 0 0 }} Lights {{ numLights {lights_count} {lights} }}
         Materials {{ numMaterials {materials_count} {materials} }}
         Group {{ numObjects {objects_count} MaterialIndex 0 {objects} }}"
    )
}

fn brightest(text: &str, flags: &str) -> Option<f64> {
    let studio = Studio::new(text, flags);
    studio.scene.brightest(&studio.plan)
}

const SPHERE: &str = "Sphere { center 0 0 0 radius 1 }";
const FLOOR: &str = "Plane { normal 0 1 0 offset -1 }";
const MATERIAL: &str = "Material { diffuseColor 0.5 0.25 0 specularColor 0 0.5 0.125 }";

fn lamp(place: &str, falloff: &str) -> String {
    format!("PointLight {{ position {place} color 8 8 8 falloff {falloff} }}")
}

/// Boxes are larger than what is in them by 8192 u, and the light falls with the square of the distance.
const TOLERANCE: f64 = 1e5 * U;

fn assert_bound(case: &str, text: &str, flags: &str, expected: f64) {
    let found = brightest(text, flags).unwrap_or(f64::NAN);
    assert!((found / expected - 1.0).abs() < TOLERANCE, "{case}: {found}, not {expected}");
}

#[test]
fn the_bound_is_what_the_materials_make_of_the_light() {
    let unused = "Material { diffuseColor 90 90 90 }";
    let sun = "DirectionalLight { direction 0 -1 0 color 2 2 2 }";
    // Green is brightest: 2 (0.25 + 0.5). Red has 2 0.5 + 0.25 0.5.
    assert_bound("a sun", &scene(&format!("{MATERIAL} {unused}"), sun, SPHERE), "", 1.5);
    let bright = scene(MATERIAL, sun, SPHERE).replace("color 0 0 0 ambient", "color 0 0 7 ambient");
    assert_bound("a bright background", &bright, "", 7.0);
    // A mirror shows itself at most: 1.5 + 0.5 (1.5 + 0.5 1.5).
    assert_bound("two mirrors", &scene(MATERIAL, sun, SPHERE), "-bounces 2", 1.5 * 1.75);
    // Seen in a weak mirror, the sphere is darker than by itself.
    let weak =
        "Material { diffuseColor 0.5 0.75 0 } Material { diffuseColor 0 0 0 specularColor 0 0.25 0 shininess 9 }";
    let two = scene(weak, sun, &format!("{SPHERE} MaterialIndex 1 {FLOOR}"));
    assert_bound("a sphere and a weak mirror", &two, "-bounces 9", 1.5);
    let grown = scene("Material { diffuseColor 0 0 0 specularColor 9 9 9 }", sun, SPHERE);
    let found = brightest(&grown, "-bounces 100000");
    assert_eq!(found, Some(f64::INFINITY), "mirrors that brighten");
}

#[test]
fn a_point_light_is_bounded_by_its_distance() {
    let white = "Material { diffuseColor 1 1 1 }";
    // The box of the sphere begins 2 below the light. Ambient light adds 0.25.
    assert_bound("a sphere below a lamp", &scene(white, &lamp("0 3 0", "0.5"), SPHERE), "", 4.25);
    assert_bound("a floor below a lamp", &scene(white, &lamp("5 3 0", "0.25"), FLOOR), "", 2.25);
    let moved = format!("Transform {{ Translate 0 1 0 ZRotate 45 Scale 1 3 2 {FLOOR} }}");
    // The plane is 3 from the origin before it moves by 1, of which 1 / sqrt(2) is along its normal.
    let distance = 3.0 - 0.5f64.sqrt();
    let expected = 8.0 / distance.powi(2) + 0.25;
    assert_bound("a floor that is moved", &scene(white, &lamp("0 0 0", "1"), &moved), "", expected);
    for place in ["0 0.5 0", "0.9 0.9 0.9"] {
        assert_eq!(brightest(&scene(white, &lamp(place, "1"), SPHERE), ""), None, "a lamp in the sphere's box");
    }
    assert_eq!(brightest(&scene(white, &lamp("3 -1 4", "1"), FLOOR), ""), None, "a lamp in the floor");
    let long = scene(white, &lamp("0 3 0", "1"), "Plane { normal 0 2 0 offset 0 }");
    assert_eq!(brightest(&long, ""), None, "a normal that is not a unit vector");
    assert_bound("the same, -robust", &long, "-robust", 8.0 / 9.0 + 0.25);
}

#[test]
fn no_ray_sees_more_than_the_bound() {
    let mut random = Random(3);
    let (mut bounded, mut nearest) = (0, 0.0f64);
    for _ in 0..60 {
        let mut numbers = |low: f64, high: f64| {
            let mut number = || low + (high - low) * (0.5 + 0.5 * random.signed());
            format!("{:.3} {:.3} {:.3}", number(), number(), number())
        };
        let materials: String = (0..3)
            .map(|_| {
                format!(
                    "Material {{ diffuseColor {} specularColor {} shininess 4 }} ",
                    numbers(-0.2, 1.0),
                    numbers(0.0, 0.6)
                )
            })
            .collect();
        let lights = format!(
            "PointLight {{ position {} color {} falloff 0.3 }} DirectionalLight {{ direction {} color {} }}",
            numbers(-4.0, 4.0),
            numbers(0.0, 3.0),
            numbers(-1.0, 1.0),
            numbers(-1.0, 1.0)
        );
        let objects = format!(
            "Sphere {{ center {} radius 0.7 }} MaterialIndex 1 Transform {{ Translate {} XRotate 30 Scale 1 0.5 2 Sphere {{ center 0 0 0 radius 1 }} }}
             MaterialIndex 2 Triangle {{ vertex0 {} vertex1 {} vertex2 {} }} {FLOOR}",
            numbers(-2.0, 2.0), numbers(-2.0, 2.0), numbers(-3.0, 3.0), numbers(-3.0, 3.0), numbers(-3.0, 3.0)
        );
        let studio = Studio::new(&scene(&materials, &lights, &objects), "-bounces 3 -shadows");
        let Some(bound) = studio.scene.brightest(&studio.plan) else { continue };
        bounded += 1;
        for _ in 0..500 {
            let (x, y) = (0.5 * random.signed(), 0.5 * random.signed());
            let length = (x * x + y * y + 1.0).sqrt();
            let color = studio.color(&ray([0.0, 0.0, 5.0], [x / length, y / length, -1.0 / length]));
            nearest = color.into_iter().fold(nearest, |nearest, c| nearest.max(c.abs() / bound));
        }
    }
    assert!(bounded > 30 && nearest > 0.3, "{bounded} scenes, {nearest} of the bound");
    assert!(nearest <= 1.0 + TOLERANCE, "{nearest}");
}
