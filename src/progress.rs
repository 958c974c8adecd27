//! Progress: a bar on a terminal, elsewhere a line every ten seconds, so that the log of a long run says something.

use crate::options::Options;
use crate::output::say;
use crate::render::Progress;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Shows how much is rendered, on standard error.
pub enum Shown {
    Nothing,
    Bar(ProgressBar),
    Lines { since: Instant, lines: Mutex<Lines>, rays: AtomicU64 },
}

impl Shown {
    /// Begins to show progress, unless `-quiet` is given.
    pub fn new(options: &Options) -> Self {
        if options.quiet {
            return Self::Nothing;
        }
        if !stderr().is_terminal() {
            let lines = Mutex::new(Lines::new(options.measure.is_adaptive()));
            return Self::Lines { since: Instant::now(), lines, rays: AtomicU64::new(0) };
        }
        // Making a bar takes a part of the start-up time, so it is only made if it is shown.
        let bar = ProgressBar::no_length();
        Self::Bar(match ProgressStyle::with_template("{bar:40} {percent}%  {elapsed} elapsed, {eta} left") {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        })
    }
}

impl Progress for Shown {
    fn advance(&self, done: usize, total: usize) {
        match self {
            Self::Nothing => {}
            Self::Bar(bar) => {
                bar.set_length(total as u64);
                bar.set_position(done as u64);
            }
            Self::Lines { since, lines, rays } => {
                // Where another thread prints, this one has nothing to add.
                let line = lines
                    .try_lock()
                    .ok()
                    .and_then(|mut lines| lines.line(since.elapsed(), done, total, rays.load(Ordering::Relaxed)));
                line.iter().for_each(|line| say(line));
            }
        }
    }

    fn add_rays(&self, count: u64) {
        if let Self::Lines { rays, .. } = self {
            rays.fetch_add(count, Ordering::Relaxed);
        }
    }
}

impl Drop for Shown {
    fn drop(&mut self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

/// Makes a line about every ten seconds.
pub struct Lines {
    has_passes: bool,
    pass: usize,
    /// Tiles of this pass that were done the last time.
    done: usize,
    /// When the next line is due, since the start.
    due: Duration,
}

impl Lines {
    const EVERY: Duration = Duration::from_secs(10);

    fn new(has_passes: bool) -> Self {
        Self { has_passes, pass: 1, done: 0, due: Self::EVERY }
    }

    /// Returns the line that is due `now`, since the start. With passes it is unknown how many there will be.
    fn line(&mut self, now: Duration, done: usize, total: usize, rays: u64) -> Option<String> {
        // A thread may come a little late.
        if done + total / 2 < self.done {
            self.pass += 1;
            self.done = 0;
        }
        self.done = self.done.max(done);
        if now < self.due {
            return None;
        }
        self.due = now + Self::EVERY;
        let (share, seconds) = (done as f64 / total.max(1) as f64, now.as_secs_f64());
        let percent = 100.0 * share;
        let progress = match self.has_passes {
            true => format!("pass {}: {percent:.0}%, {seconds:.0} s", self.pass),
            false => format!("{percent:.0}%, {} left", shown(seconds * (1.0 - share) / share)),
        };
        Some(format!("{progress}, {:.2} million rays a second\n", rays as f64 / seconds / 1e6))
    }
}

/// Returns a time as in `90 s`, `75 min` or `30 h`.
fn shown(seconds: f64) -> String {
    match seconds {
        0.0..300.0 => format!("{seconds:.0} s"),
        300.0..18_000.0 => format!("{:.0} min", seconds / 60.0),
        _ => format!("{:.0} h", seconds / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The line at so many seconds, with a million rays each.
    fn at(lines: &mut Lines, seconds: u64, done: usize) -> Option<String> {
        lines.line(Duration::from_secs(seconds), done, 200, seconds * 1_000_000)
    }

    #[test]
    fn a_line_comes_every_ten_seconds() {
        let mut lines = Lines::new(false);
        assert_eq!(at(&mut lines, 9, 9), None);
        assert_eq!(at(&mut lines, 10, 10).as_deref(), Some("5%, 190 s left, 1.00 million rays a second\n"));
        assert_eq!(at(&mut lines, 19, 20), None);
        assert_eq!(at(&mut lines, 1000, 40).as_deref(), Some("20%, 67 min left, 1.00 million rays a second\n"));
        assert_eq!(at(&mut lines, 90_000, 100).as_deref(), Some("50%, 25 h left, 1.00 million rays a second\n"));
    }

    #[test]
    fn passes_are_counted() {
        let mut lines = Lines::new(true);
        for (seconds, done) in [(1, 150), (2, 149), (3, 200), (4, 2)] {
            assert_eq!(at(&mut lines, seconds, done), None);
        }
        assert_eq!(at(&mut lines, 12, 20).as_deref(), Some("pass 2: 10%, 12 s, 1.00 million rays a second\n"));
    }
}
