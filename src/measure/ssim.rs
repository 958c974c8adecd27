//! Structural similarity of two pictures (Wang et al., Image Quality Assessment: From Error Visibility to Structural
//! Similarity, IEEE TIP 13(4), 2004): 1 for equal pictures, less where structure is lost.
//!
//! The windows are 8 x 8 pixels side by side, smaller at the right and lower edge, and weighted by their area.
//! Variances are sums over a window and not means, as in the crate `image-compare`, so that values can be compared
//! with older ones. A little noise in a flat window counts for more than in the paper.

use std::ops::Range;

/// Side of a window in pixels.
const WINDOW: usize = 8;
/// (0.01 L)^2 and (0.03 L)^2 with L = 255. They keep the quotients finite in flat windows.
const C1: f64 = (0.01 * 255.0) * (0.01 * 255.0);
const C2: f64 = (0.03 * 255.0) * (0.03 * 255.0);

/// Returns the similarity of two pictures in their worst channel. They have three bytes a pixel and rows of `width`.
pub fn ssim(a: &[u8], b: &[u8], width: usize) -> f64 {
    let height = a.len() / 3 / width;
    let similarity = |channel| {
        let (mut sum, mut area) = (0.0, 0.0);
        for x in (0..width).step_by(WINDOW) {
            for row in (0..height).step_by(WINDOW) {
                let (columns, rows) = (x..(x + WINDOW).min(width), row..(row + WINDOW).min(height));
                let pixels = (columns.len() * rows.len()) as f64;
                let [a, b] = [a, b].map(|bytes| window(bytes, width, columns.clone(), rows.clone(), channel));
                sum += pixels * window_ssim(&a, &b);
                area += pixels;
            }
        }
        sum / area
    };
    (0..3).map(similarity).fold(1.0, f64::min)
}

/// Returns one channel of a window.
fn window(bytes: &[u8], width: usize, columns: Range<usize>, rows: Range<usize>, channel: usize) -> Vec<f64> {
    let pixels = rows.flat_map(|row| columns.clone().map(move |x| row * width + x));
    pixels.map(|pixel| f64::from(bytes[3 * pixel + channel])).collect()
}

fn window_ssim(a: &[f64], b: &[f64]) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let covariance = |a: &[f64], mean_a: f64, b: &[f64], mean_b: f64| {
        a.iter().zip(b).map(|(a, b)| (a - mean_a) * (b - mean_b)).sum::<f64>()
    };
    let variances = covariance(a, mean_a, a, mean_a) + covariance(b, mean_b, b, mean_b);
    (2.0 * mean_a * mean_b + C1) * (2.0 * covariance(a, mean_a, b, mean_b) + C2)
        / ((mean_a.powi(2) + mean_b.powi(2) + C1) * (variances + C2))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes a slope with noise of this strength.
    fn picture(width: usize, height: usize, noise: u32) -> Vec<u8> {
        let byte = |i: usize| {
            let random = (i as u32).wrapping_mul(0x9e37_79b9) >> 16;
            (i % (3 * width) * 200 / (3 * width)) as u32 + random % (noise + 1)
        };
        (0..3 * width * height).map(|i| byte(i) as u8).collect()
    }

    /// The expected values are those of the crate `image-compare` 0.5.0, `rgb_similarity_structure` with
    /// `MSSIMSimple`.
    #[test]
    fn values_are_those_of_another_program() {
        for (width, height, noise, expected) in [
            (1, 1, 55, 0.9794022109666748),
            (8, 8, 0, 1.0),
            (8, 8, 5, 0.9991722101920618),
            (9, 17, 1, 0.9969055636870888),
            (31, 20, 55, 0.5531082019693077),
            (70, 50, 5, 0.9625197030409766),
            (70, 50, 55, 0.21998861205217674),
        ] {
            let found = ssim(&picture(width, height, 0), &picture(width, height, noise), width);
            assert!((found - expected).abs() < 1e-12, "{width} x {height}, {noise}: {found}");
        }
    }
}
