//! `a2`: passes the command line to the library, prints the result and returns the exit code.
#![forbid(unsafe_code)]

use std::io::Write;
use std::process::ExitCode;

/// The exit code where the result cannot be printed. 1 would mean that compared pictures are unlike.
const CANNOT_PRINT: u8 = 2;

fn main() -> ExitCode {
    a2::interrupt::handle_signals();
    a2::interrupt::handle_panics();
    let (message, exit_code) = match a2::run(std::env::args_os().skip(1)) {
        Ok(outcome) => match print(&outcome.text) {
            Ok(()) => return ExitCode::from(outcome.exit_code),
            Err(error) => (format!("cannot write to standard output: {error}"), CANNOT_PRINT),
        },
        Err((error, exit_code)) => (error.to_string(), exit_code),
    };
    a2::output::say(&format!("error: {message}\n"));
    ExitCode::from(exit_code)
}

fn print(text: &str) -> std::io::Result<()> {
    let mut stdout = std::io::stdout().lock();
    stdout.write_all(text.as_bytes())?;
    stdout.flush()
}
