//! Finding the nearest of many objects without asking each.
//!
//! The contract: exactly the hit that a loop over all objects returns, to the last bit. Nobody who wants to understand
//! the picture needs to read further here. Boxes and pre-tests in `f32` only ever discard what cannot be hit
//! ([`frame`] and [`triangles`] say why); the objects decide, in [`Real`](vecmath::Real).
//!
//! [`build`] makes a [`Tree`](tree::Tree) of boxes, [`walk`] takes one ray through it, [`beam`] up to 64 that lie side by
//! side and [`stream`] up to 64 that do not; all of it is written once, in the lanes of [`simd`].

mod beam;
mod build;
mod bundle;
mod frame;
pub mod kept;
mod objects;
mod questions;
mod range;
mod shaft;
pub mod simd;
mod split;
mod stream;
mod tree;
mod triangle_tree;
mod triangles;
mod walk;

pub use objects::{Accelerator, Hit, LOOP_OBJECTS};
pub use triangle_tree::{Decide, TriangleTree};
