//! Tests of pictures in parts: `-region`, `-tile`, `-merge` and `-skip-done`.

use crate::measuring::succeeds;
use crate::support::{Folder, SCENE, SQUARE_OBJ, TRIANGLE, batch, project};
use std::ffi::OsString;

/// Runs the program in this process, each time in a thread of its own, which becomes a worker thread.
fn run_here(arguments: &str) -> Result<u8, String> {
    let arguments: Vec<OsString> = arguments.split_whitespace().map(OsString::from).collect();
    let run = move || a2::run(arguments).map(|outcome| outcome.exit_code).map_err(|error| error.0.to_string());
    std::thread::spawn(run).join().unwrap()
}

type Rectangle = [u32; 4];

/// Returns a generator of whole numbers below another (SplitMix64).
fn random_from(mut state: u64) -> impl FnMut(u32) -> u32 {
    move |below| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) % u64::from(below)) as u32
    }
}

/// Cuts a picture at random places until there are so many parts, or no part can be cut.
fn tiling(size: (u32, u32), parts: usize, mut random: impl FnMut(u32) -> u32) -> Vec<Rectangle> {
    let mut tiles = vec![[0, 0, size.0, size.1]];
    while tiles.len() < parts.min((size.0 * size.1) as usize) {
        let large: Vec<usize> = (0..tiles.len()).filter(|&i| tiles[i][2] * tiles[i][3] > 1).collect();
        let tile = large[random(large.len() as u32) as usize];
        let axis = if tiles[tile][2] == 1 {
            1
        } else if tiles[tile][3] == 1 {
            0
        } else {
            random(2) as usize
        };
        let cut = 1 + random(tiles[tile][2 + axis] - 1);
        let mut rest = tiles[tile];
        rest[axis] += cut;
        rest[2 + axis] -= cut;
        tiles[tile][2 + axis] = cut;
        tiles.push(rest);
    }
    tiles
}

/// Renders the three pictures of a scene into files of this name, with some of the flags of a part.
fn render(folder: &Folder, scene: &batch::Scene, name: &str, flags: &str) {
    let path = |kind: &str| folder.path(&format!("{name}{kind}")).display().to_string();
    let [near, far] = &scene.depth;
    let files =
        format!("-output {} -normals {} -depth {near} {far} {}", path("c.png"), path("n.png"), path("d.png"));
    let input = project("data").join(scene.arguments());
    let line = format!("-input {} {files} -quiet -threads 1 {flags}", input.display());
    assert_eq!(run_here(&line), Ok(0), "{line}");
}

fn merged_is_whole(folder: &Folder, scene: &batch::Scene, flags: &str, parts: &[String]) {
    render(folder, scene, "whole-", flags);
    let names: Vec<String> = (0..parts.len()).map(|index| format!("part{index}-")).collect();
    for (part, name) in parts.iter().zip(&names) {
        render(folder, scene, name, &format!("{flags} {part}"));
    }
    for kind in ["c.png", "n.png", "d.png"] {
        let path = |name: &str| folder.path(&format!("{name}{kind}")).display().to_string();
        let paths: Vec<String> = names.iter().rev().map(|name| path(name)).collect();
        assert_eq!(run_here(&format!("-merge {} {}", path("merged-"), paths.join(" "))), Ok(0));
        let bytes = |name: &str| std::fs::read(path(name)).unwrap();
        let what = format!("{} {flags}: {} parts, {kind}", scene.name, parts.len());
        assert!(bytes("merged-") == bytes("whole-"), "{what}: {parts:?}");
    }
}

#[test]
fn random_tilings_of_all_scenes_merge_to_the_bytes_of_a_single_run() {
    let folder = Folder::new();
    // Other tilings in each run; a message names what failed.
    let seed = std::time::UNIX_EPOCH.elapsed().unwrap().as_nanos() as u64;
    let mut random = random_from(seed);
    for (index, scene) in batch::scenes().iter().enumerate() {
        let size = (20 + random(30), 20 + random(30));
        // From one part to 200.
        let count = [1, 200, 2 + random(30) as usize][(index + random(2) as usize) % 3];
        let tiles = tiling(size, count, &mut random);
        let parts: Vec<_> = tiles.iter().map(|[x, y, w, h]| format!("-region {x} {y} {w} {h}")).collect();
        let flags = ["-jitter -filter", "-jitter -samples 5 -seed 7", "-filter", ""][random(4) as usize];
        merged_is_whole(&folder, scene, &format!("-size {} {} {flags}", size.0, size.1), &parts);
    }
}

