//! A scene pays only for what it needs: the work that the plan leaves out is really not done.

use crate::support::{Folder, SCENE, options, project};
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
    assert!(run.stderr.contains("front.png: cannot read this picture"), "{}", run.stderr);
    assert!(!folder.path("broken.png").exists());
}

#[test]
fn a_mesh_of_several_instances_is_stored_once() {
    let source = a2::scene_file::parse_file(&project("data/scene04_axes.txt")).unwrap();
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
