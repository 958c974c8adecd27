//! Tests of cost and error of pictures, as files and messages show them: `-report`, `-error-map`, `-target-error` and
//! `-time-limit`. [`convergence`](super::convergence) tests `-convergence`.

use crate::support::{Folder, Run, SCENE, TRIANGLE, project};
use serde_json::Value;
use std::collections::BTreeMap;
use std::time::Instant;

/// Returns the arguments of a scene of the project with a mirror, shadows and a cube map.
fn mirror_bunny() -> String {
    format!("-input {} -bounces 4 -shadows", project("data/scene06_bunny_1k.txt").display())
}

pub fn succeeds(folder: &Folder, arguments: &str) -> Run {
    ends_with(0, folder, arguments)
}

fn ends_with(exit_code: i32, folder: &Folder, arguments: &str) -> Run {
    let run = folder.a2(arguments);
    assert_eq!(run.exit_code, exit_code, "{arguments}: {}", run.stderr);
    run
}

/// Runs a2 with `-report` and reads the report.
fn report(folder: &Folder, arguments: &str) -> Value {
    succeeds(folder, &format!("{arguments} -report report.json"));
    folder.json("report.json")
}

/// Collects every key of a report as a path (`rays.camera`) with the type of its value. A list counts as one value.
fn keys(value: &Value, path: &str, found: &mut BTreeMap<String, &'static str>) {
    let kind = match value {
        Value::Object(members) => {
            for (key, member) in members {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                keys(member, &path, found);
            }
            return;
        }
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(_) => "number",
        Value::String(_) => "text",
        Value::Array(_) => "list",
    };
    found.insert(path.to_owned(), kind);
}

/// The keys of a report whose estimate and true error are known.
const KEYS: &str = "a2:text scene:text width:number height:number
    region.x:number region.y:number region.width:number region.height:number threads:number seed:number
    phases.parse.wall_seconds:number phases.parse.cpu_seconds:number
    phases.load.wall_seconds:number phases.load.cpu_seconds:number
    phases.build.wall_seconds:number phases.build.cpu_seconds:number
    phases.render.wall_seconds:number phases.render.cpu_seconds:number
    phases.filter.wall_seconds:number phases.filter.cpu_seconds:number
    phases.encode.wall_seconds:number phases.encode.cpu_seconds:number
    total.wall_seconds:number total.cpu_seconds:number
    rays.camera:number rays.shadow:number rays.mirror:number rays.total:number rays.shadow_left_out:number
    rays.million_per_second:number peak_memory_bytes:number cube_map_faces_decoded:number left_out:list pixels:list depth_range:null cost:null
    samples.sampler:text samples.per_pixel_least:number samples.per_pixel_mean:number samples.per_pixel_most:number
    samples.passes:number samples.share_of_pixels_reached:number samples.target_error_levels:null samples.target_error_reached:null
    samples.time_limit_seconds:null
    estimated_error.levels.rmse:number estimated_error.levels.low_95:number estimated_error.levels.high_95:number
    estimated_error.unseen_levels_95:number
    estimated_error.linear.rmse:number estimated_error.linear.low_95:number estimated_error.linear.high_95:number
    meshes:list true_error.rmse_levels:number true_error.rmse_linear:number true_error.relative_mse:number
    true_error.relative_mse_epsilon:number true_error.psnr_db:number true_error.ssim:number
    true_error.worst_levels:number true_error.worst_pixel:list
    true_error.share_over_1_level:number";

