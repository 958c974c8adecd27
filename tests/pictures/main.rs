//! The pixels: the course's pictures, a second renderer, single statements, samples, and the same bytes at every run.

mod antialiasing;
mod determinism;
mod golden;
mod plain;
#[cfg(not(feature = "f32"))]
mod reference;
mod statements;
mod statistics;
#[path = "../support/mod.rs"]
mod support;