#[test]
fn equal_tiles_merge_to_the_bytes_of_a_single_run() {
    let folder = Folder::new();
    let scene = &batch::scenes()[5];
    for count in [1, 3, 16, 33, 34, 200] {
        let parts: Vec<_> = (1..=count).map(|index| format!("-tile {index}/{count}")).collect();
        merged_is_whole(&folder, scene, "-size 41 33 -jitter", &parts);
    }
}

#[test]
fn a_region_is_cut_out_of_the_whole_picture() {
    let folder = Folder::new();
    let whole = folder.render(SCENE, "-size 90 70 -jitter -filter");
    let part = folder.render(SCENE, "-size 90 70 -jitter -filter -region 21 17 35 40");
    assert_eq!(part.dimensions(), (35, 40));
    assert!(part.enumerate_pixels().all(|(x, row, pixel)| pixel == whole.get_pixel(21 + x, 17 + row)));
    assert!(part.pixels().any(|pixel| *pixel != part[(0, 0)]));
}

#[test]
fn parts_of_numbers_have_their_label_beside_them() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    for format in ["pfm", "exr"].into_iter().filter(|format| *format != "exr" || cfg!(feature = "exr")) {
        let render = |name: &str, part: &str| {
            succeeds(&folder, &format!("-input s.txt -size 40 30 -output {name}.{format} {part}"))
        };
        render("whole", "");
        render("a", "-region 0 0 15 30");
        render("b", "-region 15 0 25 30");
        assert!(folder.path(&format!("a.{format}.part")).exists());
        succeeds(&folder, &format!("-merge all.{format} b.{format} a.{format}"));
        let bytes = |name: &str| std::fs::read(folder.path(&format!("{name}.{format}"))).unwrap();
        assert!(bytes("all") == bytes("whole"), "{format}");
    }
}

#[test]
fn what_makes_no_picture_is_refused_by_name() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE).write("t.txt", SCENE.replace("-3 -3 0", "-3 -2 0"));
    let render = |name: &str, flags: &str| succeeds(&folder, &format!("-size 20 20 -output {name} {flags}"));
    render("top.png", "-input s.txt -tile 1/2");
    render("bottom.png", "-input s.txt -tile 2/2");
    render("large.png", "-input s.txt -region 0 9 20 11");
    render("first.png", "-input s.txt -region 0 0 20 7");
    render("third.png", "-input s.txt -region 0 13 20 7");
    render("scene.png", "-input t.txt -tile 2/2");
    render("bounces.png", "-input s.txt -tile 2/2 -bounces 3");
    render("size.png", "-input s.txt -size 20 21 -tile 2/2");
    render("plain.png", "-input s.txt");
    render("top.pfm", "-input s.txt -tile 1/2");
    render("bottom.pfm", "-input s.txt -tile 2/2");
    let label = std::fs::read_to_string(folder.path("bottom.pfm.part")).unwrap();
    folder.write("bottom.pfm.part", label.replace("version ", "version 9"));
    let before = folder.files();
    for (arguments, parts) in [
        ("o.png top.png", ["no part has the pixel in column 0, row 10", ", after 'top.png'"]),
        ("o.png bottom.png", ["no part has the pixel in column 0, row 0", ", before 'bottom.png'"]),
        ("o.png third.png first.png", ["column 0, row 7, after 'first.png', before 'third.png'", ""]),
        ("o.png top.png large.png", ["'top.png' and 'large.png' overlap", "column 0, row 9"]),
        ("o.png top.png top.png", ["'top.png' and 'top.png' overlap", ""]),
        ("o.png top.png scene.png", ["scene.png: this is no part of the picture of 'top.png'", "its scene"]),
        ("o.png top.png bounces.png", ["bounces.png: this is no part", "-bounces 3"]),
        ("o.png top.png size.png", ["size.png: this is no part", "'20 x 21', not '20 x 20'"]),
        ("o.pfm top.pfm bottom.pfm", ["bottom.pfm: this is no part", "version '90"]),
        ("o.png top.png plain.png", ["plain.png: this is no part of a picture", "-tile"]),
        ("o.png top.png none.png", ["none.png: cannot read this part", ""]),
        ("o.png top.pfm bottom.pfm", ["top.pfm: its name must end as that of 'o.png'", ""]),
        ("top.png top.png bottom.png", ["top.png: this file is read", ""]),
    ] {
        let run = folder.a2(&format!("-merge {arguments}"));
        assert_eq!(run.exit_code, 1, "{arguments}: {}", run.stderr);
        assert!(parts.iter().all(|part| run.stderr.contains(part)), "{arguments}: {}", run.stderr);
        assert_eq!(folder.files(), before, "{arguments}");
    }
}

