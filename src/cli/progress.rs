//! Progress bars on stderr; nothing where stderr is not a terminal.

use std::io::IsTerminal as _;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::app::{AppError, pads};
use crate::pad::Pad;
use crate::touch::SensingBuilder;
use crate::types::Method;

/// A bar for the cases of a study.
pub(super) fn case_bar() -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(0);
    bar.set_style(style(
        "{bar:40} {pos} of {len} cases, {elapsed}, {eta} left",
    ));
    bar
}

/// A callback that sets a bar to the number of finished cases and of all.
pub(super) fn case_progress(bar: &ProgressBar) -> impl Fn(usize, usize) + Sync + '_ {
    move |done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    }
}

/// A bar for solving a pad; hidden until the first row is solved, as a cached pad takes no time.
pub(super) struct SolveBar(ProgressBar);

impl Default for SolveBar {
    fn default() -> Self {
        Self(ProgressBar::hidden())
    }
}

impl SolveBar {
    /// Shows the number of solved rows and of all rows.
    pub(super) fn update(&self, done: usize, rows: usize) {
        if self.0.is_hidden() {
            if !std::io::stderr().is_terminal() && done == 1 {
                tracing::warn!("solving the touches of this pad, once: takes seconds");
            }
            self.0.set_length(rows as u64);
            self.0.set_draw_target(ProgressDrawTarget::stderr());
            self.0.set_style(style(
                "solving the touches of this pad, once: {wide_bar} {percent} % {eta} left",
            ));
        }
        self.0.set_position(done as u64);
    }

    /// Removes the bar.
    pub(super) fn finish(&self) {
        self.0.finish_and_clear();
    }
}

/// Prepares a pad's sensing and shows the progress of the first time.
pub(super) fn solve_pad(pad: &Pad, method: Method) -> Result<SensingBuilder, AppError> {
    let bar = SolveBar::default();
    let builder = pads::sensing(pad, method, &|done, rows| bar.update(done, rows));
    bar.finish();
    builder
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// A line on the terminal with the current step; removed when dropped.
pub(super) struct Spinner(ProgressBar);

impl Spinner {
    pub(super) fn new() -> Self {
        Self(ProgressBar::new_spinner())
    }

    pub(super) fn show(&self, step: &str) {
        self.0.set_message(step.to_owned());
        self.0.tick();
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
