//! `a2`: hands the command line to the library and shows what comes back.
#![forbid(unsafe_code)]

use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    // Output that nobody reads any more (a closed pipe) is no reason to fail.
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
