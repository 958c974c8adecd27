//! Unusual numbers in scenes and meshes: each has a documented result.

use super::support::{Studio, check_that, objects};
use a2::scene_file::{Node, TransformStep};

/// Parses a number, here as the angle of a rotation.
fn number(text: &str) -> Result<f64, String> {
    let source = a2::error::SourceText {
        path: "s.txt".into(),
        text: objects(&format!("Transform {{ XRotate {text} Sphere {{ center 0 0 0 radius 1 }} }}")),
    };
    let description = a2::scene_file::parse(source).whole().map_err(|error| error.to_string())?;
    let Node::Group(members) = description.root else { panic!() };
    let Node::Transform { steps, .. } = &members[0] else { panic!() };
    let TransformStep::Rotate { degrees, .. } = steps[0].value else { panic!() };
    Ok(degrees)
}

#[test]
fn finite_numbers_are_read_and_others_refused() {
    let long = format!("0.{}1", "0".repeat(398));
    let digits = format!("1.{}", "3".repeat(400));
    for (case, text, value) in [
        ("1e39", "1e39", 1e39),
        ("1e-320", "1e-320", 1e-320),
        ("1e-400", "1e-400", 0.0),
        ("4.9e-324", "4.9e-324", 5e-324),
        ("1.7976931348623157e308", "1.7976931348623157e308", f64::MAX),
        ("a number of 400 zeros and a one", &long, 0.0),
        ("4/3 with 400 digits", &digits, 4.0 / 3.0),
        ("+.5e+0", "+.5e+0", 0.5),
        ("5.", "5.", 5.0),
        ("0.1 to the last bit", "0.1000000000000000055511151231257827", 0.1),
    ] {
        check_that(&format!("{case}: read"), number(text) == Ok(value));
    }
    let million = format!("1{}", "0".repeat(400));
    for (case, text, reason) in [
        ("nan", "nan", "expected a finite number"),
        ("NaN", "NaN", "expected a finite number"),
        ("inf", "inf", "expected a finite number"),
        ("-infinity", "-infinity", "expected a finite number"),
        ("1e309", "1e309", "too large"),
        ("a one and 400 zeros", &million, "too large"),
        ("0x1p3", "0x1p3", "expected a number"),
        ("1,5", "1,5", "write '1.5'"),
        ("1e", "1e", "expected a number"),
        ("--1", "--1", "expected a number"),
    ] {
        let refused = number(text).is_err_and(|said| said.contains(reason) && said.starts_with("s.txt:4:21: "));
        check_that(&format!("{case}: refused at its place"), refused);
    }
}

#[test]
fn radii_that_are_not_positive_are_refused() {
    for text in ["0", "-1", "-0.0", "1e-400"] {
        let said = Studio::refusal(&objects(&format!("Sphere {{ center 0 0 0 radius {text} }}")));
        check_that(&format!("radius {text}: refused"), said.contains("'radius' must be above 0"));
    }
}

#[test]
fn coordinates_of_meshes_are_read_as_f32() {
    let scene = objects("TriangleMesh { obj_file m.obj }");
    let bounds = |x: &str| {
        let obj = format!("v 0 0 0\nv {x} 0 0\nv 0 1 0\nf 1 2 3\n");
        Studio::with_meshes(&scene, &[("m.obj", &obj)], "").scene.geometry.objects[0].bounds.unwrap().max.x
    };
    check_that("1e-320 in a mesh: 0", f64::from(bounds("1e-320")) < 1e-9);
    check_that("3.4e38 in a mesh: read", f64::from(bounds("3.4e38")) > 3.3e38);
    for text in ["1e39", "nan", "inf"] {
        let obj = format!("v 0 0 0\nv {text} 0 0\nv 0 1 0\nf 1 2 3\n");
        let refused = std::panic::catch_unwind(|| Studio::with_meshes(&scene, &[("m.obj", &obj)], ""));
        check_that(&format!("{text} in a mesh: refused"), refused.is_err());
    }
}

#[test]
fn a_hint_is_given_where_the_starters_ray_offset_does_not_fit() {
    let hints = |radius: &str, flags: &str| {
        let text = objects(&format!("Sphere {{ center 0 0 0 radius {radius} }}")).replace(
            "Materials {",
            "Lights { numLights 1 DirectionalLight { direction 0 -1 0 color 1 1 1 } }\nMaterials {",
        );
        Studio::new(&text, flags).warnings.join("\n")
    };
    check_that(
        "scene of size 0.2 with -shadows: a hint",
        hints("0.1", "-shadows").contains("small") && hints("0.1", "-shadows").contains("-robust"),
    );
    check_that("scene of size 2e6 with -shadows: a hint", hints("1e6", "-shadows").contains("large"));
    check_that("sphere 0.004 across with -shadows: a hint", hints("0.002", "-shadows").contains("thick"));
    check_that("scene of size 10 with -shadows: none", hints("5", "-shadows").is_empty());
    check_that("scene of size 0.2 without shadows: none", hints("0.1", "").is_empty());
    check_that("scene of size 0.2 with -robust: none", hints("0.1", "-shadows -robust").is_empty());
}
