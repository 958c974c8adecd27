//! The wide renderer and `-plain`, which traces one ray at a time by the definition in `src/trace.rs`, give the same
//! pictures to the bit, before anything is rounded to bytes.

use crate::support::{Folder, batch, options_of_numbers, project};
use a2::film::Film;
use a2::options::Options;
use a2::simd::InstructionSet;
use std::path::Path;

/// Flags that change rays or samples.
const FLAGS: [&str; 14] = [
    "",
    "-shadows",
    "-bounces 4",
    "-bounces 4 -shadows",
    "-jitter",
    "-filter",
    "-jitter -filter -bounces 2 -shadows",
    "-robust -bounces 4 -shadows",
    "-epsilon auto -bounces 4 -shadows",
    "-epsilon 1e-4 -bounces 4 -shadows",
    "-robust -epsilon 0.02 -bounces 3 -shadows",
    "-samples 5 -sampler sobol -bounces 1 -seed 7 -stats",
    "-samples 3 -sampler independent -filter -stats",
    "-target-error 4 -bounces 2 -shadows",
];

fn options(scene: &Path, flags: &str) -> Options {
    let pictures = "-output c.png -normals n.png -depth 8 18 d.png";
    options_of_numbers(&format!("-input {} {pictures} -size 33 21 -quiet {flags}", scene.display()))
}

/// Returns the bits of all planes.
fn bits(film: &Film) -> [Option<Vec<u32>>; 4] {
    let bytes = |plane: &Option<Vec<u8>>| plane.as_ref().map(|plane| plane.iter().map(|&b| b.into()).collect());
    let linear = film.linear.as_ref().map(|plane| plane.iter().map(|number| number.to_bits()).collect());
    [linear, bytes(&film.color), bytes(&film.normals), bytes(&film.depth)]
}

/// Renders with `-plain` and with every instruction set, and compares.
fn check(scene: &Path, flags: &str) {
    let mut plain = options(scene, flags);
    plain.plain = true;
    let expected = a2::render_scene(&plain).unwrap();
    assert!(expected.frame.film.linear.is_some());
    for set in InstructionSet::available() {
        let wide = Options { simd: set, plain: false, ..plain.clone() };
        let found = a2::render_scene(&wide).unwrap();
        assert!(bits(&found.frame.film) == bits(&expected.frame.film), "{} {flags}: {set}", scene.display());
        assert_eq!(found.frame.counts, expected.frame.counts, "{} {flags}: {set}", scene.display());
    }
}

#[test]
fn plain_and_wide_pictures_are_the_same_to_the_bit() {
    for scene in batch::scenes() {
        for flags in FLAGS {
            check(&project("data").join(format!("{}.txt", scene.name)), flags);
        }
    }
}

/// Forty objects need the tree of objects: spheres, stretched and turned ones, triangles, and a plane. Of the seven lights, most
/// shine on the far side of most surfaces.
#[test]
fn plain_and_wide_pictures_of_many_objects_are_the_same_to_the_bit() {
    let mut objects = String::new();
    for i in 0..40 {
        let (x, y, z) = (i % 7 - 3, i / 7 - 3, (i * 5) % 4 - 2);
        let ball = format!("Sphere {{ center 0 0 0 radius 0.{} }}", 3 + i % 5);
        objects += &format!("MaterialIndex {} ", i % 3);
        objects += &match i % 4 {
            0 => format!("Sphere {{ center {x} {y} {z} radius 0.5 }}\n"),
            1 => format!("Transform {{ Translate {x} {y} {z} Scale 1 0.4 1.5 {ball} }}\n"),
            2 => format!("Transform {{ Translate {x} {y} {z} YRotate {} {ball} }}\n", 10 * i),
            _ => format!("Triangle {{ vertex0 {x} {y} {z} vertex1 {x} {y} 4 vertex2 0 {x} {y} }}\n"),
        };
    }
    let scene = format!(
        "PerspectiveCamera {{ center 0 0 14 direction 0 0 -1 up 0 1 0 angle 30 }}
        Lights {{ numLights 7 PointLight {{ position 4 6 5 color 1 0.9 0.8 falloff 0.01 }}
            DirectionalLight {{ direction 1 -1 -1 color 0.4 0.5 0.6 }}
            PointLight {{ position 0 0 0 color 1 1 1 }}
            DirectionalLight {{ direction 0.1 0.2 1 color 0 0.5 0.6 }} DirectionalLight {{ direction 0 1 0 color 1 0 1 }}
            PointLight {{ position 0 -9 -30 color 1 1 1 falloff 0.01 }} PointLight {{ position 9 -9 0 color 1 0 0 falloff 0.1 }} }}
        Background {{ color 0.2 0.1 0.4 ambientLight 0.1 0.1 0.1 }}
        Materials {{ numMaterials 3 Material {{ diffuseColor 1 0.2 0.1 specularColor 1 1 1 shininess 20 }}
            Material {{ diffuseColor 0.1 0.5 0.1 shininess 2.5 }} Material {{ specularColor 0.9 1.3 0.8 }} }}
        Group {{ numObjects 41 MaterialIndex 0 Plane {{ normal 0 2 0 offset -8 }}
        {objects} }}"
    );
    let folder = Folder::new();
    folder.write("s.txt", scene);
    // The third light does not fade, so no number of samples reaches a target error.
    for flags in FLAGS.into_iter().filter(|flags| !flags.contains("-target-error")) {
        check(&folder.path("s.txt"), flags);
    }
}

