//! The worker threads: how many there are, and how they are started. And a stack that is large enough.

use crate::error::{Error, counted};
use crate::memory;
use crate::options::Options;
use crate::output::say;
use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuilder};
use std::io::ErrorKind;
use std::panic::resume_unwind;
use std::sync::mpsc::{Sender, channel};
use std::thread;

/// Bytes of stack that hold the deepest scene: up to a million were measured.
const LARGE_STACK: usize = 4 << 20;

/// Does the work of the main thread. Where the system gives this thread a small stack, another one does it: a scene whose
/// groups and transforms are nested is read and built level by level.
pub fn with_a_large_stack<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    if has_a_large_stack() {
        return work();
    }
    let mut work = Some(work);
    let done = thread::scope(|scope| {
        let work = || work.take().map(|work| work());
        let thread = thread::Builder::new().stack_size(LARGE_STACK).spawn_scoped(scope, work).ok()?;
        thread.join().unwrap_or_else(|panic| resume_unwind(panic))
    });
    done.or_else(|| work.take().map(|work| work())).expect("the work is done by a thread or left to this one")
}

#[cfg(unix)]
fn has_a_large_stack() -> bool {
    use rustix::process::{Resource, getrlimit};
    getrlimit(Resource::Stack).current.is_none_or(|bytes| bytes >= LARGE_STACK as u64)
}

/// The main thread of Windows has one million bytes.
#[cfg(not(unix))]
fn has_a_large_stack() -> bool {
    false
}

/// Starts the worker threads: where the system allows fewer than wanted, so many, with a hint. The main thread is
/// one of them: one that only waits would be a third thread on two processors, and a short run loses time to that.
///
/// # Errors
/// [`Error::Refused`] if the threads cannot work together.
pub fn start(options: &Options) -> Result<ThreadPool, Error> {
    let wanted = options.threads.unwrap_or_else(processors);
    let most = memory::most_threads().map_or(wanted, |most| most.min(wanted));
    let others: Vec<_> = (1..most).map_while(|_| waiting_thread()).collect();
    let count = 1 + others.len();
    if count < wanted && !options.quiet {
        say(&format!("hint: the system allows {}, not {wanted}\n", counted(count, "worker thread")));
    }
    let mut others = others.into_iter();
    ThreadPoolBuilder::new()
        .num_threads(count)
        .use_current_thread()
        .spawn_handler(|worker| match others.next().map(|thread| thread.send(worker)) {
            Some(Ok(())) => Ok(()),
            _ => Err(ErrorKind::BrokenPipe.into()),
        })
        .build()
        .map_err(|error| Error::Refused(format!("cannot start the worker threads: {error}")))
}

/// Starts a thread that waits for what it shall work for. There is none if the system allows no more.
fn waiting_thread() -> Option<Sender<ThreadBuilder>> {
    let (sender, receiver) = channel::<ThreadBuilder>();
    let work = move || receiver.recv().map_or((), ThreadBuilder::run);
    thread::Builder::new().spawn(work).ok().map(|_| sender)
}

/// Returns the number of threads without `-threads`: `RAYON_NUM_THREADS`, or the processors that the process may use, by
/// its affinity and its control group. A task of the scheduler Slurm takes no more than it was given.
fn processors() -> usize {
    let number = |name| std::env::var(name).ok().and_then(|count| count.parse().ok()).filter(|&count| count > 0);
    number("RAYON_NUM_THREADS").unwrap_or_else(|| {
        let here = thread::available_parallelism().map_or(1, usize::from);
        number("SLURM_CPUS_PER_TASK").map_or(here, |given: usize| given.min(here))
    })
}
