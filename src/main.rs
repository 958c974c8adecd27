//! `a2`: passes the command line to the library, prints the result and returns the exit code.
#![forbid(unsafe_code)]

use a2::error::Error;
use std::io::IsTerminal as _;
use std::process::ExitCode;

fn main() -> ExitCode {
    a2::interrupt::handle_signals();
    a2::interrupt::handle_panics();
    let (error, exit_code) = match a2::run(std::env::args_os().skip(1)) {
        Ok(outcome) => match a2::output::print(&outcome.text) {
            Ok(()) => return ExitCode::from(outcome.exit_code),
            Err(error) => {
                (Error::Refused(format!("cannot write to standard output: {error}")), outcome.if_not_printed)
            }
        },
        Err(refused) => refused,
    };
    a2::output::say_in_colors(&format!("{}\n", error.report(shows_colors())));
    ExitCode::from(exit_code)
}

/// Returns whether errors are shown in colours: on a terminal that has them, unless `NO_COLOR` is set.
fn shows_colors() -> bool {
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let is_dumb = std::env::var_os("TERM").is_some_and(|value| value == "dumb");
    std::io::stderr().is_terminal() && !is_set("NO_COLOR") && !is_dumb
}
