//! Tests of the program: the command line, mistakes in scenes, what the plan leaves out, and the imports of `src/`.

mod architecture;
mod braces;
mod cli;
mod compare;
mod convergence;
mod cost;
mod cube_map_files;
mod depths;
mod extending;
mod faults;
#[cfg(unix)]
mod frames;
mod fuzz_seeds;
mod gallery;
#[cfg(unix)]
mod grading;
mod hints;
mod libraries;
mod measuring;
mod memory;
mod mesh_names;
mod mesh_remarks;
mod meshes;
mod messages;
mod mistakes;
mod mutations;
mod needs;
mod numbers;
mod outputs;
mod pages;
mod parse_errors;
mod parts;
mod picture_files;
mod pixel;
mod readme;
#[cfg(unix)]
mod report;
mod rust_source;
mod scales;
mod snapshots;
#[path = "../support/mod.rs"]
mod support;
mod terminal;
