//! Picture files of others: what they may claim, and what is said about those that cannot be read.

use crate::support::{Folder, Run};
use image::{ImageFormat, Rgb, RgbImage};
use std::io::{Cursor, Write as _};

const FACES: [&str; 6] = ["left", "right", "up", "down", "front", "back"];

const SCENE: &str = "PerspectiveCamera { center 0 0 0 direction 1 0 0 up 0 1 0 angle 30 }
Background { cubeMap map } Group { numObjects 0 }";

/// Returns a PNG of one colour as a file in memory.
fn png() -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    RgbImage::from_pixel(9, 7, Rgb([90, 60, 30])).write_to(&mut file, ImageFormat::Png).unwrap();
    file.into_inner()
}

/// Returns a chunk of a PNG.
fn chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut bytes = (data.len() as u32).to_be_bytes().to_vec();
    bytes.extend(name);
    bytes.extend(data);
    let crc = bytes[4..].iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 * (crc & 1)))
    });
    bytes.extend((!crc).to_be_bytes());
    bytes
}

/// Returns a PNG whose head claims a size, and which has the data of a small picture.
fn png_that_claims(width: u32, height: u32) -> Vec<u8> {
    let mut head = [width.to_be_bytes(), height.to_be_bytes()].concat();
    head.extend([8, 2, 0, 0, 0]);
    let small = png();
    [&small[..8], &chunk(b"IHDR", &head), &small[8 + 25..]].concat()
}

fn fails(folder: &Folder, arguments: &str) -> Run {
    let run = folder.a2(arguments);
    assert!(run.exit_code != 0, "{arguments}");
    assert!(!run.stderr.contains("panicked"), "{arguments}: {}", run.stderr);
    run
}

#[test]
fn a_picture_that_claims_too_much_is_refused_with_both_numbers() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE).write("small.png", png());
    for name in FACES {
        folder.write(&format!("map/{name}.png"), png());
    }
    for (width, height, expected) in [
        (65536, 65536, "this picture claims 65536 x 65536 pixels; the limit is 268435456 in all"),
        (
            16384,
            16384,
            "this picture claims 16384 x 16384 pixels, which take 805306368 bytes of memory; the limit for",
        ),
    ] {
        let bytes = png_that_claims(width, height);
        folder.write("big.png", &bytes).write("map/right.png", &bytes);
        for arguments in [
            "-compare big.png small.png",
            "-compare small.png big.png",
            "-input s.txt -output o.png -reference big.png",
            "-input s.txt -output o.png",
        ] {
            let run = fails(&folder, arguments);
            assert!(run.stderr.contains(expected), "{arguments}: {}", run.stderr);
        }
    }
    // The data says how much there is only when it is decoded.
    folder.write("big.png", png_that_claims(3000, 3000));
    let run = fails(&folder, "-compare big.png small.png");
    assert!(run.stderr.contains("big.png: cannot read this picture"), "{}", run.stderr);
}

#[cfg(feature = "exr")]
#[test]
fn an_exr_that_claims_too_much_is_refused() {
    let folder = Folder::new();
    let scene = crate::support::project("data/scene01_plane.txt").display().to_string();
    assert_eq!(folder.a2(&format!("-input {scene} -size 9 7 -output r.exr")).exit_code, 0);
    let mut bytes = std::fs::read(folder.path("r.exr")).unwrap();
    // The window that is shown; the data fill a small part of it.
    let name = b"displayWindow\0box2i\0\x10\0\0\0";
    let at = bytes.windows(name.len()).position(|window| window == name).unwrap() + name.len();
    bytes[at + 8..at + 12].copy_from_slice(&7999_u32.to_le_bytes());
    bytes[at + 12..at + 16].copy_from_slice(&3999_u32.to_le_bytes());
    folder.write("r.exr", &bytes);
    let run = fails(&folder, &format!("-input {scene} -size 9 7 -output o.png -reference r.exr"));
    assert!(run.stderr.contains("r.exr: "), "{}", run.stderr);
    assert!(run.stderr.contains("this picture claims 8000 x 4000 pixels"), "{}", run.stderr);
}

/// A colour profile of 40 MB in a file of 40 kB: it is not used, so it need not fit anywhere.
#[test]
fn a_huge_colour_profile_is_skipped() {
    let mut profile = fdeflate::compress_to_vec(&vec![0; 40 << 20]);
    profile.splice(0..0, *b"huge\0\0");
    assert!(profile.len() < 1 << 20, "{}", profile.len());
    let folder = Folder::new();
    let plain = png();
    folder.write("a.png", &plain);
    folder.write("b.png", [&plain[..8 + 25], &chunk(b"iCCP", &profile), &plain[8 + 25..]].concat());
    let run = folder.a2("-compare a.png b.png -tolerance 0 0");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
}

