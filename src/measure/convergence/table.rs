//! Points as a table.

use super::Point;
use std::fmt::Write as _;

/// Returns the points as CSV, a line each; unknown values are empty.
pub fn csv(points: &[Point]) -> String {
    let mut text = "sampler,samples,seconds,cpu_seconds,rays,estimated_rmse_levels,estimated_low_95,\
                    estimated_high_95,estimated_rmse_linear,true_rmse_levels,true_rmse_linear,true_ssim,\
                    target_levels,camera_rays_a_pixel\n"
        .to_owned();
    let known = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    for point in points {
        let (levels, linear) = (point.estimate.map(|e| e.levels), point.estimate.map(|e| e.linear));
        let fields = [
            point.method.name().to_owned(),
            point.samples.to_string(),
            point.times.wall.as_secs_f64().to_string(),
            point.times.cpu.as_secs_f64().to_string(),
            point.rays.to_string(),
            known(levels.map(|levels| levels.rmse)),
            known(levels.map(|levels| levels.low)),
            known(levels.map(|levels| levels.high)),
            known(linear.map(|linear| linear.rmse)),
            known(point.true_error.as_ref().map(|error| error.rmse_levels)),
            known(point.true_error.as_ref().map(|error| error.rmse_linear)),
            known(point.true_error.as_ref().map(|error| error.ssim)),
            known(point.target),
            point.camera_rays.to_string(),
        ];
        let _ = writeln!(text, "{}", fields.join(","));
    }
    text
}
