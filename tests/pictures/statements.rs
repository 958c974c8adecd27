//! Statements about the starter that no picture of the course pins down, one test each.

use crate::support::{CAMERA_BLOCK, Folder, LIGHT, SCENE, middle};

/// A scene lit from the eye with materials 0 red, 1 green, 2 blue; the middle pixel looks along -z at the origin.
fn scene(objects: &str) -> String {
    format!(
        "{CAMERA_BLOCK} Background {{ color 0 0 0 }} Lights {{ numLights 1 {LIGHT} }}
         Materials {{ numMaterials 3 Material {{ diffuseColor 1 0 0 }} Material {{ diffuseColor 0 1 0 }}
                      Material {{ diffuseColor 0 0 1 }} }}
         Group {{ {objects} }}"
    )
}

fn middle_of(scene: &str, arguments: &str) -> [u8; 3] {
    middle(&Folder::new().render(scene, &format!("-size 1 1 {arguments}")))
}

#[test]
fn a_material_index_holds_across_groups() {
    let sphere = "Sphere { center 0 0 0 radius 1 }";
    let hidden = "Sphere { center 0 0 -5 radius 1 }";
    // Set inside a nested group, it stays set behind it.
    let after = format!("numObjects 2 MaterialIndex 0 Group {{ numObjects 1 MaterialIndex 2 {hidden} }} {sphere}");
    assert_eq!(middle_of(&scene(&after), ""), [0, 0, 255]);
    // Set before, it reaches into groups and transforms.
    let into =
        format!("numObjects 1 MaterialIndex 1 Group {{ numObjects 1 Transform {{ Scale 1 1 1 {sphere} }} }}");
    assert_eq!(middle_of(&scene(&into), ""), [0, 255, 0]);
}

#[test]
fn materials_may_follow_the_group() {
    let swapped = SCENE.replace("Materials { numMaterials 1 Material { } }\n", "")
        + "Materials { numMaterials 1 Material { diffuseColor 0 1 0 } }";
    assert_eq!(middle_of(&swapped, ""), [0, 255, 0]);
}

/// Depth of the middle pixel of a transformed triangle in the plane z = 0, as a byte of the range 0 to 20.
fn depth_of(transform: &str) -> u8 {
    let folder = Folder::new();
    let triangle = "Triangle { vertex0 -30 -30 0 vertex1 30 -30 0 vertex2 0 40 0 }";
    folder.write("s.txt", scene(&format!("numObjects 1 MaterialIndex 0 Transform {{ {transform} {triangle} }}")));
    let run = folder.a2("-input s.txt -depth 0 20 d.png -size 1 1");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    middle(&folder.picture("d.png"))[0]
}

const MOVE_BY_2: &str = "Matrix4f { 1 0 0 0  0 1 0 0  0 0 1 0  0 0 2 1 }";
const STRETCH_BY_2: &str = "Matrix4f { 2 0 0 0  0 2 0 0  0 0 2 0  0 0 0 1 }";

#[test]
fn transformations_multiply_on_the_right_but_a_matrix_on_the_left() {
    // Eye at 10; plane z ends up at 2 or 4 and the byte is trunc(255 * (10 - z) / 20).
    let byte = |z: f64| (255.0 * (10.0 - z) / 20.0) as u8;
    assert_eq!(depth_of("Translate 0 0 2 UniformScale 2"), byte(2.0));
    assert_eq!(depth_of("UniformScale 2 Translate 0 0 2"), byte(4.0));
    assert_eq!(depth_of(&format!("UniformScale 2 {MOVE_BY_2}")), byte(2.0));
    assert_eq!(depth_of(&format!("Translate 0 0 2 {STRETCH_BY_2}")), byte(4.0));
    assert_eq!(depth_of(&format!("{MOVE_BY_2} {STRETCH_BY_2}")), byte(4.0));
}

