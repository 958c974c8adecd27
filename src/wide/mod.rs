//! The same as [`trace`](crate::trace), 64 rays at a time.
//!
//! Nothing is defined here. Each file calls the scalar formulas of another one in loops over the lanes of a packet
//! (see [`packet`](crate::simd::packet)), which the compiler turns into wide instructions:
//!
//! | here | calls |
//! |---|---|
//! | [`camera`] | `camera` |
//! | [`intersect`], [`mesh`], [`triangle`], [`hit_packet`] | `objects`, culled by `bvh` |
//! | [`normals`] | `objects` |
//! | [`shade`] | `light`, `material` |
//! | [`light_culling`] | nothing: it finds out which lights need not be shaded |
//! | [`cube_map`] | `cube_map` |
//! | [`trace`], [`mirror_queue`] | the steps of `trace`, in the same order |
//!
//! The rule: delete this folder and `bvh`, let `render` call [`trace_ray`](crate::trace::trace_ray), and every picture is
//! the same to the bit. Tests hold it with `-plain`.

mod camera;
mod cube_map;
mod hit_packet;
mod intersect;
mod light_culling;
mod mesh;
mod mirror_queue;
mod normals;
mod shade;
#[cfg(test)]
mod tests;
mod trace;
mod triangle;

pub use hit_packet::HitPacket;
pub use intersect::Scratch;
pub use trace::{PACKETS_AT_ONCE, PacketTracer};
