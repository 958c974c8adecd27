//! The program as a user meets it: the command line, mistakes in scenes, what is done and what is left out.

mod architecture;
mod cli;
mod measuring;
mod mutations;
mod needs;
mod numbers;
mod parse_errors;
mod rust_source;
mod snapshots;
#[path = "../support/mod.rs"]
mod support;
