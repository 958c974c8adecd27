//! Picture files: cube map faces, references, and what `-compare` says of two pictures.

use super::{must_be_clear, options};
use a2::cube_map::CubeMap;
use a2::film::{Film, Planes, write_png};
use a2::measure::{Reference, Region, compare_files};
use a2::options::CompareOptions;
use std::path::Path;
use vecmath::Vector3;

/// The cube map whose right face is replaced.
pub const FACES: &str = "faces";

/// Larger pictures take longer, and show nothing new.
const MOST_PIXELS: u64 = 1 << 14;

/// Writes six small faces.
pub fn write_cube_map(folder: &Path) {
    std::fs::create_dir_all(folder).expect("a folder");
    for (number, name) in ["right", "left", "up", "down", "front", "back"].into_iter().enumerate() {
        let bytes: Vec<u8> = (0..3 * 5 * 4).map(|byte| (40 * number + 7 * byte) as u8).collect();
        write_png(&folder.join(format!("{name}.png")), 5, 4, &bytes).expect("a face");
    }
}

/// Reads a PNG file as a cube map face and as a reference.
pub fn png(data: &[u8], folder: &Path) -> bool {
    let size = size_at(data, 16, u32::from_be_bytes);
    if size.is_some_and(|(width, height)| u64::from(width) * u64::from(height) > MOST_PIXELS) {
        return false;
    }
    let is_face = cube_map(data, &folder.join(FACES));
    is_face | reference(data, &folder.join("reference.png"), size)
}

fn cube_map(data: &[u8], folder: &Path) -> bool {
    let face = folder.join("right.png");
    std::fs::write(&face, data).expect("a file");
    let map = match CubeMap::open(folder) {
        Ok(map) => map,
        Err(message) => {
            assert!(message.contains("right.png"), "{message}");
            return false;
        }
    };
    let mut is_black = true;
    for (y, z) in [(0.0, 0.0), (0.3, -0.7), (-1.0, 1.0), (1.0, -1.0), (0.999, 0.1)] {
        for color in map.color(Vector3::new(1.0, y, z)).to_array() {
            assert!((0.0..=1.0).contains(&color), "{color}");
            is_black &= color == 0.0;
        }
    }
    assert!(map.decoded_faces() >= 1);
    match map.broken_face() {
        None => true,
        Some(message) => {
            assert!(is_black);
            assert!(message.contains("right.png"), "{message}");
            false
        }
    }
}

/// Reads a PFM file as a reference.
pub fn pfm(data: &[u8], folder: &Path) -> bool {
    let mut words = data.splitn(4, u8::is_ascii_whitespace).skip(1);
    let mut number = || std::str::from_utf8(words.next()?).ok()?.parse().ok();
    let size = (|| Some((number()?, number()?)))();
    reference(data, &folder.join("reference.pfm"), size)
}

/// Reads an EXR file as a reference.
pub fn exr(data: &[u8], folder: &Path) -> bool {
    const NAME: &[u8] = b"dataWindow\0box2i\0";
    let window = data.windows(NAME.len()).position(|window| window == NAME).map(|at| at + NAME.len() + 4);
    let corners = window
        .and_then(|at| Some((size_at(data, at, u32::from_le_bytes)?, size_at(data, at + 8, u32::from_le_bytes)?)));
    let extent = |least: u32, most: u32| most.wrapping_sub(least).wrapping_add(1);
    let size = corners.map(|((left, top), (right, bottom))| (extent(left, right), extent(top, bottom)));
    if size.is_some_and(|(width, height)| u64::from(width) * u64::from(height) > MOST_PIXELS) {
        return false;
    }
    reference(data, &folder.join("reference.exr"), size)
}

/// Two numbers of four bytes each.
fn size_at(data: &[u8], at: usize, number: fn([u8; 4]) -> u32) -> Option<(u32, u32)> {
    let (numbers, _) = data.get(at..at + 8)?.as_chunks();
    Some((number(numbers[0]), number(numbers[1])))
}

