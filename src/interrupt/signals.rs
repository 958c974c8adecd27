//! Waits for signals in a thread of its own.

use super::ENDS_RENDERING;
use crate::output::{remove_unfinished, say};
use crate::timing::interrupt_rendering;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::flag;
use signal_hook::iterator::Signals;
use signal_hook::low_level::{emulate_default_handler, signal_name};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Builder;

/// Has a thread wait for the signals that end a process. Where no thread can be started, they end it as they would
/// anyway. A signal that is ignored from the start (by `nohup`, or in the background of a script) stays so.
pub fn wait_in_a_thread() {
    let ignored = ignored();
    let is_wanted = |signal: &i32| ignored >> (signal - 1) & 1 == 0;
    // A file that grows too large is an error of writing, not the end. If this fails, it is the end, as without it.
    let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
    let ends_process = || [SIGINT, SIGTERM, SIGHUP].into_iter().filter(is_wanted);
    let Ok(mut signals) = Signals::new(ends_process()) else { return };
    let wait = move || signals.forever().for_each(handle);
    if Builder::new().name("signals".to_owned()).spawn(wait).is_err() {
        ends_process().for_each(|signal| drop(flag::register_conditional_default(signal, Arc::new(true.into()))));
    }
}

fn handle(signal: i32) {
    if signal == SIGINT && ENDS_RENDERING.load(Ordering::Relaxed) && interrupt_rendering() {
        say("interrupted: rendering ends with the best picture so far (again: at once, without a picture)\n");
        return;
    }
    remove_unfinished(|| {
        let name = signal_name(signal).unwrap_or("a signal");
        say(&format!("interrupted by {name}: unfinished files are removed\n"));
        // Ends the process with the exit status of the signal.
        let _ = emulate_default_handler(signal);
    });
}

/// Returns the mask of the signals that were ignored when the process started. Only Linux says so.
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.split_once("\nSigIgn:").and_then(|(_, mask)| mask.lines().next());
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}
