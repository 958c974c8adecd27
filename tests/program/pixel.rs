//! `-pixel`: the ray tree of a pixel, as text and in `-report`.

use crate::measuring::succeeds;
use crate::support::{Folder, SQUARE_OBJ, project};
use serde_json::Value;

/// The eye looks at a mirror from a distance of 1. A ball hides it from the second light.
const MIRROR: &str = "PerspectiveCamera { center 0 0 1 direction 0 0 -1 up 0 1 0 angle 90 }
Lights { numLights 2
    DirectionalLight { direction -3 0 -4 color 0.5 0.5 0.5 }
    PointLight { position 0.5 0 2 color 1 1 1 falloff 0.25 } }
Background { color 0 0 1 ambientLight 0.1 0.1 0.1 }
Materials { numMaterials 2
    Material { diffuseColor 0.5 0 0 specularColor 0.25 0.25 0.25 shininess 1 }
    Material { } }
Group { numObjects 2
    MaterialIndex 0
    TriangleMesh { obj_file square.obj }
    MaterialIndex 1
    Sphere { center 0.5 0 0.5 radius 0.125 } }
";

/// Makes a folder with the scene.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("s.txt", MIRROR).write("square.obj", SQUARE_OBJ);
    folder
}

fn report(folder: &Folder, flags: &str) -> Value {
    succeeds(folder, &format!("-input s.txt -size 5 5 -report r.json {flags}"));
    folder.json("r.json")
}

/// The ray through column 3 hits the mirror at 0.5 0 0, where the first light comes in at a cosine of 0.8, and goes on
/// to the background.
#[test]
fn a_pixel_is_told_step_by_step() {
    let folder = folder();
    let run = succeeds(&folder, "-input s.txt -size 5 5 -shadows -bounces 2 -pixel 3 2");
    let expected = "\
pixel 3 2 of 5 x 5: bytes 95 31 95, colour 0.372984 0.122984 0.372984
  camera ray from 0 0 1 along 0.447214 0 -0.894427
    hits TriangleMesh s.txt:11:5 (triangle 0 of square.obj, line 5) at t = 1.11803
    point 0.5 0 0, normal 0 0 1
    material 0, Material s.txt:7:5: diffuseColor 0.5 0 0, specularColor 0.25 0.25 0.25, shininess 1
    DirectionalLight s.txt:3:5
      N.L 0.8, R.L 0.98387, infinitely far, intensity 0.5 0.5 0.5
      diffuse 0.2 0 0, highlight 0.122984 0.122984 0.122984
      nothing blocks it: adds 0.322984 0.122984 0.122984
    PointLight s.txt:4:5
      N.L 1, R.L 0.894427, distance 2, intensity 1 1 1
      diffuse 0.5 0 0, highlight 0.223607 0.223607 0.223607
      blocked by Sphere s.txt:13:5 at t = 0.365: adds 0 0 0
    ambient light times diffuseColor: 0.05 0 0
    all lights together: 0.372984 0.122984 0.122984
  mirror ray 1 of at most 2 from 0.504472 0 0.00894427 along 0.447214 0 0.894427
    throughput 0.25 0.25 0.25: this share of what it sees reaches the eye
    hits nothing, and sees the background: 0 0 1
    times the throughput: 0 0 0.25
  end: the ray leaves the scene
  sum: 0.372984 0.122984 0.372984
";
    assert_eq!(run.stdout, expected);
    assert_eq!(run.stderr, "");
    assert_eq!(folder.files(), ["s.txt", "square.obj"]);
}

/// Returns the block of `docs/pixel.md` that follows a mark.
fn block(page: &str, mark: &str) -> String {
    let block = page.split_once(&format!("<!-- {mark} -->\n```")).expect("docs/pixel.md has this block").1;
    block.split_once('\n').unwrap().1.split_once("```").unwrap().0.to_owned()
}

#[test]
fn the_page_shows_what_the_program_prints() {
    let page = std::fs::read_to_string(project("docs/pixel.md")).unwrap();
    let folder = Folder::new();
    folder.write("lamp.txt", block(&page, "scene"));
    let command = block(&page, "command");
    let run = succeeds(&folder, command.trim().strip_prefix("a2 ").unwrap());
    assert_eq!(run.stdout, block(&page, "output"));
}

