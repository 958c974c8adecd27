//! The renderer: [`Scene`](crate::scene::Scene) in, [`Frame`] out. It makes rays of pixels, and pixels of what the
//! rays see. [`tracer`] traces the rays.
//!
//! Either every pixel gets the same number of samples ([`render_uniform`]), or a target error or a time limit decides
//! their number ([`render_adaptive`]).

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
pub use preview::MIRRORS as PREVIEW_MIRRORS;
pub use samples::{SamplePattern, SampleSet};
pub use tiles::Progress;
pub use uniform::render as render_uniform;
