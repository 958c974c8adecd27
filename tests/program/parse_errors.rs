//! Scenes with one mistake each: the place and the text of the error.

use crate::support::{CAMERA_BLOCK, Folder};

/// Parses and compiles a scene that must be refused; returns the message.
pub fn refusal(scene: &str) -> String {
    let folder = Folder::new();
    folder.write("s.txt", scene).write("bad.obj", "v 0 0 0\nv 1 0 0\nf 1 2 3\n");
    folder.write("map/left.png", "no picture");
    let run = folder.a2("-input s.txt -output o.png -size 2 2");
    assert_eq!(run.exit_code, 1, "{scene}\n{}", run.stderr);
    run.stderr.strip_prefix("error: ").unwrap_or_else(|| panic!("{}", run.stderr)).to_owned()
}

/// Every scene begins with a camera in line 1 and a material in line 2; `rest` begins in line 3.
pub fn with_material(rest: &str) -> String {
    format!("{CAMERA_BLOCK}\nMaterials {{ numMaterials 1 Material {{ }} }}\n{rest}")
}

#[test]
fn mistakes_are_found_with_line_and_column() {
    for (rest, expected) in [
        // Numbers.
        (
            "Group { numObjects 1 MaterialIndex 0\n  Sphere { center 0 0 0\n  radius abc } }",
            "s.txt:5:10: expected a number for 'radius', found 'abc'",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0\n Sphere { center 0 0 } }",
            "s.txt:4:22: 'center' takes 3 numbers, and '}' stands in the place of the 3rd",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 Sphere { center 0 0 nan radius 1 } }",
            "s.txt:3:58: expected a finite number for 'center', found 'nan'",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 Sphere { center 0 0 -inf radius 1 } }",
            "s.txt:3:58: expected a finite number for 'center', found '-inf'",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 Sphere { center 0 0 1e999 radius 1 } }",
            "s.txt:3:58: the number for 'center' is too large",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 Sphere { center 0 0 0x1p3 radius 1 } }",
            "s.txt:3:58: expected a number for 'center', found '0x1p3'",
        ),
        (
            "Group { numObjects 1.5 }",
            "s.txt:3:20: expected a whole number from 0 to 2147483647 for 'numObjects', found '1.5'",
        ),
        ("Group { numObjects -1 }", "s.txt:3:20: expected a whole number"),
        ("Group { numObjects 99999999999 }", "s.txt:3:20: expected a whole number"),
        // Structure.
        ("", "s.txt:2:42: the scene has no 'Group' block"),
        ("Group {", "s.txt:3:8: expected '}' to end the 'Group' of line 3, found the end of the file"),
        ("Group numObjects 0 }", "s.txt:3:7: expected '{' after 'Group', found 'numObjects'"),
        ("Group { numObjects 0 } }", "s.txt:3:24: '}' does not belong here"),
        (
            "Group { numObjects 0 } Group { numObjects 0 }",
            "s.txt:3:24: a second 'Group' in line 3: the first one is in line 3",
        ),
        (
            "Group { numObjects 0 }\nMaterials { numMaterials 0 }",
            "s.txt:4:1: a second 'Materials' in line 4: the first one is in line 2",
        ),
        ("Group { }", "s.txt:3:1: this 'Group' has no 'numObjects'"),
        ("Group { numObjects 0 numObjects 0 }", "s.txt:3:22: a second 'numObjects'"),
        (
            "Group { numObjects 2 MaterialIndex 0 Sphere { center 0 0 0 radius 1 } }",
            "s.txt:3:9: 'numObjects' says 2, but 1 object stands here",
        ),
        (
            "Lights { numLights 1 }\nGroup { numObjects 0 }",
            "s.txt:3:10: 'numLights' says 1, but 0 lights stand here",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 Sphere { center 0 0 0 } }",
            "s.txt:3:38: this 'Sphere' has no 'radius'",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 Sphere { radius 1 center 0 0 0 radius 2 } }",
            "s.txt:3:69: a second 'radius'",
        ),
        ("Lights { numLights 1 PointLight { color 1 1 1 } }", "s.txt:3:22: this 'PointLight' has no 'position'"),
        // Materials.
        (
            "Group { numObjects 1 Sphere { center 0 0 0 radius 1 } }",
            "s.txt:3:22: no 'MaterialIndex' stands before this 'Sphere'",
        ),
        (
            "Group { numObjects 1\nMaterialIndex 1 Sphere { center 0 0 0 radius 1 } }",
            "s.txt:4:1: MaterialIndex 1: the scene has one material, number 0",
        ),
        // Words.
        (
            "Group { numObjects 1 MaterialIndex 0 Sphere { center 0 0 0 raduis 1 } }",
            "s.txt:3:60: 'Sphere' has no 'raduis'",
        ),
        ("Group { numObjects 1 MaterialIndex 0 Cylinder { } }", "s.txt:3:38: this scene format has no 'Cylinder'"),
        ("Lights { numLights 1 SpotLight { } }", "s.txt:3:22: this scene format has no 'SpotLight'"),
        ("OrthographicCamera { }", "s.txt:3:1: this scene format has no 'OrthographicCamera'"),
        ("Lamp { }", "s.txt:3:1: the top level of a scene has no 'Lamp'"),
        // Transforms.
        ("Group { numObjects 1 Transform { Scale 1 1 1 } }", "s.txt:3:22: this 'Transform' has no object"),
        (
            "Group { numObjects 1 Transform { MaterialIndex 0 } }",
            "s.txt:3:34: 'MaterialIndex' stands in a 'Group', not in a 'Transform'",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 Transform { Sphere { center 0 0 0 radius 1 } Scale 1 1 1 } }",
            "s.txt:3:83: expected '}' after the object of the 'Transform' of line 3, found 'Scale'",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 Transform { Rotate { 0 0 1 30 5 } Sphere { center 0 0 0 radius 1 } } }",
            "s.txt:3:68: expected '}' after the 4 numbers of 'Rotate', found '5'",
        ),
        // Mistakes that need arithmetic.
        (
            "Group { numObjects 1 MaterialIndex 0 Transform { Scale 1 0 1 Sphere { center 0 0 0 radius 1 } } }",
            "s.txt:3:50: this transformation squashes space flat",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 Transform { Rotate { 0 0 0 30 } Sphere { center 0 0 0 radius 1 } } }",
            "s.txt:3:50: the axis of this rotation has no length",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 Transform { Matrix4f { 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 2 } Sphere { center 0 0 0 radius 1 } } }",
            "s.txt:3:50: the last row of this matrix",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 Transform { Matrix4f { 1 4 7 0 2 5 8 0 3 6 9 0 0 0 0 1 } Sphere { center 0 0 0 radius 1 } } }",
            "s.txt:3:50: this transformation squashes space flat",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 Transform { UniformScale 1e-309 Plane { normal 0 1 0 offset 1 } } }",
            "s.txt:3:50: the inverse of this transformation is beyond the range of numbers",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 Transform { UniformScale 1e-150 UniformScale 1e-159 Plane { normal 0 1 0 offset 1 } } }",
            "s.txt:3:90: the inverse of the product of the transforms around this object is beyond the range of numbers",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 Transform { UniformScale 1e-200 UniformScale 1e-200 Plane { normal 0 1 0 offset 1 } } }",
            "s.txt:3:90: the product of the transforms around this object leaves the range of numbers",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 Transform { UniformScale 1e200 UniformScale 1e200 Plane { normal 0 1 0 offset 1 } } }",
            "s.txt:3:88: the product of the transforms around this object leaves the range of numbers",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 Sphere { center 0 0 0 radius -1 } }",
            "s.txt:3:60: 'radius' must be above 0",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 Plane { normal 0 0 0 offset 1 } }",
            "s.txt:3:46: 'normal' has no length",
        ),
        (
            "Lights { numLights 1 DirectionalLight { direction 0 0 0 color 1 1 1 } } Group { numObjects 0 }",
            "s.txt:3:41: 'direction' has no length",
        ),
        // Other files.
        (
            "Group { numObjects 1 MaterialIndex 0 TriangleMesh { obj_file none.obj } }",
            "s.txt:3:62: cannot read the mesh 'none.obj'",
        ),
        (
            "Group { numObjects 1 MaterialIndex 0 TriangleMesh { obj_file bad.obj } }",
            "bad.obj:3:7: there is no vertex 3: the file has 2",
        ),
        (
            "Background { cubeMap nowhere } Group { numObjects 0 }",
            "s.txt:3:22: the cube map folder 'nowhere' does not exist",
        ),
    ] {
        let message = refusal(&with_material(rest));
        assert!(message.starts_with(expected), "{rest}\nexpected {expected}\nfound    {message}");
        assert!(!message.contains("panicked"), "{message}");
    }
}

