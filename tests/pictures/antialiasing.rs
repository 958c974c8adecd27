//! `-jitter` and `-filter` against results known in advance, and against statistics where the result is random.

use crate::support::{CAMERA_BLOCK, Folder};
use image::RgbImage;

/// Makes a scene that is white to the left of `x` in the plane z = 0, and black everywhere else.
///
/// The picture spans -10 to 10 at z = 0, so a pixel of a picture of width W is 20/(W - 1) wide there.
fn edge_scene(x: f64) -> String {
    format!(
        "{CAMERA_BLOCK} Background {{ color 0 0 0 ambientLight 1 1 1 }}
         Lights {{ numLights 1 DirectionalLight {{ direction 0 0 1 color 0 0 0 }} }}
         Materials {{ numMaterials 1 Material {{ diffuseColor 1 1 1 }} }}
         Group {{ numObjects 2 MaterialIndex 0
             Triangle {{ vertex0 {x} -99 0 vertex1 {x} 99 0 vertex2 -999 -99 0 }}
             Triangle {{ vertex0 {x} 99 0 vertex1 -999 99 0 vertex2 -999 -99 0 }} }}"
    )
}

fn row(picture: &RgbImage, y: u32) -> Vec<u8> {
    (0..picture.width()).map(|x| picture.get_pixel(x, y)[0]).collect()
}

#[test]
fn the_filter_weights_the_columns_of_a_pixel() {
    // 21 columns are traced as 63: pixel j of the fine grid lies at 20 j/62 - 10. The edge lies between fine columns
    // 30 and 31. So only the first of the fine columns 30, 31, 32 of output column 10 is white: weight 1/4.
    let folder = Folder::new();
    let edge = (20.0 * 30.5 / 62.0) - 10.0;
    let picture = folder.render(&edge_scene(edge), "-size 21 5 -filter");
    for y in 0..5 {
        let row = row(&picture, y);
        assert_eq!((row[9], row[10], row[11]), (255, 63, 0));
    }
}

#[test]
fn jittered_samples_lie_to_the_right_of_and_above_their_pixel() {
    // The samples of pixel j lie between j and j + 1 pixel widths. With the edge at 10.5, half of pixel 10 is white
    // in all four rows of strata. It is exactly 8 of 16 samples, because a border of the strata lies at 0.5.
    let folder = Folder::new();
    let edge = 20.0 * 10.5 / 20.0 - 10.0;
    let picture = folder.render(&edge_scene(edge), "-size 21 5 -jitter");
    assert_eq!(row(&picture, 2)[9..12], [255, 127, 0]);
}

#[test]
fn the_mean_over_many_seeds_is_the_covered_area() {
    // 30% of each pixel of a column is white. A stratum that the edge cuts (at 0.2 of its width) is white with
    // probability 0.2. So a pixel's mean over 4 rows of strata has expectation 0.3 and variance 4 * 0.2 * 0.8 / 16^2.
    let folder = Folder::new();
    let edge = 20.0 * 10.3 / 20.0 - 10.0;
    folder.write("scene.txt", edge_scene(edge));
    let (mut sum, mut count) = (0.0, 0.0);
    for seed in 0..40 {
        let picture = folder.render(&edge_scene(edge), &format!("-size 21 25 -jitter -seed {seed}"));
        for y in 0..25 {
            // Stored bytes are truncated multiples of 255/16.
            sum += ((f64::from(row(&picture, y)[10]) + 0.5) * 16.0 / 255.0).round() / 16.0;
            count += 1.0;
        }
    }
    let deviation = (4.0_f64 * 0.2 * 0.8 / 256.0 / count).sqrt();
    let z = (sum / count - 0.3) / deviation;
    assert!(z.abs() < 4.0, "mean {} z {z}", sum / count);
}

#[test]
fn stripes_of_one_fine_pixel_are_filtered_to_grey() {
    // Even fine columns are white, odd ones black: the weights of white are 1/4 + 1/4 or 1/2, both one half.
    let width = 20.0 / 62.0;
    let stripes: Vec<String> = (0..63)
        .step_by(2)
        .map(|column| {
            let left = f64::from(column) * width - 10.0 - width / 2.0;
            let right = left + width;
            format!(
                "Triangle {{ vertex0 {left} -99 0 vertex1 {right} -99 0 vertex2 {left} 9999 0 }}
                     Triangle {{ vertex0 {right} -99 0 vertex1 {right} 9999 0 vertex2 {left} 9999 0 }}"
            )
        })
        .collect();
    let scene = edge_scene(0.0);
    let head = &scene[..scene.find("Group").unwrap()];
    let scene = format!("{head} Group {{ numObjects 64 MaterialIndex 0 {} }}", stripes.join(" "));
    let picture = Folder::new().render(&scene, "-size 21 3 -filter");
    assert_eq!(row(&picture, 1), vec![127; 21]);
}

#[test]
fn jitter_and_filter_together_trace_144_rays_a_pixel() {
    let folder = Folder::new();
    // The edge cuts fine column 31 (the middle of output column 10) in half: 1/4 + 1/2 of 1/2.
    let edge = 20.0 * 31.5 / 62.0 - 10.0;
    let picture = folder.render(&edge_scene(edge), "-size 21 5 -jitter -filter");
    assert_eq!(row(&picture, 2)[9..12], [255, 127, 0]);
    let run = folder.a2("-input scene.txt -output o.png -size 4 3 -jitter -filter -explain");
    assert!(run.stderr.contains(&format!("camera rays: {}", 4 * 3 * 144)), "{}", run.stderr);
}

#[test]
fn normals_and_depths_are_averaged_after_they_are_mapped() {
    let folder = Folder::new();
    let edge = (20.0 * 30.5 / 62.0) - 10.0;
    folder.write("s.txt", edge_scene(edge));
    let run = folder.a2("-input s.txt -normals n.png -depth 0 10 d.png -size 21 5 -filter");
    assert_eq!(run.exit_code, 0);
    // A quarter of (0.5, 0.5, 1) or (0.5, 0.5, 0), by the triangle's side, and three quarters of background (0.5
    // each).
    let normal = folder.picture("n.png").get_pixel(10, 2).0;
    assert!(normal == [127, 127, 159] || normal == [127, 127, 95], "{normal:?}");
    // In the middle row the depth is 10 (a little more beside it, clamped to white); a miss is black.
    assert_eq!(folder.picture("d.png").get_pixel(10, 2).0, [63; 3]);
}