/// Compares a grey film with a reference of these bytes, which says that it has this size.
fn reference(data: &[u8], path: &Path, size: Option<(u32, u32)>) -> bool {
    std::fs::write(path, data).expect("a file");
    let in_limits = |&(width, height): &(u32, u32)| (1..=512).contains(&width) && (1..=512).contains(&height);
    let (width, height) = size.filter(in_limits).unwrap_or((4, 4));
    let mut options = options(&format!("-input s.txt -output o.png -size {width} {height}"));
    options.measure.reference = Some(path.to_owned());
    let reference = match Reference::wanted_by(&options) {
        Ok(reference) => reference.expect("one is wanted"),
        Err(error) => return must_be_clear(&error, path),
    };
    let mut film = Film::new(width, height, Planes::wanted_by(&options));
    let pixels: Vec<u32> = (0..width * height).collect();
    film.columns(0, width)
        .set_colors(&pixels, |pixel| Vector3::splat(f64::from(pixel % 7) as vecmath::Real / 6.0));
    let error = reference.error_of(&film).expect("the film has numbers");
    for levels in [error.rmse_levels, error.worst_levels] {
        assert!((0.0..=255.0).contains(&levels), "{error:?}");
    }
    assert!((0.0..=1.0).contains(&error.share_over_one_level) && error.ssim <= 1.0 + 1e-9, "{error:?}");
    assert!(error.worst_pixel.0 < width && error.worst_pixel.1 < height, "{error:?}");
    true
}

/// Compares two pictures of the bytes behind two that give their size.
pub fn compare(data: &[u8], folder: &Path) -> bool {
    let [columns, rows, a @ ..] = data else { return false };
    let (width, height) = (u32::from(columns % 8) + 1, u32::from(rows % 8) + 1);
    let count = 3 * (width * height) as usize;
    let byte = |at: usize| a.get(at).copied().unwrap_or(at as u8);
    let [a, b] = [0, count].map(|from| (from..from + count).map(byte).collect::<Vec<u8>>());
    let [a_path, b_path, diff] = ["a.png", "b.png", "diff.png"].map(|name| folder.join(name));
    write_png(&a_path, width, height, &a).expect("a picture");
    write_png(&b_path, width, height, &b).expect("a picture");
    let compare = |a: &Path, b: &Path, diff: Option<&Path>| {
        let (a, b, diff) = (a.to_owned(), b.to_owned(), diff.map(Path::to_owned));
        compare_files(&CompareOptions { a, b, diff, report: None, levels: 1, percent: 0.0 })
            .map_err(|(error, _)| error)
    };
    let found = compare(&a_path, &b_path, Some(&diff)).expect("two pictures of the same size");
    let differences: Vec<u8> = a.iter().zip(&b).map(|(a, b)| a.abs_diff(*b)).collect();
    let (pixels, _) = differences.as_chunks::<3>();
    for levels in 0..=u8::MAX {
        let over = pixels.iter().filter(|pixel| pixel.iter().any(|&channel| channel > levels)).count();
        assert_eq!(found.pixels_over(levels), over as u64);
    }
    let mean = differences.iter().map(|&d| f64::from(d).powi(2)).sum::<f64>() / count as f64;
    assert!((found.rmse - mean.sqrt()).abs() <= 1e-9 && found.pixels == pixels.len() as u64);
    let worst = found.worst_pixel.map_or(0, |pixel| {
        let channels = pixel.a.into_iter().zip(pixel.b).map(|(a, b)| (a - b).abs() as u8);
        channels.max().expect("three channels")
    });
    assert_eq!(worst, found.worst);
    // Every pixel over one level lies in one region, which is no larger than the picture.
    let inside = |region: &Region| region.right < width && region.bottom < height && region.pixels > 0;
    assert!(found.regions.iter().all(inside), "{found:?}");
    assert_eq!(found.regions.iter().map(|region| region.pixels).sum::<u64>(), found.pixels_over(1));
    // The picture of the differences can be read, and has no difference to itself.
    assert_eq!(compare(&diff, &diff, None).expect("a picture").worst, 0);
    write_png(&b_path, width + 1, height, &vec![0; count + 3 * height as usize]).expect("a picture");
    must_be_clear(&compare(&a_path, &b_path, None).expect_err("other sizes"), &b_path);
    true
}
