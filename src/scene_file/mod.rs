//! The scene parser: the text of a scene file in, a [`Description`] out, every node with its place in the text.
//!
//! It opens no file but the scene file.

mod blocks;
mod description;
mod fields;
mod file;
mod indentation;
mod lexer;
mod lights;
mod mistakes;
mod parser;
mod shapes;
mod transforms;
mod typing;
mod words;

pub use description::{At, BackgroundBlock, CameraBlock, Description, Leaf, LeafShape, Node, TransformStep};
pub use file::parse_file;
pub use parser::{Parsed, parse};
