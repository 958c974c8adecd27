//! A progress bar on a terminal.

use crate::render::Progress;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, stderr};

/// Shows finished tiles and the time left on standard error, if that is a terminal.
pub struct Bar(Option<ProgressBar>);

impl Bar {
    pub fn new(quiet: bool) -> Self {
        // Making a bar takes a part of the start-up time, so it is only made if it is shown.
        let is_shown = !quiet && stderr().is_terminal();
        Self(is_shown.then(|| {
            let bar = ProgressBar::no_length();
            match ProgressStyle::with_template("{bar:40} {percent}%  {elapsed} elapsed, {eta} left") {
                Ok(style) => bar.with_style(style),
                Err(_) => bar,
            }
        }))
    }
}

impl Progress for Bar {
    fn advance(&self, done: usize, total: usize) {
        if let Some(bar) = &self.0 {
            bar.set_length(total as u64);
            bar.set_position(done as u64);
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.iter().for_each(ProgressBar::finish_and_clear);
    }
}
