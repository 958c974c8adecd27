//! The text of a scene file in, a [`Description`] out: what the file says, every node with its place in the text.
//!
//! Opens no file but the scene itself.

mod blocks;
mod description;
mod fields;
mod lexer;
mod parser;

pub use description::{
    At, BackgroundBlock, CameraBlock, Description, Leaf, LightBlock, MaterialBlock, Node, ShapeBlock,
    TransformStep,
};
pub use parser::{parse, parse_file};
