//! Log lines go to stderr, except while the live view is open.

use std::io::{IsTerminal as _, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use tracing_subscriber::EnvFilter;

use super::message::Stderr;

/// Whether log lines are dropped. Global, as there is one terminal.
static MUTED: AtomicBool = AtomicBool::new(false);

/// Drops log lines while `muted`: the live view shows lost frames itself.
pub(super) fn mute(muted: bool) {
    MUTED.store(muted, Ordering::Relaxed);
}

/// Starts logging: gelpad's warnings and findings by default, more with `-v` or `RUST_LOG`.
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
            if MUTED.load(Ordering::Relaxed) {
                Box::new(std::io::sink())
            } else {
                Box::new(Stderr)
            }
        })
        .with_ansi(std::io::stderr().is_terminal())
        .without_time()
        .with_target(false)
        .log_internal_errors(false)
        .init();
}