#[test]
fn a_part_that_is_cut_short_is_an_error() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    assert_eq!(folder.a2("-input s.txt -size 60 60 -output a.png -tile 1/1").exit_code, 0);
    let bytes = std::fs::read(folder.path("a.png")).unwrap();
    for length in [bytes.len() / 2, bytes.len() - 40, 60] {
        folder.write("a.png", &bytes[..length]);
        let run = folder.a2("-merge o.png a.png");
        assert_eq!(run.exit_code, 1, "{length}: {}", run.stderr);
        assert!(run.stderr.contains("a.png: "), "{length}: {}", run.stderr);
        assert_eq!(folder.files(), ["a.png", "s.txt"], "{length}");
    }
}

/// Parts of numbers have their label in a file of its own, and PNGs in themselves: the message says which is missing.
#[test]
fn what_is_wrong_with_a_part_is_said_in_every_format() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    let damaged = "this part is damaged, or was copied in part: make it again";
    let formats = ["png", "pfm", "exr"].into_iter().filter(|&format| format != "exr" || cfg!(feature = "exr"));
    for format in formats {
        succeeds(&folder, &format!("-input s.txt -size 40 30 -output p.{format} -tile 1/1"));
        let (name, label) = (format!("t.{format}"), format!("t.{format}.part"));
        let whole = std::fs::read(folder.path(&format!("p.{format}"))).unwrap();
        let is_refused = |bytes: &[u8], expected: &str| {
            folder.write(&name, bytes);
            let run = folder.a2(&format!("-merge o.{format} {name}"));
            assert_eq!(run.exit_code, 1, "{}", run.stderr);
            assert!(run.stderr.starts_with(&format!("error: {name}: {expected}")), "{expected}: {}", run.stderr);
        };
        let shorter = &whole[..whole.len() - 30];
        if format == "png" {
            let message = "this is no part of a picture, or it is damaged or was copied in part: -region";
            is_refused(&whole[..60], message);
            is_refused(b"", message);
        } else {
            let message =
                format!("this is no part of a picture, or was copied without its label, the file '{label}'");
            is_refused(shorter, &message);
            folder.write(&label, "no label");
            is_refused(&whole, &format!("this is no part of a picture, or its label in '{label}' is damaged"));
            std::fs::copy(folder.path(&format!("p.{format}.part")), folder.path(&label)).unwrap();
        }
        is_refused(shorter, damaged);
        is_refused(&[&whole[..], b"\n"].concat(), damaged);
        folder.write(&name, &whole);
        succeeds(&folder, &format!("-merge o.{format} {name}"));
    }
}

#[test]
fn a_damaged_part_is_not_joined_and_is_made_again() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    let formats = ["png", "pfm", "exr"].into_iter().filter(|&format| format != "exr" || cfg!(feature = "exr"));
    for format in formats {
        let render = |part: &str| {
            let line = format!("-input s.txt -size 40 30 -tile {part}/2 -output {part}.{format} -skip-done");
            let run = folder.a2(&line);
            assert_eq!(run.exit_code, 0, "{}", run.stderr);
            run.stderr.contains("nothing is rendered")
        };
        assert!(!render("1") && !render("2") && render("1"));
        let name = format!("1.{format}");
        let whole = std::fs::read(folder.path(&name)).unwrap();
        for eighth in 1..8 {
            let mut bytes = whole.clone();
            bytes[eighth * whole.len() / 8] ^= 1;
            folder.write(&name, &bytes);
            let run = folder.a2(&format!("-merge o.{format} 1.{format} 2.{format}"));
            assert_eq!(run.exit_code, 1, "{eighth}: {}", run.stderr);
            assert!(run.stderr.contains(&format!("{name}: ")), "{eighth}: {}", run.stderr);
            assert!(!folder.path(&format!("o.{format}")).exists(), "{eighth}");
            assert!(!render("1") && std::fs::read(folder.path(&name)).unwrap() == whole, "{eighth}");
        }
    }
}

