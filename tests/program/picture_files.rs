//! Picture files of others: what they may claim, and what is said about those that cannot be read.

use crate::support::{Folder, Run};
use image::{ImageFormat, Rgb, RgbImage};
use std::io::{Cursor, Write as _};

pub const FACES: [&str; 6] = ["left", "right", "up", "down", "front", "back"];

pub const SCENE: &str = "PerspectiveCamera { center 0 0 0 direction 1 0 0 up 0 1 0 angle 30 }
Background { cubeMap map } Group { numObjects 0 }";

/// Returns a PNG of one colour as a file in memory.
pub fn png() -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    RgbImage::from_pixel(9, 7, Rgb([90, 60, 30])).write_to(&mut file, ImageFormat::Png).unwrap();
    file.into_inner()
}

/// Returns a chunk of a PNG.
pub fn chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
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

pub fn fails(folder: &Folder, arguments: &str) -> Run {
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
        (1 << 31, 1 << 31, "this picture claims 2147483648 x 2147483648 pixels; the limit is 268435456 in all"),
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

/// An EXR file lists each channel with its name, NUL and 16 bytes.
#[cfg(feature = "exr")]
#[test]
fn channels_of_an_exr_that_are_no_colours_are_named() {
    let folder = Folder::new();
    let scene = crate::support::project("data/scene01_plane.txt").display().to_string();
    assert_eq!(folder.a2(&format!("-input {scene} -size 9 7 -output r.exr")).exit_code, 0);
    let whole = std::fs::read(folder.path("r.exr")).unwrap();
    let name = b"chlist\0";
    let at = whole.windows(name.len()).position(|window| window == name).unwrap() + name.len();
    let size = u32::from_le_bytes(*whole[at..].first_chunk().unwrap()) as usize;
    let (before, after) = (&whole[..at], &whole[at + 4 + size..]);
    let channel = &whole[at + 4 + 2..][..16];
    for (names, shown) in [
        ("Y", "Y"),
        ("G R", "G, R"),
        ("l.B l.G l.R", "l.B, l.G, l.R"),
        ("a b c d e f g h", "a, b, c, d, e, f, g, h"),
        ("a b c d e f g h i", "a, b, c, d, e, f, g, h, ..."),
    ] {
        let list: Vec<u8> = names.split(' ').flat_map(|name| [name.as_bytes(), b"\0", channel].concat()).collect();
        let bytes = [before, &(list.len() as u32 + 1).to_le_bytes(), &list, b"\0", after].concat();
        folder.write("n.exr", bytes);
        let run = fails(&folder, "-compare n.exr r.exr");
        let expected = format!("has the channels {shown}: those named R, G and B are needed\n");
        assert!(run.stderr.ends_with(&expected), "{names}: {}", run.stderr);
    }
}

/// The library shows a chunk with all that it knows of it.
#[test]
fn a_chunk_is_called_by_its_name() {
    let folder = Folder::new();
    let small = png();
    folder.write("a.png", [&small[..8 + 25], &small[8..]].concat()).write("b.png", &small);
    let run = fails(&folder, "-compare a.png b.png");
    let expected = "error: a.png: cannot read this picture: Chunk IHDR must appear at most once.\n";
    assert_eq!(run.stderr, expected);
}

/// Compares a picture with the same one that has this chunk, too.
fn assert_does_no_harm(chunk: &[u8]) {
    let folder = Folder::new();
    let plain = png();
    folder.write("a.png", &plain);
    folder.write("b.png", [&plain[..8 + 25], chunk, &plain[8 + 25..]].concat());
    let run = folder.a2("-compare a.png b.png -tolerance 0 0");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
}

/// A colour profile of 40 MB in a file of 40 kB: it is not used, so it need not fit anywhere.
#[test]
fn a_huge_colour_profile_is_skipped() {
    let mut profile = fdeflate::compress_to_vec(&vec![0; 40 << 20]);
    profile.splice(0..0, *b"huge\0\0");
    assert!(profile.len() < 1 << 20, "{}", profile.len());
    assert_does_no_harm(&chunk(b"iCCP", &profile));
}

/// Texts of 30 MB beside a picture of 63 pixels: they are in the file, so they may take memory.
#[test]
fn a_huge_text_does_no_harm() {
    let mut text = b"Comment\0".to_vec();
    text.resize(30_000_000, b'y');
    assert_does_no_harm(&chunk(b"tEXt", &text));
}

#[test]
fn what_a_file_seems_to_be_is_named() {
    let folder = Folder::new();
    folder.write("right.png", png());
    let tga = [&[0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 8, 0, 8, 0, 24, 0][..], &[7; 192]].concat();
    let without_returns: Vec<u8> = png().into_iter().filter(|&byte| byte != b'\r').collect();
    let decoded_as_text = String::from_utf8_lossy(&png()).into_owned();
    let kinds: [(&[u8], &str); 23] = [
        (b"", "empty"),
        (b"<!DOCTYPE html><html>404", "an HTML page"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12\n", "a Git LFS pointer"),
        (b"\x1f\x8b\x08\0\0\0\0\0", "compressed with gzip"),
        (b"PK\x03\x04\x14\0", "a ZIP archive"),
        (b"%PDF-1.7\n", "a PDF document"),
        (b"\0\0\0\x0cjP  \r\n\x87\n", "a JPEG 2000 picture"),
        (b"\0\0\0\x18ftypheic\0\0\0\0", "an HEIC picture"),
        (b"\0\0\0\x18ftypavif\0\0\0\0", "an AVIF picture"),
        (b"RIFF\x10\0\0\0WEBPVP8 ", "a WebP picture"),
        (b"8BPS\0\x01\0\0", "a Photoshop picture"),
        (b"\0\0\x01\0\x01\0\x10\x10", "an ICO picture"),
        (b"\x76\x2f\x31\x01\x02\0\0\0", "an OpenEXR picture"),
        (b"II*\0\x08\0\0\0", "a TIFF picture"),
        (b"<?xml version=\"1.0\"?>\n<!-- drawn -->\n<svg width=\"8\"/>", "an SVG drawing"),
        (b"<svg xmlns=\"http://www.w3.org/2000/svg\"/>", "an SVG drawing"),
        (b"PF\n8 8\n-1.0\n", "a PFM picture"),
        (b"P6\n8 8\n255\n", "a PPM picture"),
        (&tga, "a TGA picture"),
        (&without_returns, "a PNG picture whose first bytes have changed"),
        (decoded_as_text.as_bytes(), "a PNG picture whose first bytes have changed"),
        (b"GIF89a", "a GIF picture"),
        (b"../day/left.png", "only a path, and seems to be a symbolic link that was stored as text"),
    ];
    for (bytes, what) in kinds {
        folder.write("left.png", bytes);
        let run = fails(&folder, "-compare left.png right.png");
        let expected = format!("left.png: this is no PNG picture: the file is {what}");
        assert!(run.stderr.contains(&expected), "{what}: {}", run.stderr);
    }
    folder.write("left.png", b"\x01\x02\x03");
    let run = fails(&folder, "-compare left.png right.png");
    assert!(run.stderr.contains("this is no PNG picture: it does not begin like one"), "{}", run.stderr);
    for (name, kind) in [("left.pfm", "PFM"), ("left.exr", "EXR")] {
        folder.write(name, png());
        let run = fails(&folder, &format!("-compare {name} right.png"));
        let expected = format!("{name}: this is no {kind} picture: the file is a PNG picture");
        assert!(run.stderr.contains(&expected) || kind == "EXR" && !cfg!(feature = "exr"), "{}", run.stderr);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_device_is_no_picture() {
    let folder = Folder::new();
    folder.write("small.png", png());
    let run = fails(&folder, "-compare /dev/zero small.png");
    assert!(run.stderr.contains("/dev/zero: this is no PNG picture"), "{}", run.stderr);
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
