//! Hits as numbers: trees against loops over all triangles (`queries`), and scenes that break ray tracers, each held to a
//! property or a closed answer that needs no renderer to decide.
//!
//! Every such scene states the bound that its error analysis gives and what was measured; both go into a file named by
//! `A2_NUMERICS_TABLE`, if that is set, and from there into `docs/numerics.md` (by `scripts/numerics.sh`). Built with
//! the `f32` feature the same cases show what single precision loses, and many fail; that is what they are for.

mod acne;
mod exact;
mod input;
mod leaks;
mod pictures;
mod planes;
mod properties;
// Compares the bits of `f64`.
#[cfg(not(feature = "f32"))]
mod queries;
mod rays;
mod shading;
mod spheres;
mod support;
mod transforms;
mod triangles;