/// A lit white plane at the origin with the given material fields and normal.
fn plane(material: &str, normal: &str, light: &str, behind: &str) -> String {
    format!(
        "{CAMERA_BLOCK} Background {{ color 0 0 0 }} Lights {{ numLights 1 {light} }}
         Materials {{ numMaterials 2 Material {{ {material} }} Material {{ diffuseColor 0 1 0 }} }}
         Group {{ numObjects {} MaterialIndex 0 Plane {{ normal {normal} offset 0 }} {behind} }}",
        if behind.is_empty() { 1 } else { 2 }
    )
}

#[test]
fn zero_to_the_power_of_zero_is_one() {
    // The light stands behind the mirrored ray: R.L is cut to 0, and 0^0 lights the whole highlight.
    let from_behind = "DirectionalLight { direction 0 0 1 color 0.5 0.5 0.5 }";
    let material = "diffuseColor 0 0 0 specularColor 0.5 0.5 0.5";
    assert_eq!(middle_of(&plane(material, "0 0 1", from_behind, ""), ""), [63; 3]);
    assert_eq!(middle_of(&plane(&format!("{material} shininess 1"), "0 0 1", from_behind, ""), ""), [0; 3]);
}

#[test]
fn the_highlight_asks_for_the_mirrored_ray_alone_not_for_the_side() {
    // The plane's normal looks away from eye and light, yet R = D - 2 (D.N) N comes back to both.
    let material = "diffuseColor 1 1 1 specularColor 0 0.5 0 shininess 3";
    assert_eq!(middle_of(&plane(material, "0 0 -1", LIGHT, ""), ""), [0, 127, 0]);
}

#[test]
fn an_unnormalised_plane_normal_brightens_and_stretches() {
    // N.L = 0.5; the picture of the normal shows it as given.
    assert_eq!(middle_of(&plane("", "0 0 0.5", LIGHT, ""), ""), [127; 3]);
    let folder = Folder::new();
    folder.write("s.txt", plane("", "0 0 0.5", LIGHT, ""));
    folder.a2("-input s.txt -normals n.png -size 1 1");
    assert_eq!(middle(&folder.picture("n.png")), [127, 127, 191]);
}

#[test]
fn a_transformed_plane_has_a_unit_normal() {
    let plain = "Plane { normal 0 0 0.5 offset 0 }";
    let transformed =
        plane("", "0 0 0.5", LIGHT, "").replace(plain, &format!("Transform {{ UniformScale 3 {plain} }}"));
    assert_eq!(middle_of(&transformed, ""), [255; 3]);
}

#[test]
fn the_mirror_ray_starts_a_hundredth_of_r_away() {
    // A normal of length 5 makes R = (0, 0, 49) of D = (0, 0, -1), so the mirror ray starts at z = 0.49 and not at 0.01:
    // it sees a wall at z = 0.75, but one at z = 0.25 is behind it. The eye, at z = 0.1, sees neither.
    for (wall, seen) in [(0.25, [0; 3]), (0.75, [0, 255, 0])] {
        let wall = format!("MaterialIndex 1 Plane {{ normal 0 0 1 offset {wall} }}");
        let lit = plane("diffuseColor 0 0 0 specularColor 1 1 1", "0 0 5", LIGHT, &wall);
        // Without lights all ambient light is 1: every surface shows its diffuse colour.
        let scene = lit
            .replace("center 0 0 10", "center 0 0 0.1")
            .replace("numLights 1", "numLights 0")
            .replace(LIGHT, "");
        assert_eq!(middle_of(&scene, "-bounces 1"), seen);
    }
}

