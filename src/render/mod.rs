//! [`Scene`](crate::scene::Scene) in, [`Film`](crate::film::Film) out. Begin reading at [`trace`].

mod adaptive;
mod allocation;
pub mod error_estimate;
mod pixel;
mod rays;
pub mod robust;
mod samples;
mod surfaces;
mod tiles;
pub mod trace;

pub use adaptive::render as render_adaptive;
pub use pixel::Pixel;
pub use samples::{SamplePattern, SampleSet};
pub use tiles::{Frame, Progress, render};