#[test]
fn a_report_has_every_key_with_a_plausible_value() {
    let folder = Folder::new();
    succeeds(&folder, &format!("{} -size 24 18 -output reference.png", mirror_bunny()));
    let flags = "-size 24 18 -jitter -seed 3 -threads 2 -output o.png -reference reference.png";
    let report = report(&folder, &format!("{} {flags}", mirror_bunny()));
    let mut found = BTreeMap::new();
    keys(&report, "", &mut found);
    let mut expected: BTreeMap<String, &str> = KEYS
        .split_whitespace()
        .map(|key| key.split_once(':').unwrap())
        .map(|(key, kind)| (key.into(), kind))
        .collect();
    if cfg!(not(target_os = "linux")) {
        expected.insert("peak_memory_bytes".into(), found["peak_memory_bytes"]);
    }
    assert_eq!(found, expected);

    let number = |path: &str| report.pointer(&format!("/{}", path.replace('.', "/"))).unwrap().as_f64().unwrap();
    assert_eq!(report["a2"], env!("CARGO_PKG_VERSION"));
    assert!(report["scene"].as_str().unwrap().ends_with("scene06_bunny_1k.txt"));
    let camera = 24.0 * 18.0 * 16.0;
    for (path, value) in [
        ("width", 24.0),
        ("height", 18.0),
        ("threads", 2.0),
        ("seed", 3.0),
        ("rays.camera", camera),
        ("samples.per_pixel_mean", 16.0),
    ] {
        assert_eq!(number(path), value, "{path}");
    }
    assert!(
        number("rays.shadow") > 100.0 && number("rays.mirror") > 100.0 && number("rays.shadow_left_out") > 0.0
    );
    assert_eq!(number("rays.total"), camera + number("rays.shadow") + number("rays.mirror"));
    assert!((1.0..=6.0).contains(&number("cube_map_faces_decoded")));
    let phases = ["parse", "load", "build", "render", "filter", "encode"];
    let sum: f64 = phases.iter().map(|phase| number(&format!("phases.{phase}.wall_seconds"))).sum();
    assert!(number("phases.render.wall_seconds") > 0.0 && sum <= number("total.wall_seconds"), "{sum}");
    for of in ["estimated_error.levels", "estimated_error.linear"] {
        let [low, rmse, high] = ["low_95", "rmse", "high_95"].map(|key| number(&format!("{of}.{key}")));
        assert!(0.0 < low && low < rmse && rmse < high, "{of}: {low} {rmse} {high}");
    }
    // The reference has one sample a pixel, in its corner.
    let rmse = number("true_error.rmse_levels");
    assert!(rmse > 1.0 && number("true_error.worst_levels") > rmse);
    assert!((number("true_error.psnr_db") - 20.0 * (255.0 / rmse).log10()).abs() < 1e-9);
}

#[test]
fn a_report_of_a_part_says_which() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    for (flags, expected) in [
        ("", [0, 0, 9, 10]),
        ("-tile 2/3", [0, 3, 9, 3]),
        ("-tile 20/20", [4, 9, 5, 1]),
        ("-region 1 2 4 3", [1, 2, 4, 3]),
    ] {
        let report = report(&folder, &format!("-input s.txt -size 9 10 -output o.png {flags}"));
        let found = ["x", "y", "width", "height"].map(|key| report["region"][key].as_u64().unwrap());
        assert_eq!(found, expected, "{flags}");
        // Width and height are those of the whole picture.
        assert_eq!((report["width"].as_u64(), report["height"].as_u64()), (Some(9), Some(10)), "{flags}");
        let picture = folder.picture("o.png");
        assert_eq!([picture.width(), picture.height()].map(u64::from), expected[2..], "{flags}");
    }
}

#[test]
fn a_report_says_null_where_nothing_is_known() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    let report = report(&folder, "-input s.txt -size 9 9 -output o.png");
    for key in ["/true_error", "/estimated_error", "/samples/sampler"] {
        assert_eq!(report.pointer(key), Some(&Value::Null), "{key}");
    }
    let reasons: Vec<&str> =
        report["left_out"].as_array().unwrap().iter().map(|line| line.as_str().unwrap()).collect();
    assert!(reasons.iter().any(|reason| reason.starts_with("shadow rays: ")), "{reasons:?}");
}

/// Mirrors that brighten have no finite bound. No error that is shown is above 255 levels.
#[test]
fn the_upper_end_of_the_error_holds_for_any_brightness() {
    let folder = Folder::new();
    for (color, size, samples) in [
        ("1e308 1e308 1e308", 9, "-samples 4"),
        ("1e30 1 1", 9, "-target-error 300"),
        ("1e308 0 0", 1, "-samples 2"),
    ] {
        let material = "Material { specularColor 9 9 9 }";
        let scene = SCENE.replace("color 1 1 1", &format!("color {color}")).replace("Material { }", material);
        folder.write("s.txt", scene);
        let report =
            report(&folder, &format!("-input s.txt -bounces 1000 -size {size} {size} {samples} -output o.png"));
        let [levels, linear] = ["levels", "linear"].map(|of| &report["estimated_error"][of]["high_95"]);
        assert_eq!((levels.as_f64(), linear), (Some(255.0), &Value::Null), "{color} {report}");
    }
}

