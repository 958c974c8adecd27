//! Tells `-version` what is built: the commit and the target.

use std::path::Path;
use std::process::Command;

fn main() {
    // With the sources the library is built anew anyway; a commit alone is no reason to do that.
    println!("cargo::rerun-if-changed=src");
    println!("cargo::rustc-env=A2_COMMIT={}", commit().unwrap_or_else(|| "unknown".to_owned()));
    println!("cargo::rustc-env=A2_TARGET={}", std::env::var("TARGET").unwrap_or_default());
}

/// Returns the commit of this folder's repository, with `-dirty` if files differ from it; `None` without one.
fn commit() -> Option<String> {
    Path::new(".git").exists().then_some(())?;
    let arguments = ["--no-optional-locks", "describe", "--always", "--dirty", "--exclude=*"];
    let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}
