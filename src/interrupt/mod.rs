//! Signals and panics: neither leaves an unfinished file behind.

#[cfg(unix)]
mod signals;

use crate::output::remove_unfinished;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the first Ctrl-C ends rendering, not the process.
static ENDS_RENDERING: AtomicBool = AtomicBool::new(false);

/// From now on the first Ctrl-C ends rendering, not the process.
pub fn let_rendering_end() {
    ENDS_RENDERING.store(true, Ordering::Relaxed);
}

/// From now on a panic, which is a bug of this program, removes unfinished files before it ends the process.
pub fn handle_panics() {
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| remove_unfinished(|| report(panic))));
}

/// From now on the signals that end a process remove unfinished files first.
pub fn handle_signals() {
    #[cfg(unix)]
    signals::wait_in_a_thread();
}
