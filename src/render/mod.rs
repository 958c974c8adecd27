//! [`Scene`](crate::scene::Scene) in, [`Film`](crate::film::Film) out. Begin reading at [`trace`].

mod allocation;
pub mod estimate;
mod progressive;
mod rays;
pub mod robust;
mod sampling;
mod surfaces;
mod tiles;
pub mod trace;

pub use progressive::render as render_progressively;
pub use sampling::{SamplePattern, SampleSet};
pub use tiles::{Frame, Progress, render};
