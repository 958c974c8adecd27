//! Signals, panics and aborts: none leaves an unfinished file behind.

#[cfg(unix)]
mod signals;

use crate::output::remove_unfinished;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether Ctrl-C ends the process, not only rendering.
static ENDS_PROCESS: AtomicBool = AtomicBool::new(true);

/// From now on the first Ctrl-C ends rendering, not the process.
pub fn let_rendering_end() {
    ENDS_PROCESS.store(false, Ordering::Relaxed);
}

/// From now on a panic, which is a bug of this program, removes unfinished files before it ends the process.
pub fn handle_panics() {
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        remove_unfinished(|| {
            report(panic);
            // Not as where memory cannot be had.
            #[cfg(unix)]
            signals::abort();
        });
    }));
}

/// From now on the signals that end a process remove unfinished files first. An abort, as where memory cannot be had, does so,
/// too: the exit code is 1 then, and a line says why.
pub fn handle_signals() {
    #[cfg(unix)]
    signals::wait_in_a_thread();
}
