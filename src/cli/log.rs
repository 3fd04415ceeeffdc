//! Logs: to stderr, but not over the live view.

use std::io::{IsTerminal as _, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use tracing_subscriber::EnvFilter;

/// Whether a view has the terminal. One terminal, one flag.
static HELD_BACK: AtomicBool = AtomicBool::new(false);

/// Drops log lines from now on, or lets them through again: while a view is open, it shows what is lost itself.
pub(super) fn hold_back(held_back: bool) {
    HELD_BACK.store(held_back, Ordering::Relaxed);
}

/// Logs go to stderr: gelpad's own warnings and what it found out always, more with `-v` or `RUST_LOG`.
pub(super) fn start(verbose: u8) {
    let default = [
        "off,gelpad=warn,gelpad::told=info",
        "warn,gelpad=info",
        "debug",
    ][usize::from(verbose.min(2))];
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(default));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(|| -> Box<dyn Write> {
            if HELD_BACK.load(Ordering::Relaxed) {
                Box::new(std::io::sink())
            } else {
                Box::new(std::io::stderr())
            }
        })
        .with_ansi(std::io::stderr().is_terminal())
        .without_time()
        .with_target(false)
        .log_internal_errors(false)
        .init();
}
