//! A scene pays only for what it needs: the work that the plan leaves out is really not done.

use crate::support::{Folder, LIGHT, SCENE, SQUARE_OBJ, TRIANGLE, options, project};
use a2::measure::Report;
use a2::memory::Budget;

/// Renders in memory.
fn rendered(input: &str, arguments: &str) -> Report {
    a2::render_scene(&options(&format!("-input {input} -size 20 20 -quiet {arguments}"))).unwrap()
}

fn own(name: &str) -> String {
    project("data").join(name).display().to_string()
}

#[test]
fn only_wanted_pictures_are_stored() {
    let rendered = rendered(&own("scene01_plane.txt"), "-depth 8 18 d.png -shadows -bounces 3");
    assert!(rendered.frame.film.color.is_none() && rendered.frame.film.normals.is_none());
    assert_eq!(rendered.frame.film.depth.map(|plane| plane.len()), Some(400));
    assert_eq!(
        (rendered.frame.counts.camera, rendered.frame.counts.shadow, rendered.frame.counts.mirror),
        (400, 0, 0)
    );
}

#[test]
fn shadow_and_mirror_rays_are_traced_only_with_their_flags() {
    let plain = rendered(&own("scene01_plane.txt"), "-output o.png").frame.counts;
    assert_eq!((plain.camera, plain.shadow, plain.mirror), (400, 0, 0));
    let shadows = rendered(&own("scene01_plane.txt"), "-output o.png -shadows").frame.counts;
    assert!(shadows.shadow > 0 && shadows.mirror == 0);
    // Plane and red sphere are mirrors (specular 1 1 1).
    assert!(rendered(&own("scene01_plane.txt"), "-output o.png -bounces 1").frame.counts.mirror > 0);
    assert_eq!(rendered(&own("scene04_axes.txt"), "-output o.png -bounces 9").frame.counts.mirror, 0);
}

#[test]
fn no_shadow_ray_is_traced_where_a_light_adds_nothing() {
    // The surface is seen from the front and lit from behind, without a highlight.
    let folder = Folder::new();
    folder.write("s.txt", SCENE.replace("direction 0 0 -1 color 1 1 1", "direction 0 0 1 color 1 1 1"));
    let counts = rendered(&folder.path("s.txt").display().to_string(), "-output o.png -shadows").frame.counts;
    assert!(counts.shadow == 0 && counts.shadow_left_out > 0, "{counts:?}");
    // A light without colour is left out.
    folder.write("s.txt", SCENE.replace("color 1 1 1", "color 0 0 0"));
    let counts = rendered(&folder.path("s.txt").display().to_string(), "-output o.png -shadows").frame.counts;
    assert_eq!((counts.shadow, counts.shadow_left_out), (0, 0));
}

#[test]
fn a_cube_map_face_is_decoded_only_when_a_ray_reaches_it() {
    let faces = |arguments: &str| rendered(&own("scene06_bunny_1k.txt"), arguments).decoded_faces;
    assert_eq!(faces("-normals n.png"), 0);
    // The eye looks at one side of the cube; mirrors show more sides.
    let without_mirrors = faces("-output o.png");
    assert!((1..6).contains(&without_mirrors), "{without_mirrors}");
    assert!(faces("-output o.png -bounces 2") > without_mirrors);
}

#[test]
fn a_broken_face_that_no_ray_reaches_is_no_error() {
    // The picture has a good header and no data: it is opened, but never decoded.
    let folder = Folder::new();
    let face = std::fs::read(project("data/tex/courtyard/front.png")).unwrap();
    let whole = |name: &str| std::fs::read(project("data/tex/courtyard").join(name)).unwrap();
    for name in ["left.png", "right.png", "up.png", "down.png", "back.png"] {
        folder.write(&format!("map/{name}"), whole(name));
    }
    folder.write("map/front.png", &face[..200]);
    let scene = |direction: &str| {
        format!(
            "PerspectiveCamera {{ center 0 0 0 direction {direction} up 0 1 0 angle 20 }}
             Background {{ cubeMap map }} Group {{ numObjects 0 }}"
        )
    };
    folder.write("back.txt", scene("0 0 -1")).write("front.txt", scene("0 0 1"));
    assert_eq!(folder.a2("-input back.txt -output o.png -size 9 9").exit_code, 0);
    let run = folder.a2("-input front.txt -output broken.png -size 9 9");
    assert_eq!(run.exit_code, 1);
    assert!(run.stderr.contains("front.png': cannot read this picture"), "{}", run.stderr);
    assert!(!folder.path("broken.png").exists());
}