#[test]
fn an_error_map_is_bright_along_edges_and_never_black() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    for sampler in ["stratified", "sobol", "independent"] {
        let flags = format!("-samples 16 -sampler {sampler}");
        succeeds(&folder, &format!("-input s.txt -size 40 40 {flags} -output o.png -error-map e.png"));
        let (map, picture) = (folder.picture("e.png"), folder.picture("o.png"));
        assert_eq!(map.dimensions(), (40, 40));
        // A white triangle on black: a pixel at the edge has samples of both.
        let is_edge = |x: u32, y: u32| !matches!(picture.get_pixel(x, y).0, [0, 0, 0] | [255, 255, 255]);
        let (mut edges, mut bright) = (0, 0);
        for (x, y, error) in map.enumerate_pixels() {
            // In sixteenths of a level.
            let is_bright = error.0[0] >= 16;
            let near = |at: u32| at.saturating_sub(1)..(at + 2).min(40);
            let has_edge_near = near(y).any(|y| near(x).any(|x| is_edge(x, y)));
            assert!(has_edge_near || !is_bright, "{sampler}: {x} {y} {error:?}");
            assert!(error.0[0] > 0, "{sampler}: samples that agree prove nothing: {x} {y}");
            edges += u32::from(is_edge(x, y));
            bright += u32::from(is_edge(x, y) && is_bright);
        }
        assert!(edges > 20 && bright > edges * 3 / 4, "{sampler}: {bright} of {edges}");
    }
}

#[test]
fn a_target_error_is_stated_reached_and_true() {
    let folder = Folder::new();
    succeeds(
        &folder,
        &format!("{} -size 30 30 -samples 1024 -seed 7 -sampler sobol -output truth.pfm -quiet", mirror_bunny()),
    );
    let flags = "-size 30 30 -target-error 3 -output o.png -reference truth.pfm";
    let report = report(&folder, &format!("{} {flags}", mirror_bunny()));
    let samples = &report["samples"];
    assert_eq!((&samples["target_error_reached"], &samples["sampler"]), (&Value::Bool(true), &"sobol".into()));
    assert_eq!(samples["target_error_levels"], 3.0);
    assert!(samples["passes"].as_u64() > Some(0));
    assert!(samples["per_pixel_most"].as_u64() > samples["per_pixel_least"].as_u64());
    assert!(report["estimated_error"]["levels"]["rmse"].as_f64() <= Some(3.0));
    let rmse = report["true_error"]["rmse_levels"].as_f64().unwrap();
    assert!((1.0..4.5).contains(&rmse), "{rmse}");

    let run = succeeds(&folder, &format!("{} -size 30 30 -target-error 3 -output o.png", mirror_bunny()));
    assert!(run.stderr.starts_with("estimated    RMSE "), "{}", run.stderr);
}

#[test]
fn a_target_error_that_is_not_reached_is_a_warning_and_an_exit_code() {
    let folder = Folder::new();
    let flags = "-size 30 30 -target-error 0.001 -time-limit 0.1 -output o.png -report report.json";
    let run = ends_with(3, &folder, &format!("{} {flags}", mirror_bunny()));
    assert!(run.stderr.contains("warning: the target error of 0.001 levels was not reached"), "{}", run.stderr);
    let report = folder.json("report.json");
    assert_eq!(report["samples"]["target_error_reached"], false);
}

#[test]
fn a_time_limit_is_used_and_kept() {
    let folder = Folder::new();
    let report =
        report(&folder, &format!("{} -size 60 60 -samples 20000 -time-limit 0.4 -output o.png", mirror_bunny()));
    assert_eq!(report["samples"]["time_limit_seconds"], 0.4);
    let seconds = report["total"]["wall_seconds"].as_f64().unwrap();
    // Five times the limit, for machines under load.
    assert!((0.2..2.0).contains(&seconds), "{seconds}");
    let samples = report["samples"]["per_pixel_mean"].as_f64().unwrap();
    assert!((1.0..20000.0).contains(&samples), "{samples}");
    assert!(report["estimated_error"]["levels"]["rmse"].as_f64() > Some(0.0));
    assert_eq!(folder.picture("o.png").dimensions(), (60, 60));
}

#[test]
fn without_samples_a_time_limit_is_used_up() {
    let folder = Folder::new();
    let scene = mirror_bunny();
    let run = |flags: &str| report(&folder, &format!("{scene} -size 60 60 -time-limit 0.6 -output o.png {flags}"));
    let mean = |report: &serde_json::Value| report["samples"]["per_pixel_mean"].as_f64().unwrap();
    let sampled = run("");
    assert!(mean(&sampled) > 16.0, "{}", mean(&sampled));
    assert!(sampled["total"]["wall_seconds"].as_f64() > Some(0.3), "{}", sampled["total"]["wall_seconds"]);
    assert_eq!(mean(&run("-samples 8")), 8.0);
}

#[test]
fn a_time_limit_that_reading_exceeds_is_a_warning() {
    let folder = Folder::new();
    let run =
        ends_with(3, &folder, &format!("{} -size 30 30 -time-limit 1e-7 -output o.png -quiet", mirror_bunny()));
    let warning = "warning: reading the scene and its files took 0.";
    assert!(run.stderr.contains(warning) && run.stderr.contains("more than -time-limit 1e-7\n"), "{}", run.stderr);
}

