//! Fuzz targets of `a2`, for cargo-fuzz; `scripts/fuzz.sh` runs them.
#![forbid(unsafe_code)]

mod targets;

use std::sync::OnceLock;
use targets::{TARGETS, Target, lay_out};
use tempfile::TempDir;

/// Gives the target of a name these bytes, in a folder of this process.
pub fn run(name: &str, data: &[u8]) {
    static STARTED: OnceLock<(Target, TempDir)> = OnceLock::new();
    let (target, folder) = STARTED.get_or_init(|| {
        let target = TARGETS.into_iter().find(|target| target.0 == name).expect("a target of this name");
        let folder = tempfile::tempdir().expect("a folder for temporary files");
        lay_out(folder.path());
        (target.1, folder)
    });
    target(data, folder.path());
}
