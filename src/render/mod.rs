//! [`Scene`](crate::scene::Scene) in, [`Frame`] out: which rays, in which order, and what becomes of what they see.
//! [`tracer`] does the tracing.
//!
//! Either every pixel gets the same number of samples ([`render_uniform`]), or as many as an error or a time limit asks
//! for ([`render_adaptive`]).

mod adaptive;
mod allocation;
pub mod error_estimate;
mod pixel;
mod preview;
mod rays;
mod sample_counts;
mod samples;
mod tile_samples;
mod tiles;
mod tracer;
mod uniform;

pub use adaptive::render as render_adaptive;
pub use pixel::Pixel;
pub use sample_counts::SampleCounts;
pub use samples::{SamplePattern, SampleSet};
pub use tiles::Progress;
pub use uniform::render as render_uniform;

use crate::film::Film;
use crate::ray_counts::RayCounts;
use error_estimate::ErrorEstimate;
use std::time::Duration;

/// The pixels of a picture, and what they cost.
#[derive(Debug)]
pub struct Frame {
    pub film: Film,
    /// The rays traced for it.
    pub counts: RayCounts,
    pub samples: SampleCounts,
    /// How wrong the colours are; `None` where nothing is random, or too few samples were taken to tell.
    pub estimate: Option<ErrorEstimate>,
    /// Time that all threads together spent on turning samples into pixels; zero unless it was measured.
    pub filter: Duration,
}