#[test]
fn cameras_that_see_nothing_are_refused() {
    for (camera, expected) in [
        ("center 0 0 1 direction 0 0 0 up 0 1 0 angle 30", "s.txt:1:34: 'direction' has no length"),
        ("center 0 0 1 direction 0 0 1 up 0 0 0 angle 30", "s.txt:1:50: 'up' has no length"),
        ("center 0 0 1 direction 0 2 0 up 0 -1 0 angle 30", "s.txt:1:50: 'up' is parallel to 'direction'"),
        (
            "center 0 0 1 direction 0 0 1 up 0 1 0 angle 0",
            "s.txt:1:59: 'angle' must be above 0 and below 180 degrees",
        ),
        (
            "center 0 0 1 direction 0 0 1 up 0 1 0 angle 180",
            "s.txt:1:59: 'angle' must be above 0 and below 180 degrees",
        ),
        ("center 0 0 1 direction 0 0 1 up 0 1 0 angle -20", "s.txt:1:59: 'angle' must be"),
        ("center 0 0 1 direction 0 0 1 up 0 1 0", "s.txt:1:1: this 'PerspectiveCamera' has no 'angle'"),
    ] {
        let message = refusal(&format!("PerspectiveCamera {{ {camera} }} Group {{ numObjects 0 }}"));
        assert!(message.starts_with(expected), "{camera}\nexpected {expected}\nfound    {message}");
    }
}