/// A large picture of numbers takes long to write, and no second to write 48 MB.
#[test]
fn a_time_limit_leaves_the_time_that_writing_takes() {
    let folder = Folder::new();
    let scene = project("data/scene07_arch.txt");
    let start = Instant::now();
    let flags = "-size 2000 2000 -samples 20000 -time-limit 1 -output o.pfm -quiet";
    let run = folder.a2(&format!("-input {} {flags}", scene.display()));
    let seconds = start.elapsed().as_secs_f64();
    assert!([0, i32::from(a2::INCOMPLETE)].contains(&run.exit_code), "{}", run.stderr);
    // Three times the limit, for machines under load.
    assert!((0.6..3.0).contains(&seconds), "{seconds}");
    assert_eq!(std::fs::metadata(folder.path("o.pfm")).unwrap().len(), 12 * 2000 * 2000 + 18);
}

/// Between two mirrors a tile of paths of 100,000 bounces takes longer than the limit, the picture many seconds.
#[test]
fn a_time_limit_interrupts_long_mirror_paths() {
    let folder = Folder::new();
    // Ambient light is 1 without lights. A path of n mirrors has a colour of (n + 1) / 1,000,000.
    folder.write(
        "s.txt",
        "PerspectiveCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 angle 10 }
        Materials { numMaterials 1 Material { diffuseColor 1e-6 1e-6 1e-6 specularColor 1 1 1 } }
        Group { numObjects 2 MaterialIndex 0 Plane { normal 0 0 1 offset -5 } Plane { normal 0 0 -1 offset -5 } }",
    );
    for flags in ["-bounces 100000", "-bounces 20000", "-bounces 100000 -plain"] {
        let line = format!("-input s.txt -size 100 100 {flags} -time-limit 0.3 -output o.png -report report.json");
        let start = Instant::now();
        let run = ends_with(3, &folder, &line);
        let seconds = start.elapsed().as_secs_f64();
        // Five times the limit, for machines under load.
        assert!(seconds < 1.5, "{flags}: {seconds} s");
        assert!(run.stderr.contains("% of the pixels were not reached in time"), "{}", run.stderr);
        // A path that was cut short would lie between a preview of 16 mirrors and a whole path.
        let whole = if flags.contains("20000") { 5 } else { 25 };
        let picture = folder.picture("o.png");
        let count = |byte: u8| picture.pixels().filter(|pixel| pixel.0 == [byte; 3]).count();
        assert_eq!(count(0) + count(whole), 100 * 100, "{flags}");
        assert!(count(0) > 0, "{flags}: everything was reached");
        let report = folder.json("report.json");
        assert_eq!(report["samples"]["per_pixel_least"], 0, "{flags}");
        let reached = report["samples"]["share_of_pixels_reached"].as_f64().unwrap();
        assert!((reached - count(whole) as f64 / 1e4).abs() < 1e-9, "{flags}: {reached}");
        // Pixels that nothing reached may be black or white.
        let levels = &report["estimated_error"]["levels"];
        assert!(levels["rmse"].as_f64() > Some(0.0), "{flags}: {levels}");
        assert!(levels["high_95"].as_f64() > Some(255.0 * (1.0 - reached).sqrt() - 1e-9), "{flags}: {levels}");
    }
}

#[test]
fn an_epsilon_is_where_shadow_rays_start() {
    // A triangle is at a distance of 1 from a wall. A shadow ray that starts 3 off the wall starts beyond the
    // triangle.
    let folder = Folder::new();
    let wall = "Triangle { vertex0 -90 -90 -1 vertex1 90 -90 -1 vertex2 0 90 -1 }";
    let light = "DirectionalLight { direction 0 -2 -1 color 1 1 1 }";
    let scene = SCENE
        .replace("numObjects 1", "numObjects 2")
        .replace(TRIANGLE, &format!("{TRIANGLE} {wall}"))
        .replace(crate::support::LIGHT, light);
    folder.write("s.txt", scene);
    let lit = |flags: &str| {
        succeeds(&folder, &format!("-input s.txt -size 61 61 -shadows {flags} -output o.png"));
        folder.picture("o.png").pixels().filter(|pixel| pixel.0 != [0, 0, 0]).count()
    };
    let usual = lit("");
    assert_eq!(lit("-epsilon 0.01"), usual);
    assert_eq!(lit("-epsilon auto"), usual);
    let far = lit("-epsilon 3");
    assert!(far > usual + 20, "{usual} lit pixels, {far} with an epsilon of 3");
}
