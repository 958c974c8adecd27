//! Scenes whose sizes do not fit their camera, their ray offset or the range of numbers: right, or a warning.

use crate::support::{Folder, SCENE, TRIANGLE};

/// Rounding of numbers near the eye is larger than the sphere around it, whose points still have right directions.
#[test]
fn an_eye_inside_a_tiny_sphere_sees_it_wherever_it_is() {
    let folder = Folder::new();
    let sphere = |center: &str, radius: &str| {
        SCENE
            .replace("center 0 0 10", &format!("center {center}"))
            .replace(TRIANGLE, &format!("Sphere {{ center {center} radius {radius} }}"))
    };
    let picture = |scene: &str, flags: &str| {
        folder.write("s.txt", scene);
        let run = folder.a2(&format!("-input s.txt -size 40 30 -normals n.png {flags}"));
        assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""), "{flags}");
        folder.picture("n.png")
    };
    let right = picture(&sphere("0 0 0", "1"), "");
    for center in ["0 1 8", "-1e6 3.3 1e-3"] {
        for radius in ["1e-13", "1e-16", "1e-17", "1e-60", "1e-300"] {
            for flags in ["", "-plain", "-simd sse2", "-robust"] {
                let found = picture(&sphere(center, radius), flags);
                let differ = found.iter().zip(right.iter()).filter(|(a, b)| a.abs_diff(**b) > 1).count();
                assert_eq!(differ, 0, "{center}, radius {radius} {flags}");
            }
        }
    }
}

/// Runs a scene; returns what is said.
fn said(scene: &str, flags: &str) -> String {
    let folder = Folder::new();
    folder.write("s.txt", scene);
    let run = folder.a2(&format!("-input s.txt -output o.png -size 9 9 {flags}"));
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    run.stderr
}

#[test]
fn what_is_seen_by_rounding_only_is_a_warning() {
    let sphere = SCENE.replace(TRIANGLE, "Sphere { center 0 0 0 radius 1 }");
    for (distance, angle, expected) in [
        ("1e16", "1.4e-14", "the angle of the camera is so small that neighbouring rays differ by rounding only"),
        ("1e20", "1.4e-18", "the angle of the camera is so small"),
        ("1e12", "1.4e-10", "this sphere is seen from 1.0e12 times its radius: rays hit or miss it by rounding"),
    ] {
        let scene = sphere.replace("center 0 0 10", &format!("center 0 0 {distance}"));
        let scene = scene.replace("angle 90", &format!("angle {angle}"));
        for flags in ["", "-robust"] {
            let said = said(&scene, flags);
            assert!(said.starts_with("warning: ") && said.contains(expected), "{distance}: {said}");
        }
    }
    for (distance, angle) in [("10", "90"), ("1e10", "1.4e-8"), ("1e12", "90"), ("1e16", "1")] {
        let scene = sphere.replace("center 0 0 10", &format!("center 0 0 {distance}"));
        assert_eq!(said(&scene.replace("angle 90", &format!("angle {angle}")), ""), "", "{distance}");
    }
}

#[test]
fn coordinates_at_the_end_of_the_range_are_a_warning() {
    let scaled = |size: &str| {
        let scene = SCENE.replace("center 0 0 10", &format!("center 0 0 10{size}"));
        scene
            .replace(TRIANGLE, &format!("Transform {{ UniformScale 1{size} Sphere {{ center 0 0 0 radius 1 }} }}"))
    };
    for size in ["e304", "e306", "e-303"] {
        let said = said(&scaled(size), "-robust");
        assert!(
            said.contains("are at the end of the range of numbers, so that pixels may be wrong"),
            "{size}: {said}"
        );
    }
    for size in ["", "e150", "e-150", "e280"] {
        assert_eq!(said(&scaled(size), "-robust"), "", "{size}");
    }
}

/// A plane has no bounds, and the coordinates of a sphere in its own space are not those in the world.
#[test]
fn objects_whose_own_space_is_at_the_end_of_the_range_are_a_warning() {
    let said_of = |object: &str| said(&SCENE.replace(TRIANGLE, object), "-robust");
    let expected = "in the space of this object are at the end of the range of numbers: pixels may be wrong";
    for object in [
        "Transform { UniformScale 1e-308 Plane { normal 0 1 0 offset -1e308 } }",
        "Transform { UniformScale 1e-307 Plane { normal 0 1 0 offset -1e307 } }",
        "Transform { Scale 1 1e-308 1 Plane { normal 0 1 0 offset -1e308 } }",
        "Transform { UniformScale 1e-280 Plane { normal 0 1e30 0 offset -1e308 } }",
        "Transform { UniformScale 1e-308 Sphere { center 0 0 0 radius 1e308 } }",
    ] {
        let said = said_of(object);
        assert!(said.starts_with("warning: s.txt:5:") && said.contains(expected), "{object}: {said}");
        assert_eq!(said.lines().count(), 1, "{object}: {said}");
    }
    for object in [
        "Transform { UniformScale 1e-297 Plane { normal 0 1 0 offset -1e297 } }",
        "Transform { UniformScale 1e300 Plane { normal 0 1 0 offset -1e-300 } }",
        "Transform { UniformScale 1e-300 Sphere { center 0 0 0 radius 1e300 } }",
        "Transform { UniformScale 1e-308 Triangle { vertex0 -1e308 0 0 vertex1 1e308 0 0 vertex2 0 1e308 0 } }",
        "Plane { normal 0 1e300 0 offset -1e300 }",
        "Plane { normal 0 1 0 offset -1e308 }",
    ] {
        assert_eq!(said_of(object), "", "{object}");
    }
}

#[test]
fn a_ray_offset_as_large_as_the_scene_is_a_warning() {
    let flags = |epsilon: &str| format!("-epsilon {epsilon} -shadows -bounces 2");
    let said_of = |epsilon: &str| said(SCENE, &flags(epsilon));
    for (epsilon, shown) in [("100", "100"), ("1", "1"), ("1e30", "1e30")] {
        let expected = format!(
            "warning: with -epsilon {shown} shadows and mirror images are lost in a scene that is 7.0e0 across: \
             -epsilon auto fits any size\n"
        );
        assert_eq!(said_of(epsilon), expected);
    }
    for epsilon in ["0.01", "0.1", "auto"] {
        assert_eq!(said_of(epsilon), "", "{epsilon}");
    }
    assert_eq!(said(SCENE, "-epsilon 100"), "");
    let said = said_of("1e-320");
    assert!(said.starts_with("warning: with -epsilon 1e-320 rays hit the surface that they leave"), "{said}");
}
