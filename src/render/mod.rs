//! The renderer: [`Scene`](crate::scene::Scene) in, [`Frame`] out. It makes rays of pixels, and pixels of what the
//! rays see. [`tracer`] traces the rays.
//!
//! Either every pixel gets the same number of samples ([`render_uniform`]), or a target error or a time limit decides
//! their number ([`render_adaptive`]).

mod adaptive;
mod allocation;
mod bands;
mod depth;
mod empty_tiles;
pub mod error_estimate;
mod error_map;
mod error_sums;
mod finishing;
mod frame;
mod halves_error;
mod in_flight;
mod passes;
mod pilot;
mod pixel;
mod preview;
mod rays;
mod samples;
mod sobol;
mod spread;
mod spread_factor;
mod stratified;
mod tile_cost;
mod tile_samples;
mod tiles;
mod tracer;
mod uniform;
mod unseen;

pub use adaptive::{render as render_adaptive, render_bands as render_adaptive_bands};
pub use depth::{has_hit_between, with_background as depths_with_background, with_range as with_depth_range};
pub use frame::{Frame, SampleCounts};
pub use pixel::{DepthRange, Pixel};
pub use preview::MIRRORS as PREVIEW_MIRRORS;
pub use rays::RayMaker;
pub use samples::{SamplePattern, SampleSet};
pub use tiles::Progress;
pub use uniform::{render as render_uniform, render_bands, render_before as render_uniform_before};

use crate::film::Planes;
use crate::options::Options;
use tile_samples::TileSamples;
use tiles::Tiles;

/// Estimates the memory for the pictures in bytes: some bands of them, or the film, and with adaptive sampling the sums
/// over samples.
pub fn bytes_needed(options: &Options) -> u64 {
    let planes = Planes::wanted_by(options);
    // What shows that there is nothing, and what is made of it; counts, and three pictures of them.
    let has_background = options.depth.as_ref().is_some_and(|depth| depth.background.is_some());
    let of_background = if has_background { 4 } else { 0 };
    let of_findings = of_background + if options.cost.is_some() { 3 * 4 + 3 * 3 } else { 0 };
    let measure = &options.measure;
    let has_sums = measure.is_adaptive() || measure.convergence.is_some();
    let sums = if has_sums { TileSamples::bytes_per_pixel(planes) } else { 0 };
    let all_bands = options.pixel_count() * planes.bytes_per_pixel() as u64;
    let in_flight = in_flight::bytes_in_flight(Tiles { region: options.shown() }, planes).min(all_bands);
    if !options.keeps_film() {
        return in_flight + options.pixel_count() * (sums + of_findings) as u64;
    }
    // The reference as numbers, what it is decoded from, and the picture in its form; and the bytes of the error map.
    let of_reference = if measure.reference.is_some() { 28 } else { 0 };
    let of_map = if measure.wants_error_map() { 1 } else { 0 };
    // One of the pictures of a curve is kept while others are rendered.
    let films = if measure.convergence.is_some() { 2 } else { 1 };
    let bytes = films * planes.bytes_per_pixel() + sums + of_findings + of_reference + of_map;
    in_flight + options.pixel_count() * bytes as u64
}
