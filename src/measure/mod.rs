//! Measures the cost and the error of pictures: by their own estimate, against a reference, against another picture.

mod compare;
mod convergence;
mod reference;
mod report;
mod report_text;
mod ssim;

pub use compare::{CANNOT_COMPARE, Comparison, Region, compare_files};
pub use convergence::{Convergence, render as render_convergence, sentences, shown as convergence_file};
pub use reference::{Reference, TrueError};
pub use report::{Phases, Report};