#[test]
fn what_is_done_is_skipped_and_what_has_changed_is_not() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE.replace(TRIANGLE, "TriangleMesh { obj_file m.obj }")).write("m.obj", SQUARE_OBJ);
    let render = |flags: &str| {
        let line = format!("-input s.txt -size 20 20 -output o.png -normals n.pfm.png -skip-done {flags}");
        succeeds(&folder, &line).stderr.contains("nothing is rendered")
    };
    let bytes = || std::fs::read(folder.path("o.png")).unwrap();
    assert!(!render("-tile 1/2"));
    let first = bytes();
    assert!(render("-tile 1/2") && bytes() == first);
    // Neither threads nor the instruction set decide the pixels.
    assert!(render("-tile 1/2 -threads 3 -plain"));
    assert!(!render("-tile 2/2") && !render("-tile 1/2"));
    assert!(!render("-tile 1/2 -bounces 1") && !render("-tile 1/2"));
    folder.write("m.obj", SQUARE_OBJ.replace("v 1 1 0", "v 1 2 0"));
    assert!(!render("-tile 1/2") && render("-tile 1/2"));
    folder.write("o.png", &bytes()[..bytes().len() - 5]);
    assert!(!render("-tile 1/2") && render("-tile 1/2"));
    std::fs::remove_file(folder.path("n.pfm.png")).unwrap();
    assert!(!render("-tile 1/2") && render("-tile 1/2"));
    // Whole pictures are recognised, too.
    assert!(!render("") && render(""));
    // Who asks for a report gets one.
    assert!(!render("-report r.json") && render("-report r.json"));
    std::fs::remove_file(folder.path("r.json")).unwrap();
    assert!(!render("-report r.json") && folder.path("r.json").exists());
}

#[test]
fn parts_that_make_no_sense_exit_with_2() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    for (flags, part) in [
        ("-region 0 0 101 5", "-region: expected pixels of a picture of 100 x 100"),
        ("-region 0 100 5 1", "-region: expected pixels"),
        ("-region 0 0 0 5", "-region: expected pixels"),
        ("-region 0 0 65536 65536", "-region: expected pixels"),
        ("-region 0 0 65537 5", "-region: expected four whole numbers from 0 to 65536: X Y W H, found '65537'"),
        ("-region 0 0 4294967296 1", "-region: expected four whole numbers from 0 to 65536"),
        ("-region -1 0 5 5", "-region: expected four whole numbers from 0 to 65536"),
        ("-tile 0/3", "-tile: expected I/N"),
        ("-tile 4/3", "-tile: expected I/N"),
        ("-tile 3", "-tile: expected I/N"),
        ("-tile 1/10001", "N up to 10000"),
        ("-tile 1/2 -region 0 0 5 5", "-tile: does not go with -region"),
        ("-tile 1/2 -target-error 1", "-target-error: does not go with"),
        ("-skip-done -time-limit 1", "-time-limit: does not go with"),
        ("-tile 1/2 -depth auto d.png", "-depth auto: does not go with"),
        ("-tile 1/2 -cost c.png", "-cost: does not go with"),
        ("-merge a.png b.png", "does not go with -merge"),
    ] {
        let run = folder.a2(&format!("-input s.txt -output o.png {flags}"));
        assert_eq!(run.exit_code, 2, "{flags}: {}", run.stderr);
        assert!(run.stderr.contains(part), "{flags}: {}", run.stderr);
    }
    assert_eq!(folder.a2("-merge a.png").exit_code, 2);
    assert_eq!(folder.files(), ["s.txt"]);
}