#[test]
fn a_mesh_of_several_instances_is_stored_once() {
    let source = a2::scene_file::parse_file(&project("data/scene04_axes.txt")).unwrap().whole().unwrap();
    let plan = a2::plan::Plan::new(&options("-input x.txt -output o.png"), &source);
    let scene = a2::scene::compile(&source, &plan, &mut Budget::default()).unwrap().scene;
    assert_eq!((scene.geometry.objects.len(), scene.geometry.meshes.len()), (4, 1));
}

#[test]
fn paths_end_when_nothing_can_change_the_colour() {
    // Two mirrors of specular 0.5 face each other in a scene with a directional light. After about 60 bounces further
    // light is smaller than the rounding of the colour.
    let folder = Folder::new();
    folder.write(
        "s.txt",
        "PerspectiveCamera { center 0 0 1 direction 0 0 -1 up 0 1 0 angle 20 }
         Lights { numLights 1 DirectionalLight { direction 0 0 -1 color 1 1 1 } } Background { ambientLight 0.1 0.1 0.1 }
         Materials { numMaterials 1 Material { specularColor 0.5 0.5 0.5 shininess 5 } }
         Group { numObjects 2 MaterialIndex 0
             Plane { normal 0 0 1 offset 0 } Plane { normal 0 0 -1 offset -2 } }",
    );
    let input = folder.path("s.txt").display().to_string();
    let counts = rendered(&input, "-output o.png -bounces 100000").frame.counts;
    assert!((40..100).contains(&(counts.mirror / counts.camera)), "{counts:?}");
}

/// Renders a scene of the folder, and returns what was left out.
fn left_out(folder: &Folder, arguments: &str) -> String {
    rendered(&folder.path("s.txt").display().to_string(), arguments).left_out.join("\n")
}

#[test]
fn the_tree_of_a_mesh_is_built_for_the_first_ray_that_meets_its_box() {
    let folder = Folder::new();
    folder.write("m.obj", SQUARE_OBJ);
    let mesh =
        |at: &str| format!("Transform {{ Translate {at} UniformScale 8 TriangleMesh {{ obj_file m.obj }} }}");
    // The eye is at z = 10 and looks along -z; a mirror behind the triangle shows what is behind the eye.
    let mirror = "Plane { normal 0 0 1 offset -5 }";
    let scene = SCENE.replace("Material { }", "Material { specularColor 1 1 1 }");
    for (at, objects, arguments, is_unmet) in [
        ("0 0 0", "", "", false),
        ("0 0 30", "", "", true),
        ("0 0 30", "", "-shadows", true),
        ("90 0 0", "", "", true),
        ("0 0 30", mirror, "", true),
        ("0 0 30", mirror, "-bounces 1", false),
    ] {
        let objects = format!("{} {objects}", mesh(at));
        let count = if objects.contains("Plane") { "numObjects 2" } else { "numObjects 1" };
        folder.write("s.txt", scene.replace(TRIANGLE, &objects).replace("numObjects 1", count));
        for way in ["-threads 1", "-threads 3", "-plain", "-simd sse2"] {
            let said = left_out(&folder, &format!("-output o.png {arguments} {way}"));
            assert_eq!(said.contains("m.obj: no ray meets its box"), is_unmet, "{at} {arguments} {way}: {said}");
        }
    }
    let run = folder.a2("-input s.txt -output o.png -explain");
    assert!(run.stderr.contains("left out: the tree of m.obj: no ray meets its box"), "{}", run.stderr);
}

#[test]
fn a_tree_that_is_built_amid_rendering_changes_no_byte() {
    // Mirrors show a bunny behind the eye to many tiles at once.
    let folder = Folder::new();
    folder.write("m.obj", std::fs::read(project("data/models/bunny_1k.obj")).unwrap());
    let scene = SCENE
        .replace("Material { }", "Material { diffuseColor 0.2 0.2 0.2 specularColor 0.8 0.8 0.8 shininess 9 }")
        .replace(TRIANGLE, "Plane { normal 0 0 1 offset -5 } Transform { Translate 0 0 14 UniformScale 30 TriangleMesh { obj_file m.obj } }")
        .replace("numObjects 1", "numObjects 2");
    let picture = |arguments: &str| folder.render(&scene, &format!("-size 200 200 -bounces 3 {arguments}"));
    let plain = picture("-plain -threads 1");
    let shades: std::collections::BTreeSet<_> = plain.pixels().map(|pixel| pixel.0).collect();
    assert!(shades.len() > 20, "{}", shades.len());
    for threads in [1, 2, 4, 16] {
        assert!(picture(&format!("-threads {threads}")) == plain, "{threads} threads");
    }
}

