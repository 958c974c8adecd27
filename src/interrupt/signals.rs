//! Waits for signals in a thread of its own.

use super::ENDS_PROCESS;
use crate::output::{remove_unfinished, remove_unfinished_if_possible, say};
use crate::timing::{IS_INTERRUPTED, interrupt_rendering};
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use signal_hook::consts::{SIGABRT, SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXCPU, SIGXFSZ};
use signal_hook::flag;
use signal_hook::iterator::Signals;
use signal_hook::low_level::{emulate_default_handler, exit, pipe, signal_name};
use std::io::{self, Write as _};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Builder;

/// The exit code where memory cannot be had.
const NO_MEMORY: i32 = 1;

/// Whether an abort ends the process at once: there is no thread that ends it, or this thread itself may abort.
static ABORT_ENDS_AT_ONCE: AtomicBool = AtomicBool::new(true);

/// Has a thread wait for the signals that end a process. A signal that is ignored from the start (by `nohup`, or in the
/// background of a script) stays so. What only comes of a limit is not waited for where there is none.
pub fn wait_in_a_thread() {
    let ignored = ignored();
    let is_wanted = |signal: &i32| ignored >> (signal - 1) & 1 == 0;
    let of_time = is_limited(Resource::Cpu).then_some(SIGXCPU);
    if of_time.is_some() {
        end_before_time_is_up();
    }
    let ending = || [SIGINT, SIGTERM, SIGHUP, SIGQUIT].into_iter().chain(of_time).filter(is_wanted);
    if is_limited(Resource::Fsize) {
        // A file that grows too large is an error of writing, not the end. If this fails, it is the end, as without it.
        let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
    }
    let may_lack_memory = is_limited(Resource::As) || is_limited(Resource::Data);
    if may_lack_memory {
        // Actions are done in the order in which they are registered.
        let _ = flag::register_conditional_shutdown(SIGABRT, NO_MEMORY, &ABORT_ENDS_AT_ONCE);
    }
    let Ok(mut signals) = Signals::new(ending().chain(may_lack_memory.then_some(SIGABRT))) else { return };
    let wait = move || signals.forever().for_each(handle);
    if Builder::new().name("signals".to_owned()).spawn(wait).is_err() {
        ending().for_each(handle_without_thread);
    } else if may_lack_memory && hold_aborting_threads().is_ok() {
        ABORT_ENDS_AT_ONCE.store(false, Ordering::Relaxed);
    }
}

fn is_limited(resource: Resource) -> bool {
    getrlimit(resource).current.is_some()
}

/// Has SIGXCPU come a second before SIGKILL would: after `ulimit -t` both limits are the same, and only SIGKILL comes.
fn end_before_time_is_up() {
    let Rlimit { current, maximum } = getrlimit(Resource::Cpu);
    if let (Some(soft), Some(hard @ 2..)) = (current, maximum)
        && soft >= hard
    {
        let _ = setrlimit(Resource::Cpu, Rlimit { current: Some(hard - 1), maximum });
    }
}

fn handle(signal: i32) {
    if signal == SIGABRT {
        // The thread that aborts may hold whatever it held, and memory cannot be had.
        remove_unfinished_if_possible(|| {
            say("error: not enough memory ('ulimit -v' and 'ulimit -d' show the limits), or aborted by SIGABRT; \
                 smaller pictures and fewer -threads need less\n");
            exit(NO_MEMORY);
        });
    }
    if signal == SIGINT && !ENDS_PROCESS.load(Ordering::Relaxed) && interrupt_rendering() {
        say("interrupted: rendering ends with the best picture so far (again: at once, without a picture)\n");
        return;
    }
    ABORT_ENDS_AT_ONCE.store(true, Ordering::Relaxed);
    remove_unfinished(|| {
        let name = signal_name(signal).unwrap_or("a signal");
        say(&format!("interrupted by {name}: unfinished files are removed\n"));
        // Ends the process with the exit status of the signal.
        let _ = emulate_default_handler(signal);
    });
}

/// Has a signal end the process as it would anyway, but for the first Ctrl-C where that ends rendering. Nothing is said, and
/// what has a temporary name keeps it. If this fails, nothing ends the process but SIGKILL.
fn handle_without_thread(signal: i32) {
    if signal == SIGINT {
        let _ = flag::register_conditional_default(SIGINT, &ENDS_PROCESS);
        let _ = flag::register(SIGINT, &IS_INTERRUPTED);
        let _ = flag::register(SIGINT, &ENDS_PROCESS);
    } else {
        let _ = flag::register_conditional_default(signal, Arc::new(true.into()));
    }
}

/// Has a thread that aborts, because it gets no memory, wait until another one has ended the process: it writes into a pipe
/// that is full. All that safe code may do in a signal is to set a flag, to write a byte, or to end the process.
fn hold_aborting_threads() -> io::Result<()> {
    let (reader, mut writer) = io::pipe()?;
    // Sets the pipe to not wait.
    pipe::register(SIGABRT, writer.try_clone()?)?;
    while writer.write(&[0; 4096]).is_ok() {}
    fcntl_setfl(&writer, fcntl_getfl(&writer)? - OFlags::NONBLOCK)?;
    // Without a reader, writing would fail.
    std::mem::forget(reader);
    Ok(())
}

/// Ends the process by SIGABRT, as if nothing handled it.
pub fn abort() {
    let _ = emulate_default_handler(SIGABRT);
}

/// Returns the mask of the signals that were ignored when the process started. Only Linux says so.
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.split_once("\nSigIgn:").and_then(|(_, mask)| mask.lines().next());
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}
