//! The scene parser: the text of a scene file in, a [`Description`] out, every node with its place in the text.
//!
//! It opens no file but the scene file.

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