#[test]
fn a_depth_picture_makes_no_smooth_normals() {
    let folder = Folder::new();
    folder.write("m.obj", SQUARE_OBJ);
    folder.write("s.txt", SCENE.replace(TRIANGLE, "TriangleMesh { obj_file m.obj }"));
    let bytes = |arguments: &str| {
        let source = a2::scene_file::parse_file(&folder.path("s.txt")).unwrap().whole().unwrap();
        let plan = a2::plan::Plan::new(&options(&format!("-input s.txt {arguments}")), &source);
        let scene = a2::scene::compile(&source, &plan, &mut Budget::default()).unwrap().scene;
        scene.geometry.meshes[0].bytes()
    };
    let (depth, colors) = (bytes("-depth 8 12 d.png"), bytes("-output o.png"));
    assert_eq!(colors - depth, 4 * size_of::<[vecmath::Real; 3]>());
    assert_eq!(bytes("-normals n.png"), colors);
    assert!(left_out(&folder, "-depth 8 12 d.png").contains("the smooth normals of meshes"));
    assert!(!left_out(&folder, "-normals n.png").contains("the smooth normals of meshes"));
}

#[test]
fn equal_objects_at_one_place_are_one() {
    let folder = Folder::new();
    let sphere = "Sphere { center 0 0 0 radius 3 }\n";
    let materials = "numMaterials 2 Material { diffuseColor 1 0 0 } Material { diffuseColor 0 1 0 }";
    let scene = |objects: &str, count: usize| {
        let scene = SCENE.replace("numMaterials 1 Material { }", materials).replace(TRIANGLE, objects);
        scene.replace("numObjects 1", &format!("numObjects {count}"))
    };
    let many = format!("{} MaterialIndex 1 {}", sphere.repeat(1000), sphere.repeat(1000));
    let picture =
        |folder: &Folder, objects: &str, count| folder.render(&scene(objects, count), "-size 50 50 -shadows");
    assert!(picture(&folder, &many, 2000) == picture(&folder, sphere, 1));
    folder.write("s.txt", scene(&many, 2000));
    let said = left_out(&folder, "-output o.png");
    assert!(said.contains("1999 objects: an equal one at the same place comes first"), "{said}");
}

#[test]
fn what_a_sphere_hides_is_left_out() {
    let folder = Folder::new();
    // Small ones first, because the first object counts at equal t.
    let shells: String =
        (1..=500).map(|i| format!("Sphere {{ center 0 0 0 radius {} }} ", i as f64 / 200.0)).collect();
    let inside = "MaterialIndex 1 Triangle { vertex0 0 0 1 vertex1 1 0 1 vertex2 0 1 1 } ";
    let crossing = "MaterialIndex 1 Triangle { vertex0 -3 0 2 vertex1 1 0 2 vertex2 0 1 2 } ";
    let materials =
        "numMaterials 2 Material { diffuseColor 1 0.5 0 } Material { diffuseColor 0 1 0 specularColor 1 1 1 }";
    let scene = |objects: &str, count: usize| {
        let scene = SCENE.replace("numMaterials 1 Material { }", materials).replace(TRIANGLE, objects);
        scene.replace("numObjects 1", &format!("numObjects {count}"))
    };
    let outer = format!("Sphere {{ center 0 0 0 radius 2.5 }} {crossing}");
    let all = format!("{shells}{inside}{crossing}");
    let flags = "-size 60 60 -shadows";
    assert!(folder.render(&scene(&all, 502), flags) == folder.render(&scene(&outer, 2), flags));
    let point_light = |at: &str| format!("PointLight {{ position {at} color 1 1 1 falloff 0.1 }}");
    for (change, arguments, hidden) in [
        (("", String::new()), "", 500),
        (("", String::new()), "-shadows", 500),
        ((LIGHT, point_light("5 5 5")), "-shadows", 500),
        // The light is inside of most shells, but outside of the 15th, which hides those in it.
        ((LIGHT, point_light("0 0 0.1")), "-shadows", 14),
        ((LIGHT, point_light("0 0 0.1")), "", 500),
        // Mirror rays may begin inside.
        (("", String::new()), "-bounces 1", 0),
        // The eye is inside of seven shells; 492 and the triangle are inside of the next one.
        (("center 0 0 10", "center 0 0 2.467".to_owned()), "", 493),
    ] {
        let text = scene(&all, 502);
        folder.write("s.txt", if change.0.is_empty() { text } else { text.replace(change.0, &change.1) });
        let said = left_out(&folder, &format!("-output o.png {arguments}"));
        let expected = format!("{hidden} objects: inside a sphere, with the eye");
        assert_eq!(said.contains("inside a sphere"), hidden > 0, "{change:?} {arguments}: {said}");
        assert!(hidden == 0 || said.contains(&expected), "{change:?} {arguments}: {said}");
    }
}

