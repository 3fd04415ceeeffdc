//! A bar on stderr for what takes longer than a moment.

use std::io::IsTerminal as _;

use indicatif::{ProgressBar, ProgressStyle};

/// A bar, or nothing where stderr is no terminal.
pub(super) fn bar() -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(0);
    if let Ok(style) =
        ProgressStyle::with_template("{bar:40} {pos} of {len} cases, {elapsed}, {eta} left")
    {
        bar.set_style(style);
    }
    bar
}

/// What tells a bar how many are done, of how many.
pub(super) fn tell(bar: &ProgressBar) -> impl Fn(usize, usize) + Sync + '_ {
    move |done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    }
}