#[test]
fn a_report_holds_the_same_numbers() {
    let report = report(&folder(), "-shadows -bounces 2 -pixel 3 2 -pixel 0 0 -output o.png -depth 0 2 d.png");
    let pixels = report["pixels"].as_array().unwrap();
    assert_eq!(pixels.len(), 2);
    let (first, path) = (&pixels[0], &pixels[0]["path"]);
    assert_eq!((&first["x"], &first["y"], &first["depth_byte"]), (&3.into(), &2.into(), &142.into()));
    assert_eq!(first["normal_bytes"], Value::Null);
    let surface = &path[0]["surface"];
    assert_eq!(surface["object"]["triangle"]["line"], 5);
    assert_eq!(surface["material"]["line"], 7);
    let lights = surface["lights"].as_array().unwrap();
    assert_eq!((&lights[0]["shadow"], &lights[1]["shadow"]), (&"free".into(), &"blocked".into()));
    assert_eq!(lights[0]["distance"], Value::Null, "it is infinite");
    let blocker = &lights[1]["blocked_by"];
    assert_eq!((&blocker["object"]["block"], &blocker["object"]["line"]), (&"Sphere".into(), &13.into()));
    assert!((blocker["t"].as_f64().unwrap() - 0.365).abs() < 1e-12);
    assert_eq!((&path[1]["ray"], &path[1]["background"][2]), (&"mirror".into(), &1.0.into()));
    let triangle = &pixels[1]["path"][0]["surface"]["object"]["triangle"];
    assert_eq!(triangle, &serde_json::json!({ "file": "square.obj", "number": 1, "line": 6 }));
}

#[test]
fn the_sample_nearest_to_the_place_is_shown() {
    let report = report(&folder(), "-jitter -filter -pixel 3 2 -pixel 3.05 2.95 -pixel 3.9 2");
    for (pixel, (x, y)) in report["pixels"].as_array().unwrap().iter().zip([(3.5, 2.5), (3.05, 2.95), (3.9, 2.5)])
    {
        assert_eq!((&pixel["x"], &pixel["y"]), (&3.into(), &2.into()));
        let samples = pixel["samples"].as_array().unwrap();
        assert_eq!(samples.len(), 144);
        let distance = |sample: &Value| {
            let [x_place, y_place] = ["x", "y"].map(|axis| sample[axis].as_f64().unwrap());
            assert!((3.0..4.0).contains(&x_place) && (2.0..=3.0).contains(&y_place), "{sample}");
            (x_place - x).hypot(y_place - y)
        };
        let chosen = distance(&samples[pixel["sample"].as_u64().unwrap() as usize]);
        assert!(chosen < 0.1 && samples.iter().all(|sample| distance(sample) >= chosen), "{x} {y}: {chosen}");
    }
    let run = succeeds(&folder(), "-input s.txt -size 5 5 -jitter -pixel 3 2");
    assert!(run.stdout.contains("\n  16 samples, whose colours lie between "), "{}", run.stdout);
}

#[test]
fn why_a_path_ends_is_told() {
    let folder = folder();
    folder.write(
        "between.txt",
        "PerspectiveCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 angle 10 }
        Materials { numMaterials 1 Material { specularColor 0.2 0.2 0.2 } }
        Group { numObjects 2 MaterialIndex 0 Plane { normal 0 0 1 offset -5 } Plane { normal 0 0 -1 offset -5 } }",
    );
    folder.write("bright.txt", MIRROR.replace("specularColor 0.25 0.25 0.25", "specularColor 0.06 0.06 0.05"));
    for (arguments, end) in [
        ("-input s.txt -pixel 3 2", "the surface is a mirror, but -bounces is 0"),
        ("-input s.txt -pixel 3 2 -bounces 4", "the ray leaves the scene"),
        (
            "-input between.txt -pixel 2 2 -bounces 100",
            "what a further mirror ray sees is too dark to change the sum",
        ),
        (
            "-input bright.txt -pixel 3 2 -bounces 4",
            "the surface is no mirror: its specularColor is not longer than 0.1",
        ),
    ] {
        let run = succeeds(&folder, &format!("{arguments} -size 5 5"));
        assert!(run.stdout.contains(&format!("\n  end: {end}\n")), "{arguments}: {}", run.stdout);
    }
}

#[test]
fn a_pixel_that_is_none_is_refused() {
    let folder = folder();
    for (flags, part) in [
        ("-pixel 5 0", "5 0 lies beyond the picture, whose pixels are 0 0 to 4 4 (-size 5 5)"),
        ("-pixel 0 0 -pixel 0 7.5", "0 7 lies beyond"),
        ("-pixel -1 0", "expected two numbers from 0 to 65535, found '-1'"),
        ("-pixel 0 nan", "expected two numbers from 0 to 65535, found 'nan'"),
        ("-pixel 3", "-pixel needs 2 values: -pixel X Y"),
        ("-pixel 3 2 -output o.png -target-error 4", "does not go with -target-error"),
    ] {
        let run = folder.a2(&format!("-input s.txt -size 5 5 {flags}"));
        assert_eq!((run.exit_code, run.stdout.as_str()), (2, ""), "{flags}");
        assert!(run.stderr.contains(part), "{flags}: {}", run.stderr);
    }
    assert_eq!(folder.files(), ["s.txt", "square.obj"]);
}
