//! [`Scene`](crate::scene::Scene) in, [`Frame`] out: which rays, in which order, and what becomes of what they see.
//! [`tracer`] does the tracing.
//!
//! Either every pixel gets the same number of samples ([`render_uniform`]), or as many as an error or a time limit asks
//! for ([`render_adaptive`]).

mod adaptive;
mod allocation;
pub mod error_estimate;
mod frame;
mod pixel;
mod preview;
mod rays;
mod samples;
mod tile_samples;
mod tiles;
mod tracer;
mod uniform;

pub use adaptive::render as render_adaptive;
pub use frame::{Frame, SampleCounts};
pub use pixel::Pixel;
pub use samples::{SamplePattern, SampleSet};
pub use tiles::Progress;
pub use uniform::render as render_uniform;
