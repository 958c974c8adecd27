//! The program as a user meets it: the command line, mistakes in scenes, what is done and what is left out.

mod architecture;
mod cli;
mod mutations;
mod needs;
mod parse_errors;
mod rust_source;
#[path = "../support/mod.rs"]
mod support;
