//! [`Scene`](crate::scene::Scene) in, [`Film`](crate::film::Film) out. Begin reading at [`trace`].

pub mod robust;
mod sampling;
mod tiles;
pub mod trace;

pub use sampling::jitter_offset;
pub use tiles::{Progress, render};
