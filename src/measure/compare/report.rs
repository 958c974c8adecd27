//! What `-compare` with `-report` writes: the figures of a [`Comparison`] as JSON.

use super::comparison::{Comparison, WorstPixel};
use super::regions::Region;
use crate::options::CompareOptions;
use serde_json::{Value, json};

/// Number of regions in a report: enough to find every mistake, and a short file for a picture of noise.
const MOST_REGIONS: usize = 100;

/// Returns the report on two pictures of the same size. Infinite and undefined numbers are null.
pub fn of_pixels(options: &CompareOptions, comparison: &Comparison) -> String {
    let verdict = if options.are_alike(comparison.percent_over(options.levels)) { "alike" } else { "different" };
    let regions = &comparison.regions;
    text(&json!({
        "a": options.a.display().to_string(),
        "b": options.b.display().to_string(),
        "verdict": verdict,
        "tolerance": { "levels": options.levels, "percent": options.percent },
        "width": comparison.width,
        "height": comparison.height,
        "worst_levels": comparison.worst,
        "rmse_levels": comparison.rmse,
        "psnr_db": comparison.psnr(),
        "pixels_over_levels": {
            "0": comparison.pixels_over(0),
            "1": comparison.pixels_over(1),
            "8": comparison.pixels_over(8),
        },
        "pixels_of_other_alpha": comparison.alpha,
        "worst_pixel": comparison.worst_pixel.as_ref().map(worst_pixel_json),
        "regions": regions.iter().take(MOST_REGIONS).map(region_json).collect::<Vec<_>>(),
        "regions_in_all": regions.len(),
    }))
}

/// Returns the report on two pictures of different sizes.
pub fn of_sizes(options: &CompareOptions, a: (u32, u32), b: (u32, u32)) -> String {
    text(&json!({
        "a": options.a.display().to_string(),
        "b": options.b.display().to_string(),
        "verdict": "sizes differ",
        "size_of_a": [a.0, a.1],
        "size_of_b": [b.0, b.1],
    }))
}

fn text(value: &Value) -> String {
    format!("{value:#}\n")
}

fn worst_pixel_json(pixel: &WorstPixel) -> Value {
    let (unit, [a, b]) = if pixel.is_of_numbers {
        ("numbers", [pixel.a, pixel.b].map(|color| json!(color)))
    } else {
        ("bytes", [pixel.a, pixel.b].map(|color| json!(color.map(|channel| channel as u8))))
    };
    json!({ "x": pixel.x, "y": pixel.y, "a": a, "b": b, "unit": unit })
}

fn region_json(region: &Region) -> Value {
    json!({
        "left": region.left,
        "top": region.top,
        "right": region.right,
        "bottom": region.bottom,
        "pixels": region.pixels,
        "worst_levels": region.worst,
    })
}
