//! Pictures of unusual sizes, depth ranges, and the seams of cube maps.

use super::support::{CAMERA, Studio, check, check_that, modes, objects, vector};
use a2::cube_map::CubeMap;
use a2::render::{DepthRange, Pixel};
use a2::trace::Seen;
use vecmath::Real;

#[test]
fn pictures_one_pixel_wide_or_high_show_the_middle() {
    let scene = objects("Sphere { center 0 0 0 radius 1 }");
    for mode in modes() {
        let film = |size: &str| Studio::new(&scene, &format!("-size {size} {}", mode.flags)).at(mode).film();
        let lone = film("1 1").color.unwrap();
        check_that("1 x 1: the middle of the picture", lone == film("3 3").color.unwrap()[12..15]);
        let (row, column) = (film("5 1"), film("1 5"));
        check_that("5 x 1: the middle row", row.color.unwrap() == film("5 5").color.unwrap()[30..45]);
        let square = film("5 5").normals.unwrap();
        let middle: Vec<u8> = (0..5).flat_map(|y| square[3 * (5 * y + 2)..][..3].to_vec()).collect();
        check_that("1 x 5: the middle column", column.normals.unwrap() == middle);
        for flags in ["-jitter", "-filter", "-jitter -filter"] {
            check_that(
                &format!("1 x 1 with {flags}: a picture"),
                film(&format!("1 1 {flags}")).color.unwrap().len() == 3,
            );
        }
    }
}

#[test]
fn pictures_65536_pixels_wide_are_symmetric() {
    let scene = objects("Sphere { center 0 0 0 radius 1 }");
    for mode in modes() {
        let film = Studio::new(&scene, &format!("-size 65536 1 {}", mode.flags)).at(mode).film();
        let bytes = film.depth.unwrap();
        // The scene is symmetric, so left and right are mirror images to the bit.
        check_that("65,536 x 1: symmetric", bytes.iter().eq(bytes.iter().rev()));
        check_that("65,536 x 1: the sphere in the middle", bytes[32_768] == 255 && bytes[0] == 0);
    }
}

#[test]
fn depth_ranges_may_be_empty_inverted_or_denormal() {
    let depth = |t: f64, min: f64, max: f64| {
        let seen = Seen { depth: Some(t as Real), ..Seen::default() };
        let mut pixel = Pixel::default();
        pixel.show(&seen, Some(DepthRange::new(min as Real, max as Real)), false);
        f64::from(pixel.depth)
    };
    check_that("depth range without extent: black", depth(5.0, 5.0, 5.0) == 0.0 && depth(6.0, 5.0, 5.0) == 0.0);
    check_that("inverted depth range: inverted", depth(9.0, 12.0, 8.0) == 0.75);
    check_that(
        "denormal depth range: nearer black, further white",
        depth(1.0, 0.0, 1e-320) >= 1.0 || cfg!(feature = "f32"),
    );
    check_that("depth range of 1e300: black", depth(1.0, 0.0, 1e300) <= 1e-38);
    check_that("infinite difference of a depth range: no NaN", !depth(1.0, -1.7e308, 1.7e308).is_nan());
}

/// Makes a cube map with faces of these sizes. Each has one colour: red is 40 times the face's index.
fn cube_map(sizes: [u32; 6]) -> (tempfile::TempDir, CubeMap) {
    let folder = tempfile::tempdir().unwrap();
    for (face, (name, size)) in ["right", "left", "up", "down", "front", "back"].into_iter().zip(sizes).enumerate()
    {
        let bytes = vec![40 * face as u8; (3 * size * size) as usize];
        a2::film::write_png(&folder.path().join(format!("{name}.png")), size, size, &bytes).unwrap();
    }
    let map = CubeMap::open(folder.path()).unwrap();
    (folder, map)
}

#[test]
fn edges_and_corners_of_cube_maps_show_an_adjacent_face() {
    for (case, sizes) in [("1 x 1", [1; 6]), ("unequal", [1, 2, 3, 5, 64, 17])] {
        let (_folder, map) = cube_map(sizes);
        let mut wrong = 0;
        let step = [-1.0, -0.5, 0.0, 0.5, 1.0, 1.0 - f64::EPSILON, f64::EPSILON - 1.0, 5e-324, -0.0];
        for x in step {
            for y in step {
                for z in step {
                    let absolute = [x, y, z].map(f64::abs);
                    if absolute.into_iter().fold(0.0, f64::max) < 0.4 {
                        continue;
                    }
                    let level = f64::from(map.color(vector([x, y, z])).x) * 255.0;
                    // Any face is right whose axis is the largest up to rounding. All its texels have its colour.
                    let largest = absolute.into_iter().fold(0.0, f64::max);
                    let fits = (0..3).any(|axis| {
                        let face = 2 * axis + usize::from([x, y, z][axis] < 0.0);
                        absolute[axis] >= largest * (1.0 - 1e-6) && (level - 40.0 * face as f64).abs() < 1e-4
                    });
                    wrong += u32::from(!fits);
                }
            }
        }
        check(
            &format!("cube map with {case} faces: colours of no adjacent face on seams and corners"),
            0.0,
            f64::from(wrong),
        );
    }
    let (_folder, map) = cube_map([2; 6]);
    let seen = map.color(vector([0.0; 3]));
    check_that("cube map in no direction: no panic", seen.x.is_nan() || f64::from(seen.x) >= 0.0);
}

#[test]
fn pictures_far_from_the_origin_are_the_same() {
    // Everything is moved by 2^20, and all numbers stay exact: so are the rays and every difference.
    let scene = |shift: f64| {
        let at = |x: f64| x + shift;
        format!(
            "{}Materials {{ numMaterials 1 Material {{ }} }}
            Group {{ numObjects 2 MaterialIndex 0 Sphere {{ center {} {} {} radius 0.75 }}
            Triangle {{ vertex0 {} {} {} vertex1 {} {} {} vertex2 {} {} {} }} }}",
            CAMERA.replace("center 0 0 5", &format!("center {} {} {}", at(0.0), at(0.0), at(5.0))),
            at(0.5),
            at(0.25),
            at(-0.5),
            at(-1.5),
            at(-1.0),
            at(0.5),
            at(1.0),
            at(-1.25),
            at(-0.5),
            at(0.0),
            at(1.0),
            at(0.25)
        )
    };
    for mode in modes() {
        let flags = format!("-size 64 64 -depth 3 7 d.png {}", mode.flags);
        let film = |shift: f64| Studio::new(&scene(shift), &flags).at(mode).film();
        for (case, shift) in [("2^20", 1048576.0), ("-2^30", -1073741824.0)] {
            check_that(
                &format!("scene moved by {case}: the same depth picture"),
                film(0.0).depth == film(shift).depth,
            );
        }
    }
}