/// The box around the first sphere is not finite. Found by fuzzing.
#[test]
fn plain_and_wide_pictures_of_an_object_without_finite_bounds_are_the_same_to_the_bit() {
    let folder = Folder::new();
    folder.write(
        "s.txt",
        "PerspectiveCamera { center 5 3 90 direction 0 0 1 up 0 1 0 angle 26 }
        Lights { numLights 1 DirectionalLight { direction -1 -1 0 color 0.6 0.5 0.4 } }
        Materials { numMaterials 1 Material { diffuseColor 0.4 0.2 0.2 specularColor 0.7 1 0.6 shininess 2 } }
        Group { numObjects 2 MaterialIndex 0
            Transform { Scale 15 17 1.4e308 Sphere { center 0 -6 0 radius 4.8 } } Sphere { center 5 3 120 radius 2 } }",
    );
    for flags in ["", "-bounces 3 -shadows", "-robust -bounces 2"] {
        check(&folder.path("s.txt"), flags);
    }
}

/// Sizes, transforms and lights near the ends of the range of numbers.
#[test]
fn plain_and_wide_pictures_of_extreme_numbers_are_the_same_to_the_bit() {
    let lamp = |position: &str, falloff: &str| {
        format!("PointLight {{ position {position} color 1e30 1 1e-300 falloff {falloff} }}")
    };
    let mirror = "MaterialIndex 0 Plane { normal 0 1 0 offset -1 }";
    for (objects, light) in [
        (format!("Sphere {{ center 0 0 0 radius 1e100 }} {mirror}"), lamp("3e200 4e200 1e200", "1e-308")),
        ("Sphere { center 0 0 2 radius 1e-300 } Sphere { center 0 0 0 radius 1 }".to_owned(), lamp("0 9 0", "1e-320")),
        (format!("Transform {{ UniformScale 1e-300 Sphere {{ center 0 0 0 radius 9e299 }} }} {mirror}"), lamp("9 9 9", "-1")),
        ("Triangle { vertex0 -1e200 -1e200 -1e200 vertex1 1e200 -1e200 -1e200 vertex2 0 1e200 -1e200 } MaterialIndex 0 Sphere
            { center 1 0 0 radius 1 }".to_owned(), lamp("1e-200 2 1e-200", "0")),
        (format!("Transform {{ Scale 1 1 1e-20 Sphere {{ center 0 0 0 radius 1 }} }} {mirror}"), lamp("1 1 1", "1e308")),
    ] {
        let scene = format!(
            "PerspectiveCamera {{ center 0.5 0.25 7 direction 0 0 -1 up 0 1 0 angle 30 }}
            Lights {{ numLights 2 {light} DirectionalLight {{ direction -1 -1 -1 color 1e308 0.2 0.5 }} }}
            Background {{ color 0.2 0.1 0.4 ambientLight 0.1 0.1 0.1 }}
            Materials {{ numMaterials 1 Material {{ diffuseColor 0.7 1e-30 3 specularColor 0.5 0 0.5 shininess 9 }} }}
            Group {{ numObjects 2 MaterialIndex 0 {objects} }}"
        );
        for flags in ["", "-robust -bounces 4 -shadows", "-bounces 2 -shadows"] {
            let (_, linear) = colors(&scene, flags);
            assert!(linear.iter().all(|number| !number.is_nan()), "{objects} {flags}");
        }
    }
}

/// Between two mirrors that face each other no path ends: the stack must not grow with `-bounces`.
#[test]
fn a_hundred_thousand_bounces_need_no_stack() {
    let folder = Folder::new();
    folder.write(
        "s.txt",
        "PerspectiveCamera { center 0 0 0 direction 0.3 0.2 -1 up 0 1 0 angle 30 }
        Lights { numLights 1 DirectionalLight { direction 0 0 -1 color 0.1 0.1 0.1 } }
        Materials { numMaterials 1 Material { diffuseColor 0.1 0.1 0.1 specularColor 1 1 1 shininess 5 } }
        Group { numObjects 2 MaterialIndex 0 Plane { normal 0 0 1 offset -1 } Plane { normal 0 0 -1 offset -1 } }",
    );
    let mut options = options(&folder.path("s.txt"), "-bounces 100000");
    (options.width, options.height, options.plain) = (2, 1, true);
    let plain = a2::render_scene(&options).unwrap().frame;
    options.plain = false;
    let wide = a2::render_scene(&options).unwrap().frame;
    assert_eq!(plain.counts.mirror, 200_000);
    assert_eq!(plain.counts, wide.counts);
    assert!(bits(&plain.film) == bits(&wide.film));
}

/// Returns the colours of a scene in every way of rendering it; they are the same to the bit.
fn colors(scene: &str, flags: &str) -> (Vec<u8>, Vec<f32>) {
    let folder = Folder::new();
    folder.write("s.txt", scene);
    check(&folder.path("s.txt"), flags);
    let film = a2::render_scene(&options(&folder.path("s.txt"), flags)).unwrap().frame.film;
    (film.color.unwrap(), film.linear.unwrap())
}

/// Between two mirrors that brighten, the throughput outgrows every number. Without lights, ambient light is 1, and a path of n
/// mirrors shows a (1 + s + ... + s^n), with a the diffuse and s the specular colour.
#[test]
fn a_mirror_path_that_overflows_is_huge_and_no_nan() {
    let scene = |specular: &str| {
        format!(
            "PerspectiveCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 angle 10 }}
            Background {{ color 0 0 0 }}
            Materials {{ numMaterials 1 Material {{ diffuseColor 0.25 0.25 0 specularColor {specular} }} }}
            Group {{ numObjects 2 MaterialIndex 0 Plane {{ normal 0 0 1 offset -5 }}
                Plane {{ normal 0 0 -1 offset -5 }} }}"
        )
    };
    let huge = f32::INFINITY;
    for (specular, bounces, bytes, numbers) in [
        ("1.5 0.5 1.5", 1800, [255, 127, 0], [huge, 0.5, 0.0]),
        ("-1.5 0 1.5", 1800, [255, 63, 0], [huge, 0.25, 0.0]),
        ("-1.5 -1.5 1.5", 1801, [0, 0, 0], [-huge, -huge, 0.0]),
        ("1e300 1.5 1e300", 1800, [255, 255, 0], [huge, huge, 0.0]),
    ] {
        let (color, linear) = colors(&scene(specular), &format!("-bounces {bounces}"));
        assert!(color.as_chunks().0.iter().all(|&pixel| pixel == bytes), "{specular}: {:?}", &color[..3]);
        assert!(linear.as_chunks().0.iter().all(|&pixel| pixel == numbers), "{specular}: {:?}", &linear[..3]);
        assert_eq!(color.len(), 3 * 33 * 21);
    }
}

/// A light above a sphere that does not fade: white where it shines, ambient light on the dark side.
#[test]
fn a_light_without_falloff_leaves_the_dark_side_to_ambient_light() {
    for (material, highlight) in [("", 0.0), ("specularColor 0.3 0.3 0.3 shininess 5", 0.3)] {
        let scene = format!(
            "PerspectiveCamera {{ center 0 0 10 direction 0 0 -1 up 0 1 0 angle 8 }}
            Lights {{ numLights 1 PointLight {{ position 0 5 0 color 0.5 0.5 0.5 falloff 0 }} }}
            Background {{ color 0 0 1 ambientLight 0.25 0.125 0.5 }}
            Materials {{ numMaterials 1 Material {{ diffuseColor 0.5 0.5 0.5 {material} }} }}
            Group {{ numObjects 1 MaterialIndex 0 Sphere {{ center 0 0 0 radius 1 }} }}"
        );
        for flags in ["", "-robust", "-shadows"] {
            let (_, linear) = colors(&scene, flags);
            let pixels: &[[f32; 3]] = linear.as_chunks().0;
            let count = |color: [f32; 3]| pixels.iter().filter(|&&pixel| pixel == color).count();
            let (lit, dark) = (count([f32::INFINITY; 3]), count([0.125, 0.0625, 0.25]));
            assert!(lit > 200 && dark > 200, "{highlight} {flags}: {lit} lit, {dark} dark");
            assert_eq!(lit + dark, pixels.len(), "{highlight} {flags}");
        }
    }
}
