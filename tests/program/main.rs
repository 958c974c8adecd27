//! Tests of the program: the command line, mistakes in scenes, what the plan leaves out, and the imports of `src/`.

mod architecture;
mod cli;
mod mutations;
mod needs;
mod parse_errors;
mod rust_source;
#[path = "../support/mod.rs"]
mod support;
