//! Tests of the memory that a run may take: what is estimated and refused, and what happens where it cannot be had.
#![cfg(target_os = "linux")]

use crate::faults::{folder_with_scene, with_limit};
use crate::support::{SCENE, TRIANGLE};
use image::RgbImage;

#[test]
fn what_does_not_fit_into_memory_is_refused() {
    let folder = folder_with_scene();
    folder.write("m.obj", "v 0 0 0\n".repeat(9_000_000));
    folder.write("mesh.txt", SCENE.replace(TRIANGLE, "TriangleMesh { obj_file m.obj }"));
    // With an error map, the whole pictures stay in memory.
    let large = "-input s.txt -output o.png -error-map e.png -size 10000 10000";
    for (limit, arguments, parts) in [
        ("-v 500000", large, ["the pictures need about 779.0 MiB", "'ulimit -v'"]),
        (
            "-v unlimited",
            &format!("{large} -max-memory 500M"),
            ["779.0 MiB of memory, and 500.0 MiB", "-max-memory"],
        ),
        ("-v 250000", "-input mesh.txt -output o.png", ["the pictures and meshes need about", "'ulimit -v'"]),
        ("-v unlimited", "-input mesh.txt -output o.png -max-memory 50M", ["50.0 MiB can be had", "-max-memory"]),
    ] {
        let run = with_limit(&folder, limit, arguments);
        assert_eq!(run.exit_code, 1, "{arguments}: {}", run.stderr);
        assert!(parts.iter().all(|part| run.stderr.contains(part)), "{arguments}: {}", run.stderr);
    }
    assert_eq!(folder.files(), ["m.obj", "mesh.txt", "s.txt"]);
}

/// What is not the picture itself counts, too: less is accepted than the run then takes.
#[test]
fn all_that_is_large_is_estimated() {
    let folder = folder_with_scene();
    let sky = RgbImage::from_fn(1500, 1500, |x, y| image::Rgb([x as u8, y as u8, 200]));
    sky.save(folder.write("sky/x", "").path("sky/up.png")).unwrap();
    for face in ["right", "left", "down", "front", "back"] {
        std::fs::copy(folder.path("sky/up.png"), folder.path(&format!("sky/{face}.png"))).unwrap();
    }
    folder.write("sky.txt", SCENE.replace("Background {", "Background { cubeMap sky "));
    let short_faces: String = (3..100_000).map(|i| format!("f {} {} {}\n", 1 + i % 7, 8 + i % 2, 10)).collect();
    let vertices: String = (0..10).map(|i| format!("v {} {} {}\n", i % 3, i % 4, i * i % 5)).collect();
    folder.write("m.obj", vertices + &short_faces);
    folder.write("mesh.txt", SCENE.replace(TRIANGLE, "TriangleMesh { obj_file m.obj }"));
    for (arguments, memory, content) in [
        ("-input sky.txt -output o.png", "35M", "the pictures and the cube map need about 58.0 MiB"),
        ("-input mesh.txt -output o.png", "13M", "the pictures and meshes need about 14."),
        (
            "-input s.txt -output o.png -size 1500 1500 -reference sky/up.png",
            "92M",
            "the pictures need about 108.4 MiB",
        ),
        ("-input s.txt -output o.png -size 1500 1500 -error-map e.png", "30M", "the pictures need about 32.2 MiB"),
        ("-input s.txt -output o.png", "2k", "29.3 KiB of memory, and 2.0 KiB can be had (-max-memory)"),
    ] {
        let run = folder.a2(&format!("{arguments} -max-memory {memory}"));
        assert_eq!(run.exit_code, 1, "{arguments}: {}", run.stderr);
        assert!(run.stderr.contains(content), "{arguments}: {}", run.stderr);
        let run = folder.a2(&format!("{arguments} -max-memory 130M -report r.json"));
        assert_eq!(run.exit_code, 0, "{arguments}: {}", run.stderr);
    }
    for (limit, arguments, content) in [
        ("-v 40000", "-compare sky/up.png sky/down.png -diff d.png", "the pictures need about"),
        ("-d 40000", "-input s.txt -output o.png -size 1500 1500 -target-error 1", "'ulimit -d'"),
    ] {
        let run = with_limit(&folder, limit, arguments);
        assert_eq!(run.exit_code, if arguments.contains("-compare") { 2 } else { 1 }, "{}", run.stderr);
        assert!(run.stderr.contains("error: ") && run.stderr.contains(content), "{}", run.stderr);
    }
}

/// Nothing estimates the memory for the text of a scene.
#[test]
fn memory_that_cannot_be_had_is_an_error() {
    let folder = folder_with_scene();
    let spheres = "Sphere { center 0 0 0 radius 1 }\n".repeat(200_000);
    folder.write("many.txt", SCENE.replace("numObjects 1", "numObjects 200000").replace(TRIANGLE, &spheres));
    let mut refused = 0;
    for limit in (40..=240).step_by(40) {
        for which in ["-v", "-d"] {
            let limit = format!("{which} {limit}000");
            let run = with_limit(&folder, &limit, "-input many.txt -output o.png -size 3 3");
            if run.exit_code != 0 {
                assert_eq!(run.exit_code, 1, "{limit}: {}", run.stderr);
                let last = run.stderr.lines().last().unwrap_or_default();
                assert!(last.starts_with("error: not enough memory ('ulimit -v' and"), "{}", run.stderr);
                refused += 1;
            }
            let _ = std::fs::remove_file(folder.path("o.png"));
            assert_eq!(folder.files(), ["many.txt", "s.txt"], "{limit}");
        }
    }
    assert!((3..12).contains(&refused), "{refused}");
}

#[test]
fn a_higher_picture_needs_no_more_memory() {
    let folder = folder_with_scene();
    let peak = |pictures: &str, height: u32, threads: u32| {
        let flags = format!("-size 3000 {height} -threads {threads} -report r.json -max-memory 40M");
        let run = folder.a2(&format!("-input s.txt {pictures} {flags}"));
        assert_eq!(run.exit_code, 0, "{}", run.stderr);
        folder.json("r.json")["peak_memory_bytes"].as_f64().unwrap()
    };
    // The higher ones have 105, 180 and 180 MB more.
    let pictures = ["-output o.png -normals n.png -depth 8 18 d.png", "-output o.pfm", "-output o.exr"];
    for pictures in pictures.into_iter().filter(|pictures| cfg!(feature = "exr") || !pictures.contains(".exr")) {
        let (low, high) = (peak(pictures, 1000, 1), peak(pictures, 6000, 1));
        assert!(high < low + 8e6, "{pictures}: {low} and {high}");
        // How many bands wait for one that is late depends on what else the machine does, up to a limit.
        let high = peak(pictures, 6000, 2);
        assert!(high < 64e6, "{pictures}: {high}");
    }
}
