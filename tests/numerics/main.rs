//! Tests of hits as numbers: trees against loops over all triangles (`queries`), and cases that break ray tracers,
//! each with a property or an exact result that is known without a renderer.
//!
//! Every case has an error bound from its analysis and a measured error. Both are written to the file that
//! `A2_NUMERICS_TABLE` names, if it is set; `scripts/numerics.sh` puts them into `docs/numerics.md`. Built with the
//! `f32` feature, the same cases show what single precision loses: many of them fail, as they should.

mod acne;
mod brightness;
mod exact;
mod extremes;
mod input;
mod leaks;
mod pictures;
mod planes;
mod properties;
// Compares the bits of `f64`.
#[cfg(not(feature = "f32"))]
mod queries;
#[cfg(not(feature = "f32"))]
mod query_cases;
#[cfg(not(feature = "f32"))]
mod query_loops;
mod rays;
mod shading;
mod spheres;
mod support;
mod transforms;
mod triangles;
