//! `-pixel` and pictures agree: the value of each pixel, and the sum over its path, to the bit.

use crate::support::{batch, options_of_numbers, project};
use a2::film::to_byte;
use a2::inspect::InspectedPixel;
use a2::options::PixelPlace;
use vecmath::Vector3;

const WIDTH: u32 = 97;
const HEIGHT: u32 = 61;

/// Flags that change the steps of a path, and the number of pixels to look at.
const FLAGS: [(&str, usize); 10] = [
    ("", 1000),
    ("-shadows", 1000),
    ("-bounces 4", 1000),
    ("-shadows -bounces 4", 1000),
    ("-shadows -bounces 4 -robust", 1000),
    ("-shadows -bounces 4 -epsilon auto", 1000),
    ("-shadows -bounces 2 -jitter", 100),
    ("-bounces 1 -filter", 100),
    ("-shadows -jitter -filter -seed 5", 50),
    ("-samples 1 -sampler sobol", 100),
];

/// Returns pixels of the picture in a random order, which is the same in each run.
fn random_pixels(count: usize) -> Vec<PixelPlace> {
    let mut state = 1u32;
    let mut random = |below: u32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from((state >> 8) % below) + 0.5
    };
    (0..count).map(|_| PixelPlace { x: random(WIDTH), y: random(HEIGHT) }).collect()
}

/// Checks that the steps of a path add up to the colour of its sample, and lights to that of their surface.
fn check_sums(pixel: &InspectedPixel) {
    let mut sum = Vector3::ZERO;
    for step in &pixel.path.steps {
        sum += step.throughput.scaled_by(step.light());
    }
    assert_eq!(sum, pixel.samples[pixel.chosen].color, "{pixel:?}");
    for surface in pixel.path.steps.iter().filter_map(|step| step.surface()) {
        let lights = surface.lights.iter().fold(Vector3::ZERO, |sum, light| sum + light.added);
        assert_eq!(lights + surface.ambient, surface.reflected, "{pixel:?}");
    }
}

#[test]
fn pixels_are_those_of_the_picture_and_the_sum_of_their_paths() {
    let (mut mirrors, mut blocked) = (0, 0);
    for scene in batch::scenes() {
        for (flags, count) in FLAGS {
            let file = project("data").join(format!("{}.txt", scene.name));
            let pictures = format!("-output c.png -normals n.png -depth 8 18 d.png -size {WIDTH} {HEIGHT}");
            let mut options = options_of_numbers(&format!("-input {} {pictures} -quiet {flags}", file.display()));
            options.pixels = random_pixels(count);
            let report = a2::render_scene(&options).unwrap();
            let film = &report.frame.film;
            let [color, normals, depth] = [&film.color, &film.normals, &film.depth].map(|p| p.as_ref().unwrap());
            let linear = film.linear.as_ref().unwrap();
            assert_eq!(report.pixels.len(), count);
            for pixel in &report.pixels {
                let at = (pixel.pixel.1 * WIDTH + pixel.pixel.0) as usize;
                let bytes = |color: Vector3| color.to_array().map(to_byte);
                let context = format!("{} {flags}: {:?}", scene.name, pixel.pixel);
                assert_eq!(color[3 * at..][..3], bytes(pixel.shown.color), "{context}");
                assert_eq!(normals[3 * at..][..3], bytes(pixel.shown.normal), "{context}");
                assert_eq!(depth[at], to_byte(pixel.shown.depth), "{context}");
                assert_eq!(linear[3 * at..][..3], pixel.shown.color.to_array().map(|c| c as f32), "{context}");
                check_sums(pixel);
                mirrors += pixel.path.steps.len() - 1;
                let surfaces = pixel.path.steps.iter().filter_map(|step| step.surface());
                let lights = surfaces.flat_map(|surface| &surface.lights);
                blocked +=
                    lights.filter(|light| light.added == Vector3::ZERO && light.diffuse != Vector3::ZERO).count();
            }
        }
    }
    assert!(mirrors > 5000 && blocked > 1000, "{mirrors} mirror rays, {blocked} blocked lights");
}