#[test]
fn what_is_outside_of_a_sphere_around_the_eye_is_left_out() {
    let folder = Folder::new();
    let shells: String = (1..=500).rev().map(|i| format!("Sphere {{ center 0 0 9 radius {i} }} ")).collect();
    let far = "Triangle { vertex0 0 0 -2 vertex1 1 0 -2 vertex2 0 1 -2 } ";
    let crossing = "MaterialIndex 1 Triangle { vertex0 -3 0 8.1 vertex1 1 0 8.1 vertex2 0 1 8.1 } ";
    let materials =
        "numMaterials 2 Material { diffuseColor 1 0.5 0 } Material { diffuseColor 0 1 0 specularColor 1 1 1 }";
    let scene = |objects: &str, count: usize, light: &str| {
        let scene = SCENE.replace("numMaterials 1 Material { }", materials).replace(TRIANGLE, objects);
        scene.replace("numObjects 1", &format!("numObjects {count}")).replace(LIGHT, light)
    };
    let all = format!("{shells}{far}{crossing}");
    let point_light = |at: &str| format!("PointLight {{ position {at} color 1 1 1 falloff 0.1 }}");
    let (near, outside) = (point_light("0.5 0.5 9.2"), point_light("0.5 0.5 11.2"));
    // The eye is 1 away from the centre. The triangle beyond the second shell is outside of it.
    for (light, arguments, hidden) in [
        (near.as_str(), "", 499),
        (&near, "-shadows", 499),
        (&outside, "", 499),
        // The light is inside of the third shell.
        (&outside, "-shadows", 498),
        (LIGHT, "", 499),
        (LIGHT, "-shadows", 0),
        (&near, "-bounces 1", 0),
    ] {
        folder.write("s.txt", scene(&all, 502, light));
        let said = left_out(&folder, &format!("-output o.png {arguments}"));
        let expected = format!("{hidden} objects: outside a sphere, with the eye and all lights inside of it");
        assert_eq!(said.contains("outside a sphere"), hidden > 0, "{light} {arguments}: {said}");
        assert!(hidden == 0 || said.contains(&expected), "{light} {arguments}: {said}");
        let shown: String =
            [3, 2, 1].map(|i| format!("Sphere {{ center 0 0 9 radius {i} }} ")).concat() + crossing;
        let flags = format!("-size 60 60 {arguments}");
        assert!(
            folder.render(&scene(&all, 502, light), &flags) == folder.render(&scene(&shown, 4, light), &flags)
                || hidden == 0,
            "{light} {arguments}"
        );
    }
}

#[test]
fn a_copy_of_a_mesh_file_is_read_once() {
    let folder = Folder::new();
    let other = SQUARE_OBJ.replace("v 1 1 0", "v 1 2 0");
    folder
        .write("a.obj", SQUARE_OBJ)
        .write("b.obj", SQUARE_OBJ)
        .write("c.obj", other)
        .write("d/a.obj", SQUARE_OBJ);
    let mesh = |name: &str| format!("TriangleMesh {{ obj_file {name} }} ");
    let meshes: String = ["a.obj", "b.obj", "c.obj", "d/a.obj", "b.obj"].map(mesh).concat();
    folder.write("s.txt", SCENE.replace(TRIANGLE, &meshes).replace("numObjects 1", "numObjects 5"));
    let report = rendered(&folder.path("s.txt").display().to_string(), "-output o.png");
    let of_mesh: Vec<u32> = report.mesh_files.iter().map(|file| file.mesh).collect();
    assert_eq!(of_mesh, [0, 0, 1, 0]);
    let said = report.left_out.join("\n");
    assert!(said.contains("a second mesh for") && said.contains("b.obj: its bytes are those of"), "{said}");
    // What is read is not written, whatever its name.
    let run = folder.a2("-input s.txt -output b.obj.png -normals d/a.obj");
    assert!(
        run.exit_code != 0 && std::fs::read_to_string(folder.path("d/a.obj")).unwrap() == SQUARE_OBJ,
        "{run:?}"
    );
}
