//! `-cost`: the picture of what pixels cost, and the numbers in `-stats` and `-report`.

use crate::measuring::succeeds;
use crate::support::{Folder, SCENE, SQUARE_OBJ, TRIANGLE, project};
use serde_json::Value;

fn report(folder: &Folder, arguments: &str) -> Value {
    succeeds(folder, &format!("{arguments} -report r.json"));
    folder.json("r.json")
}

/// A box around the triangle is tested by every ray. The triangle is tested by those that enter it, and by their shadow
/// rays.
#[test]
fn what_is_counted_is_what_is_tested() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    let report = report(&folder, "-input s.txt -size 41 41 -shadows -cost c.png -output o.png");
    let picture = folder.picture("o.png");
    let lit = picture.pixels().filter(|pixel| pixel.0 == [255; 3]).count() as u64;
    let pixels = 41 * 41;
    assert!(lit > 50, "{lit}");
    let cost = &report["cost"];
    assert_eq!((&cost["rays"], &cost["boxes"]), (&(pixels + lit).into(), &(pixels + lit).into()));
    assert_eq!(report["rays"]["total"], cost["rays"], "the picture takes as many rays");
    let triangle = &cost["objects"]["Triangle"];
    assert_eq!(triangle["hits"], lit, "no shadow ray hits it");
    assert_eq!((&triangle["tests"], &cost["triangles"]), (&cost["exact_triangles"], &cost["exact_triangles"]));
    assert!(cost["triangles"].as_u64() > Some(lit) && cost["triangles"].as_u64() < Some(pixels + lit));
    assert_eq!((&cost["a_pixel"]["rays"]["most"], &cost["a_pixel"]["boxes"]["most"]), (&2.into(), &2.into()));
}

/// With and without a tree: each of 400 squares has a box, and a ray that goes through one of them is spared most of the
/// others.
#[test]
fn a_tree_spares_boxes_and_triangles() {
    let folder = Folder::new();
    let squares = |count: u32| {
        let square = |i: u32| {
            let (x, y) = (f64::from(i % 20) - 9.5, f64::from(i / 20) - 9.5);
            let corners = [(-0.4, -0.4), (0.4, -0.4), (0.4, 0.4), (-0.4, 0.4)];
            corners.map(|(dx, dy)| format!("v {} {} 0\n", x + dx, y + dy)).concat()
        };
        let faces = |i: u32| {
            format!("f {} {} {}\nf {} {} {}\n", 4 * i + 1, 4 * i + 2, 4 * i + 3, 4 * i + 1, 4 * i + 3, 4 * i + 4)
        };
        (0..count).map(square).chain((0..count).map(faces)).collect::<String>()
    };
    folder.write("m.obj", squares(400)).write("s.txt", SCENE.replace(TRIANGLE, "TriangleMesh { obj_file m.obj }"));
    let report = report(&folder, "-input s.txt -size 40 40 -cost c.png");
    let cost = &report["cost"];
    let mean = |what: &str| cost["a_pixel"][what]["mean"].as_f64().unwrap();
    assert_eq!(mean("rays"), 1.0);
    assert!((8.0..60.0).contains(&mean("boxes")), "{cost}");
    assert!((1.0..40.0).contains(&mean("triangles")), "{cost}");
    assert!(cost["exact_triangles"].as_u64() < cost["triangles"].as_u64(), "{cost}");
    let mesh = &cost["objects"]["TriangleMesh"];
    assert!(mesh["tests"].as_u64() >= mesh["hits"].as_u64() && mesh["hits"].as_u64() > Some(400), "{cost}");
}

#[test]
fn the_picture_has_three_panels_with_a_legend_each() {
    let folder = Folder::new();
    folder.write("square.obj", SQUARE_OBJ);
    folder.write("s.txt", SCENE.replace(TRIANGLE, "TriangleMesh { obj_file square.obj }"));
    let run = succeeds(&folder, "-input s.txt -size 50 40 -shadows -cost c.png -stats");
    assert!(run.stderr.contains("cost         a pixel takes 1.0"), "{}", run.stderr);
    assert!(run.stderr.contains("\n             TriangleMesh: "), "{}", run.stderr);
    let picture = folder.picture("c.png");
    // Enlarged four times, with margins of 10, two lines of text above, and a bar and a line below.
    assert_eq!(picture.dimensions(), (3 * 200 + 4 * 10, 2 * 10 + 2 * 15 + 160 + 10 + 14 + 15));
    let panel = |index: u32, x: u32, y: u32| picture.get_pixel(10 + 210 * index + x, 40 + y).0;
    // A corner takes one ray, the middle two, which is the end of the legend.
    let (corner, middle) = (panel(0, 0, 0), panel(0, 100, 80));
    assert_eq!(middle, [255, 250, 200]);
    assert!(corner != middle && corner != [0; 3], "{corner:?}");
    // Only the middle takes triangles.
    assert_eq!((panel(2, 0, 0), panel(2, 100, 80)), ([0; 3], [255, 250, 200]));
    // The legend goes from black to that.
    assert_eq!((panel(1, 0, 175), panel(1, 199, 175)), ([0; 3], [255, 250, 200]));
}

#[test]
fn costs_are_the_same_with_all_threads_and_instruction_sets() {
    let folder = Folder::new();
    let scene = format!("-input {} -size 40 30 -bounces 3 -shadows", project("data/scene07_arch.txt").display());
    let first = report(&folder, &format!("{scene} -cost a.png -threads 1"));
    for set in crate::numbers::instruction_sets(&folder) {
        let other = report(&folder, &format!("{scene} -cost b.png -threads 3 -simd {set}"));
        assert_eq!(other["cost"], first["cost"], "{set}");
        assert!(
            std::fs::read(folder.path("a.png")).unwrap() == std::fs::read(folder.path("b.png")).unwrap(),
            "{set}"
        );
    }
}

#[test]
fn a_cost_without_known_samples_is_refused() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    let run = folder.a2("-input s.txt -output o.png -time-limit 1 -cost c.png");
    assert_eq!(run.exit_code, 2);
    assert!(run.stderr.contains("-cost: does not go with -target-error"), "{}", run.stderr);
    assert_eq!(folder.a2("-input s.txt -cost c.jpg").exit_code, 2);
    assert_eq!(folder.files(), ["s.txt"]);
}
