//! Rules of the starter that no picture of the course shows, one test each.

use crate::support::{CAMERA_BLOCK, Folder, LIGHT, SCENE, middle};

/// Makes a scene lit from the eye with materials 0 red, 1 green, 2 blue. The middle pixel looks along -z at the
/// origin.
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
fn a_material_index_is_valid_across_groups() {
    let sphere = "Sphere { center 0 0 0 radius 1 }";
    let hidden = "Sphere { center 0 0 -5 radius 1 }";
    // Set inside a nested group, it is valid after the group.
    let after = format!("numObjects 2 MaterialIndex 0 Group {{ numObjects 1 MaterialIndex 2 {hidden} }} {sphere}");
    assert_eq!(middle_of(&scene(&after), ""), [0, 0, 255]);
    // Set before, it is valid inside groups and transforms.
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

/// Returns the depth of a transformed triangle in the plane z = 0 in the middle pixel, as a byte of the range 0 to
/// 20.
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
fn transforms_multiply_from_the_right_but_a_matrix_from_the_left() {
    // The eye is at 10. The plane moves to z = 2 or 4, and the byte is trunc(255 * (10 - z) / 20).
    let byte = |z: f64| (255.0 * (10.0 - z) / 20.0) as u8;
    assert_eq!(depth_of("Translate 0 0 2 UniformScale 2"), byte(2.0));
    assert_eq!(depth_of("UniformScale 2 Translate 0 0 2"), byte(4.0));
    assert_eq!(depth_of(&format!("UniformScale 2 {MOVE_BY_2}")), byte(2.0));
    assert_eq!(depth_of(&format!("Translate 0 0 2 {STRETCH_BY_2}")), byte(4.0));
    assert_eq!(depth_of(&format!("{MOVE_BY_2} {STRETCH_BY_2}")), byte(4.0));
}

/// Makes a scene of a lit plane at the origin with the given material fields and normal, and perhaps another object.
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
    // The light is behind the mirrored ray: R.L is clamped to 0, and 0^0 = 1 gives a full highlight.
    let from_behind = "DirectionalLight { direction 0 0 1 color 0.5 0.5 0.5 }";
    let material = "diffuseColor 0 0 0 specularColor 0.5 0.5 0.5";
    assert_eq!(middle_of(&plane(material, "0 0 1", from_behind, ""), ""), [63; 3]);
    assert_eq!(middle_of(&plane(&format!("{material} shininess 1"), "0 0 1", from_behind, ""), ""), [0; 3]);
}

#[test]
fn the_highlight_depends_on_the_mirrored_ray_and_not_on_the_side() {
    // The plane's normal points away from eye and light, but R = D - 2 (D.N) N points back to both.
    let material = "diffuseColor 1 1 1 specularColor 0 0.5 0 shininess 3";
    assert_eq!(middle_of(&plane(material, "0 0 -1", LIGHT, ""), ""), [0, 127, 0]);
}

#[test]
fn an_unnormalised_plane_normal_brightens_and_stretches() {
    // N.L = 0.5; the picture of normals shows the normal as given.
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
fn the_mirror_ray_starts_at_a_hundredth_of_r() {
    // With a normal of length 5, D = (0, 0, -1) gives R = (0, 0, 49). So the mirror ray starts at z = 0.49 and not at
    // 0.01: it sees a wall at z = 0.75, but a wall at z = 0.25 is behind it. The eye, at z = 0.1, sees neither.
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
    // With N = (0, 0, 1/2) a ray along -z goes on along -z with half its length, and the highlight depends on the
    // length: R.L = 1/2 towards a light from behind.
    let behind = "DirectionalLight { direction 0 0 1 color 1 1 1 }";
    let material = "diffuseColor 0 0 0 specularColor 1 1 1 shininess 1";
    assert_eq!(middle_of(&plane(material, "0 0 0.5", behind, ""), ""), [127; 3]);
    // The ray of half length hits a second plane behind, whose highlight has R.L = 1/4 with N = (0, 0, 1/2). A
    // normalised ray would give 1/2 again. Together 1/2 + 1/4.
    let second = "Plane { normal 0 0 0.5 offset -1 }";
    assert_eq!(middle_of(&plane(material, "0 0 0.5", behind, second), "-bounces 1"), [191; 3]);
}

#[test]
fn a_material_is_a_mirror_by_the_euclidean_length_of_its_specular_colour() {
    let wall = "MaterialIndex 1 Plane { normal 0 0 -1 offset -20 }";
    let light = "DirectionalLight { direction 0 0 1 color 1 1 1 }";
    for (specular, reflects) in [("0.06 0.06 0.06", true), ("0 0.1 0", false), ("0 0.1001 0", true)] {
        // The green wall at z = 20 is behind the eye; N.L of the mirror itself is 0.
        let scene =
            plane(&format!("diffuseColor 0 0 0 specularColor {specular} shininess 9"), "0 0 1", light, wall);
        assert_eq!(middle_of(&scene, "-bounces 1")[1] > 0, reflects, "{specular}");
        assert_eq!(middle_of(&scene, "-bounces 0")[1], 0, "{specular}");
    }
}

#[test]
fn the_distance_to_a_light_is_measured_from_the_offset_origin() {
    // The light is 1 above the plane. The shadow ray starts 0.01 up, and everything within 1 from there blocks it:
    // also a sphere that begins 0.005 behind the light, but not a sphere that begins 0.015 behind it.
    for (behind, lit) in [(0.005, false), (0.015, true)] {
        let light = "PointLight { position 0 0 1 color 1 1 1 falloff 1 }";
        let sphere = format!("Sphere {{ center 0 0 {} radius 0.5 }}", 1.5 + behind);
        let scene = plane("", "0 0 1", light, &sphere).replace("center 0 0 10", "center 0 0 0.5");
        assert_eq!(middle_of(&scene, "-shadows"), if lit { [255; 3] } else { [0; 3] }, "{behind}");
    }
}

#[test]
fn shadow_rays_start_a_hundredth_away() {
    // A sheet 0.005 above the plane casts no shadow on it, one 0.02 above does.
    for (height, lit) in [(0.005, true), (0.02, false)] {
        let sheet = format!("Plane {{ normal 0 0 1 offset {height} }}");
        // The eye is between the two.
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
fn at_equal_t_the_first_object_is_hit() {
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
