//! Signals that end a game: Ctrl-C, SIGTERM, SIGHUP, SIGQUIT. A second one of any kind ends the program immediately, in
//! case an output hangs.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};

const ENDING_SIGNALS: [i32; 4] = [SIGINT, SIGTERM, SIGHUP, SIGQUIT];

/// Received signals, as flags.
pub struct Signals {
    received: [Arc<AtomicBool>; ENDING_SIGNALS.len()],
}

impl Signals {
    /// Catches the signals from here on.
    ///
    /// # Errors
    /// A signal that cannot be caught.
    pub fn listen() -> std::io::Result<Self> {
        let any = Arc::new(AtomicBool::new(false));
        let received = ENDING_SIGNALS.map(|_| Arc::new(AtomicBool::new(false)));
        for (signal, flag) in ENDING_SIGNALS.into_iter().zip(&received) {
            signal_hook::flag::register_conditional_shutdown(
                signal,
                128 + signal,
                Arc::clone(&any),
            )?;
            signal_hook::flag::register(signal, Arc::clone(&any))?;
            signal_hook::flag::register(signal, Arc::clone(flag))?;
        }
        Ok(Self { received })
    }

    /// Number of a received signal, if there is one.
    #[must_use]
    pub fn received(&self) -> Option<i32> {
        let flags = self.received.iter();
        let index = flags
            .map(|flag| flag.load(Ordering::Relaxed))
            .position(|set| set)?;
        Some(ENDING_SIGNALS[index])
    }
}
