//! The text of a scene file in, a [`Description`] out: what the file says, every node with its place in the text.
//!
//! Opens no file but the scene itself.

mod blocks;
mod description;
mod fields;
mod lexer;
mod lights;
mod parser;
mod shapes;
mod transforms;

pub use description::{At, BackgroundBlock, CameraBlock, Description, Leaf, LeafShape, Node, TransformStep};
pub use parser::{parse, parse_file};