#[test]
fn the_mirror_ray_is_not_normalised_again() {
    // With N = (0, 0, 1/2) a ray along -z goes on along -z at half its length, and the highlight counts that length:
    // R.L = 1/2 towards a light from behind.
    let behind = "DirectionalLight { direction 0 0 1 color 1 1 1 }";
    let material = "diffuseColor 0 0 0 specularColor 1 1 1 shininess 1";
    assert_eq!(middle_of(&plane(material, "0 0 0.5", behind, ""), ""), [127; 3]);
    // A second plane behind, met by the ray of half length: its own highlight has R.L = 1/4 with N = (0, 0, 1/2),
    // where a normalised ray would give 1/2 again. Together 1/2 + 1/4.
    let second = "Plane { normal 0 0 0.5 offset -1 }";
    assert_eq!(middle_of(&plane(material, "0 0 0.5", behind, second), "-bounces 1"), [191; 3]);
}

#[test]
fn a_mirror_is_told_by_the_euclidean_length_of_its_specular_colour() {
    let wall = "MaterialIndex 1 Plane { normal 0 0 -1 offset -20 }";
    let light = "DirectionalLight { direction 0 0 1 color 1 1 1 }";
    for (specular, reflects) in [("0.06 0.06 0.06", true), ("0 0.1 0", false), ("0 0.1001 0", true)] {
        // The green wall at z = 20 is behind the eye and lit from below; N.L of the mirror itself is 0.
        let scene =
            plane(&format!("diffuseColor 0 0 0 specularColor {specular} shininess 9"), "0 0 1", light, wall);
        assert_eq!(middle_of(&scene, "-bounces 1")[1] > 0, reflects, "{specular}");
        assert_eq!(middle_of(&scene, "-bounces 0")[1], 0, "{specular}");
    }
}

#[test]
fn the_distance_to_a_light_is_measured_from_the_moved_origin() {
    // The light is 1 above the plane. The shadow ray starts 0.01 up, and what it meets within 1 from there blocks:
    // a sphere that begins 0.005 behind the light does, one that begins 0.015 behind it does not.
    for (gap, lit) in [(0.005, false), (0.015, true)] {
        let light = "PointLight { position 0 0 1 color 1 1 1 falloff 1 }";
        let sphere = format!("Sphere {{ center 0 0 {} radius 0.5 }}", 1.5 + gap);
        let scene = plane("", "0 0 1", light, &sphere).replace("center 0 0 10", "center 0 0 0.5");
        assert_eq!(middle_of(&scene, "-shadows"), if lit { [255; 3] } else { [0; 3] }, "{gap}");
    }
}

#[test]
fn shadow_rays_start_a_hundredth_away() {
    // A sheet 0.005 above the plane casts no shadow on it, one 0.02 above does.
    for (height, lit) in [(0.005, true), (0.02, false)] {
        let sheet = format!("Plane {{ normal 0 0 1 offset {height} }}");
        // The eye looks from between the two.
        let scene = plane("", "0 0 1", LIGHT, &sheet).replace("center 0 0 10", "center 0 0 0.001");
        assert_eq!(middle_of(&scene, "-shadows"), if lit { [255; 3] } else { [0; 3] }, "{height}");
    }
}

#[test]
fn a_light_behind_the_surface_casts_no_diffuse_light() {
    let behind = "DirectionalLight { direction 0 0 1 color 1 1 1 }";
    assert_eq!(middle_of(&plane("", "0 0 1", behind, ""), ""), [0; 3]);
}

#[test]
fn a_tie_goes_to_the_object_that_comes_first() {
    let plane = "Plane { normal 0 0 1 offset 0 }";
    let first = format!("numObjects 2 MaterialIndex 1 {plane} MaterialIndex 2 {plane}");
    assert_eq!(middle_of(&scene(&first), ""), [0, 255, 0]);
    let spheres = "Sphere { center 0 0 0 radius 1 } ".repeat(7);
    let first = format!(
        "numObjects 9 MaterialIndex 0 {} MaterialIndex 1 {plane} MaterialIndex 2 {spheres}",
        plane.replace("offset 0", "offset 1")
    );
    assert_eq!(middle_of(&scene(&first), ""), [255, 0, 0]);
}
