//! Cube maps whose picture is known without a renderer.

use crate::support::{Folder, options_of_numbers};
use a2::options::Options;
use a2::simd::InstructionSet;
use image::{Rgb, RgbImage};

/// A wide view of all faces but the one behind the eye, past a sphere that is nowhere near.
const SCENE: &str = "PerspectiveCamera { center 0 0 10 direction 0.3 0.2 -1 up 0 1 0 angle 140 }
Lights { numLights 1 DirectionalLight { direction 0 0 -1 color 1 1 1 } }
Background { cubeMap sky }
Materials { numMaterials 1 Material { } }
Group { numObjects 1 MaterialIndex 0 Sphere { center 0 0 99 radius 0.001 } }";

#[test]
fn a_cube_map_of_one_colour_is_exactly_that_colour() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    std::fs::create_dir(folder.path("sky")).unwrap();
    for color in [[0, 51, 255], [1, 77, 131], [90, 200, 254]] {
        for (name, side) in [("left", 7), ("right", 4), ("up", 5), ("down", 1), ("front", 16), ("back", 3)] {
            let face = RgbImage::from_pixel(side, side, Rgb(color));
            face.save(folder.path(&format!("sky/{name}.png"))).unwrap();
        }
        let line = format!("-input {} -output o.png -size 64 48 -quiet", folder.path("s.txt").display());
        let mut plain = options_of_numbers(&line);
        plain.plain = true;
        let wide = InstructionSet::available().map(|simd| Options { simd, plain: false, ..plain.clone() });
        for options in std::iter::once(plain.clone()).chain(wide) {
            let report = a2::render_scene(&options).unwrap();
            assert_eq!(report.decoded_faces, 5);
            let bytes = report.frame.film.color.unwrap();
            let wrong = bytes.as_chunks().0.iter().filter(|&&pixel: &&[u8; 3]| pixel != color).count();
            assert_eq!((wrong, bytes.len()), (0, 3 * 64 * 48), "{color:?}, {}: {}", options.plain, options.simd);
        }
    }
}
