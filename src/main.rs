//! `a2`: passes the command line to the library, prints the result and returns the exit code.
#![forbid(unsafe_code)]

use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    // Errors of writing are ignored, because a closed pipe is no reason to fail.
    match a2::run(std::env::args_os().skip(1)) {
        Ok(outcome) => {
            let _ = std::io::stdout().write_all(outcome.text.as_bytes());
            ExitCode::from(outcome.exit_code)
        }
        Err((error, exit_code)) => {
            let _ = writeln!(std::io::stderr(), "error: {error}");
            ExitCode::from(exit_code)
        }
    }
}
