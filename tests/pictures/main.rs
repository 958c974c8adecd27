//! Tests of pictures: the course's pictures, a second renderer, single rules of the starter, random samples, and
//! equal bytes at every run.

mod antialiasing;
mod coverage;
mod cube_maps;
mod determinism;
mod golden;
mod pixel;
mod plain;
#[cfg(not(feature = "f32"))]
mod reference;
mod statements;
mod statistics;
#[path = "../support/mod.rs"]
mod support;
