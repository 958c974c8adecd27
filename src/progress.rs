//! A progress bar on a terminal.

use crate::render::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Shows finished tiles and the time left on standard error, if that is a terminal.
pub struct Bar(ProgressBar);

impl Bar {
    pub fn new(quiet: bool) -> Self {
        // The draw target finds out by itself whether it is a terminal.
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(None, target);
        // Parsing the template takes a part of the start-up time, so it is only done if the bar is shown.
        if !bar.is_hidden()
            && let Ok(style) = ProgressStyle::with_template("{bar:40} {percent}%  {elapsed} elapsed, {eta} left")
        {
            bar.set_style(style);
        }
        Self(bar)
    }
}

impl Progress for Bar {
    fn advance(&self, done: usize, total: usize) {
        if self.0.is_hidden() {
            return;
        }
        self.0.set_length(total as u64);
        self.0.set_position(done as u64);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
