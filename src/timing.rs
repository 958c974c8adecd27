//! [`Stopwatch`] measures [`Times`]: wall time and processor time. A [`Deadline`] says when to stop.

use std::ops::{Add, AddAssign};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Time on the clock, and processor time of all threads of this program together.
#[derive(Clone, Copy, Debug, Default)]
pub struct Times {
    pub wall: Duration,
    pub cpu: Duration,
}

impl AddAssign for Times {
    fn add_assign(&mut self, other: Self) {
        self.wall += other.wall;
        self.cpu += other.cpu;
    }
}

impl Add for Times {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl Times {
    /// Subtracts a part; the result is never below zero.
    #[must_use]
    pub fn without(self, part: Self) -> Self {
        Self { wall: self.wall.saturating_sub(part.wall), cpu: self.cpu.saturating_sub(part.cpu) }
    }
}

/// Whether rendering was interrupted: then every deadline but [`Deadline::NEVER`] is over.
pub static IS_INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Ends rendering with the best picture so far, where there is a deadline. Returns false if it was called before.
pub fn interrupt_rendering() -> bool {
    !IS_INTERRUPTED.swap(true, Ordering::Relaxed)
}

/// When to stop tracing rays, if ever.
#[derive(Clone, Copy, Debug)]
pub struct Deadline {
    at: Option<Instant>,
    can_interrupt: bool,
}

impl Deadline {
    pub const NEVER: Self = Self { at: None, can_interrupt: false };
    /// When the user interrupts rendering.
    pub const ON_INTERRUPT: Self = Self { at: None, can_interrupt: true };

    /// Returns the deadline that is so much earlier.
    #[must_use]
    pub fn earlier(self, time: Duration) -> Self {
        // Before the clock began there is no time: then it is over now.
        Self { at: self.at.map(|at| at.checked_sub(time).unwrap_or_else(Instant::now)), ..self }
    }

    /// Returns whether there is a time limit.
    pub fn is_set(self) -> bool {
        self.at.is_some()
    }

    /// Returns whether it is time to stop. Does not look at the clock if there is no time limit.
    pub fn is_over(self) -> bool {
        (self.can_interrupt && IS_INTERRUPTED.load(Ordering::Relaxed))
            || self.at.is_some_and(|at| Instant::now() >= at)
    }
}

/// Measures [`Times`] from its start.
#[derive(Debug)]
pub struct Stopwatch {
    wall: Instant,
    cpu: Duration,
}

impl Stopwatch {
    pub fn start() -> Self {
        Self { wall: Instant::now(), cpu: processor_time() }
    }

    /// Returns the deadline so many seconds after the start. One beyond the range of the clock is never over.
    pub fn deadline(&self, seconds: f64) -> Deadline {
        let duration = Duration::try_from_secs_f64(seconds.max(0.0)).ok();
        Deadline { at: duration.and_then(|duration| self.wall.checked_add(duration)), ..Deadline::ON_INTERRUPT }
    }

    /// Returns the time since the start.
    pub fn times(&self) -> Times {
        Times { wall: self.wall.elapsed(), cpu: processor_time().saturating_sub(self.cpu) }
    }
}

/// Returns the processor time of this process so far.
#[cfg(unix)]
fn processor_time() -> Duration {
    use rustix::time::{ClockId, clock_gettime};
    Duration::try_from(clock_gettime(ClockId::ProcessCPUTime)).unwrap_or_default()
}

/// Returns zero: processor time is only known on Unix.
#[cfg(not(unix))]
fn processor_time() -> Duration {
    Duration::ZERO
}

/// Runs `work` and measures its time.
pub fn timed<T>(work: impl FnOnce() -> T) -> (T, Times) {
    let watch = Stopwatch::start();
    let result = work();
    (result, watch.times())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_takes_both_kinds_of_time() {
        let watch = Stopwatch::start();
        // Other threads can only add processor time.
        let start = Instant::now();
        while start.elapsed() < Duration::from_millis(20) {
            std::hint::spin_loop();
        }
        let times = watch.times();
        assert!(times.wall >= Duration::from_millis(20), "{times:?}");
        assert!(cfg!(not(unix)) || times.cpu > Duration::ZERO, "{times:?}");
    }

    #[test]
    fn a_deadline_is_over_when_its_time_has_come() {
        let watch = Stopwatch::start();
        assert!(watch.deadline(0.0).is_over() && watch.deadline(-1.0).is_over());
        let late = watch.deadline(1e6);
        assert!(late.is_set() && !late.is_over());
        assert!(!late.earlier(Duration::from_secs(900_000)).is_over());
        assert!(late.earlier(Duration::from_secs(1_000_001)).is_over() && late.earlier(Duration::MAX).is_over());
        assert!(!Deadline::NEVER.earlier(Duration::MAX).is_over());
        let beyond_the_clock = watch.deadline(1e300);
        assert!(!beyond_the_clock.is_set() && !beyond_the_clock.is_over() && !Deadline::NEVER.is_over());
    }

    #[test]
    fn a_part_larger_than_the_whole_leaves_nothing() {
        let short = Times { wall: Duration::from_secs(1), cpu: Duration::from_secs(3) };
        let long = Times { wall: Duration::from_secs(2), cpu: Duration::from_secs(1) };
        let rest = short.without(long);
        assert_eq!((rest.wall, rest.cpu), (Duration::ZERO, Duration::from_secs(2)));
    }
}