#[test]
fn an_error_shows_the_line_with_a_mark_and_a_hint() {
    let message =
        refusal(&with_material("Group { numObjects 1 MaterialIndex 0 Sphere { center 0 0 0 raduis 1 } }"));
    assert!(message.contains("3 | Group { numObjects 1"), "{message}");
    assert!(message.contains("^^^^^^"), "{message}");
    assert!(message.contains("did you mean 'radius'?"), "{message}");
}

#[test]
fn too_deep_nesting_is_an_error() {
    for deep in ["Group { numObjects 1 ", "Transform { "] {
        let scene = with_material(&format!("Group {{ numObjects 1 {}", deep.repeat(100_000)));
        let message = refusal(&scene);
        assert!(message.contains("objects are nested more than 256 deep"), "{message}");
    }
    let message = refusal(&with_material(&"{".repeat(100_000)));
    assert!(message.starts_with("s.txt:3:1: '{' does not belong here"), "{message}");
}

#[test]
fn reasonable_nesting_is_no_error() {
    let (open, close) = ("Group { numObjects 1 Transform { Translate 0 0 0.01 ".repeat(120), "} }".repeat(120));
    let sphere = "Group { numObjects 1 MaterialIndex 0 Sphere { center 0 0 0 radius 1 } }";
    let folder = Folder::new();
    folder.render(&with_material(&format!("{open}{sphere}{close}")), "-size 4 4");
}

#[test]
fn every_spelling_of_a_finite_number_is_read() {
    let digits = "0".repeat(200) + "1." + &"3".repeat(400);
    for number in ["1", "+1", "1.", ".5", "1e0", "1E+2", "1e39", "1e-320", digits.as_str()] {
        let sphere = format!("Group {{ numObjects 1 MaterialIndex 0 Sphere {{ center 0 0 0 radius {number}}} }}");
        let folder = Folder::new();
        folder.write("s.txt", with_material(&sphere));
        let run = folder.a2("-input s.txt -output o.png -size 2 2");
        assert_eq!(run.exit_code, 0, "{number}: {}", run.stderr);
    }
}
