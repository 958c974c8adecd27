//! Finding what a ray may hit without testing every item: a bounding volume hierarchy of eight boxes a node.
//!
//! ```text
//! boxes of items --build, sah, collapse--> Bvh<Leaf> --single, packet or stream traversal--> leaves that a ray may hit
//! ```
//!
//! The contract: culling only discards what provably cannot be hit. So the answer of a query is that of a loop over all
//! items, to the last bit. Boxes and triangles are culled in `f32`, in a [`CullingSpace`] in which all rounding errors are
//! bounded by constants ([`space`] and [`triangle_block`] derive them). Whoever traverses a tree runs the exact tests
//! of [`objects`](crate::objects) on what is left over.
//!
//! The tree knows boxes and not what is in them. There is one for the objects of a scene (`Bvh<u32>`, a leaf is an
//! object's index) and one for each mesh (`Bvh<TriangleBlock>`). Who wants to know what a picture is needs nothing here.

pub mod build;
mod collapse;
mod culling_packet;
mod item;
mod leaf_visitor;
mod node;
mod packet;
mod packet_bounds;
mod partition;
mod prefetch;
mod sah;
mod shaft;
mod single;
mod space;
mod stream;
mod triangle_block;

pub use culling_packet::{CullingPacket, GROUPS};
pub use leaf_visitor::LeafVisitor;
pub use node::{Bvh, Node};
pub use packet::{FEW, TraversalScratch};
pub use packet_bounds::PacketBounds;
pub use shaft::Shaft;
pub use single::DONE;
pub use space::{CullingSpace, Entry};
pub use triangle_block::{TriangleBlock, build_triangle_bvh};