#[test]
fn a_cube_map_that_cannot_be_opened_is_named_at_its_place() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    let message = |run: Run| {
        assert!(run.stderr.starts_with("error: s.txt:2:22: "), "{}", run.stderr);
        run.stderr
    };
    let run = "-input s.txt -output o.png -size 3 3";
    assert!(message(fails(&folder, run)).contains("the cube map folder 'map' does not exist"));
    for name in FACES {
        folder.write(&format!("map/{name}.png"), png());
    }
    assert_eq!(folder.a2(run).exit_code, 0);

    let jpeg = b"\xff\xd8\xff\xe0\0\x10JFIF\0\x01\x01\0\0\x01\0\x01\0\0";
    folder.write("map/right.png", jpeg);
    assert!(message(fails(&folder, run)).contains("right.png': this is a JPEG picture, not a PNG"));
    folder.write("map/right.png", b"BM\x46\0\0\0\0\0\0\0\x36\0\0\0");
    assert!(message(fails(&folder, run)).contains("right.png': this is a BMP picture, not a PNG"));

    std::fs::remove_file(folder.path("map/right.png")).unwrap();
    assert!(message(fails(&folder, run)).contains("right.png': cannot read the picture: "));
    folder.write("map/right.jpg", jpeg);
    assert!(message(fails(&folder, run)).contains("right.jpg': a face must be a PNG picture"));
}

/// A device has no size and never ends.
#[cfg(target_os = "linux")]
#[test]
fn a_device_is_no_picture() {
    let folder = Folder::new();
    folder.write("small.png", png());
    let run = fails(&folder, "-compare /dev/zero small.png");
    assert!(run.stderr.contains("/dev/zero: cannot read this picture"), "{}", run.stderr);
}

/// A pipe has no size, and cannot be read twice.
#[cfg(target_os = "linux")]
#[test]
fn a_pipe_is_read_as_a_picture() {
    let folder = Folder::new();
    folder.write("small.png", png());
    let status = std::process::Command::new("mkfifo").arg(folder.path("pipe.png")).status().unwrap();
    assert!(status.success());
    let writer = std::thread::spawn({
        let path = folder.path("pipe.png");
        move || std::fs::OpenOptions::new().write(true).open(path).unwrap().write_all(&png()).unwrap()
    });
    let run = folder.a2("-compare pipe.png small.png -tolerance 0 0");
    writer.join().unwrap();
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
}

#[test]
fn a_folder_whose_name_is_nearly_right_is_found_or_suggested() {
    let folder = Folder::new();
    for face in FACES {
        folder.write(&format!("Sky/Day/{face}.png"), png());
    }
    for name in ["sky/day", "Sky\\Day"] {
        folder.write("s.txt", SCENE.replace("map", name));
        let run = folder.a2("-input s.txt -output o.png -size 9 9");
        assert_eq!(run.exit_code, 0, "{name}: {}", run.stderr);
        let expected = format!("s.txt:2:22: there is no '{name}': 'Sky/Day' is read");
        // Where capitals do not count, the file system finds it.
        assert!(run.stderr.contains(&expected) || !cfg!(target_os = "linux"), "{}", run.stderr);
    }
    folder.write("s.txt", SCENE.replace("map", "Sky/Dax"));
    let run = fails(&folder, "-input s.txt -output o.png");
    assert!(run.stderr.contains("did you mean 'Sky/Day'?"), "{}", run.stderr);
}

/// The library panics in the middle of a colour.
#[test]
fn a_palette_that_ends_in_the_middle_of_a_colour_is_refused() {
    let head = [12, 2u32].map(u32::to_be_bytes).concat();
    let small = png();
    let [broken, whole] = [13, 12].map(|length| {
        let head = chunk(b"IHDR", &[&head[..], &[2, 3, 0, 0, 0]].concat());
        let palette = chunk(b"PLTE", &(0..length).collect::<Vec<u8>>());
        // Deflate's block of stored bytes: two rows of four, then the checksum.
        let rows = [0, 0x1b, 0x1b, 0x1b].repeat(2);
        let (a, b) =
            rows.iter().fold((1u32, 0u32), |(a, b), &byte| (a + u32::from(byte), b + a + u32::from(byte)));
        let data = [&[0x78, 1, 1, 8, 0, 0xf7, 0xff][..], &rows, &((b << 16) | a).to_be_bytes()].concat();
        [&small[..8], &head, &palette, &chunk(b"IDAT", &data), &chunk(b"IEND", &[])].concat()
    });
    let folder = Folder::new();
    folder.write("broken.png", broken).write("whole.png", whole);
    let run = folder.a2("-compare broken.png broken.png");
    assert_eq!(run.exit_code, 2, "{}", run.stderr);
    assert!(run.stderr.contains("its palette ends in the middle of a colour"), "{}", run.stderr);
    assert_eq!(folder.a2("-compare whole.png whole.png").exit_code, 0);
}
