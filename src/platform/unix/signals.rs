//! Signals that end a game: Ctrl-C, SIGTERM, SIGHUP, SIGQUIT, and SIGXCPU of a limit of processor time.
//!
//! The first one works in any case: if the program does not react to it in time, because it hangs in a terminal or a display
//! that stopped reading, it is ended from a thread of its own; the watcher and the kernel then release the keys. A second
//! signal ends the program immediately.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXCPU};

/// Number of Ctrl-C.
pub const INTERRUPT: i32 = SIGINT;
/// Number of a closed terminal.
pub const HANG_UP: i32 = SIGHUP;

const ENDING_SIGNALS: [i32; 5] = [SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGXCPU];

/// Whether the program has reacted to a signal. Global, as signals are: a window that does not open leaves its listener.
static IS_NOTICED: AtomicBool = AtomicBool::new(false);

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
        let signals = Self { received };
        crash::end_at_first()?;
        if let Err(error) = limit::start(&signals) {
            tracing::debug!("no limit for the reaction to a signal: {error}");
        }
        Ok(signals)
    }

    /// Number of a received signal, if there is one. The caller reacts to it.
    #[must_use]
    pub fn received(&self) -> Option<i32> {
        let signal = first(&self.received)?;
        IS_NOTICED.store(true, Ordering::Relaxed);
        Some(signal)
    }
}

fn first(received: &[Arc<AtomicBool>]) -> Option<i32> {
    let mut flags = received.iter();
    let index = flags.position(|flag| flag.load(Ordering::Relaxed))?;
    Some(ENDING_SIGNALS[index])
}

/// Faults of memory, sent by another program.
mod crash {
    use signal_hook::consts::{SIGBUS, SIGSEGV};
    use signal_hook::low_level::emulate_default_handler;

    /// Lets the first SIGSEGV or SIGBUS end the program with the right status. Rust's own handler, which is there for stack
    /// overflows, only removes itself and returns: a fault then happens again, but a signal of another program would be lost.
    #[allow(unsafe_code, reason = "no safe interface registers SIGSEGV")]
    pub(super) fn end_at_first() -> std::io::Result<()> {
        for signal in [SIGSEGV, SIGBUS] {
            let end = move || {
                // It does not return for these signals.
                let _ = emulate_default_handler(signal);
            };
            // SAFETY: a handler may only do what is async-signal-safe: `emulate_default_handler` is (it restores the
            // default and raises the signal again), and `end` does nothing else, allocates nothing and takes no lock.
            unsafe { signal_hook_registry::register_signal_unchecked(signal, end) }?;
        }
        Ok(())
    }
}

/// The thread that ends a program that does not react.
mod limit {
    use std::io::{self, Read as _};
    use std::os::unix::net::UnixStream;
    use std::sync::atomic::Ordering;
    use std::time::Duration;

    use super::{ENDING_SIGNALS, IS_NOTICED, Signals, first};

    /// Longest time until the program reacts.
    const REACTION: Duration = Duration::from_secs(3);

    pub(super) fn start(signals: &Signals) -> io::Result<()> {
        let (mut woken, wake) = UnixStream::pair()?;
        for signal in ENDING_SIGNALS {
            signal_hook::low_level::pipe::register(signal, wake.try_clone()?)?;
        }
        let received = signals.received.clone();
        let thread = std::thread::Builder::new().name("signals".to_owned());
        thread
            .spawn(move || {
                if woken.read_exact(&mut [0]).is_err() {
                    return;
                }
                std::thread::sleep(REACTION);
                if let Some(signal) = first(&received)
                    && !IS_NOTICED.load(Ordering::Relaxed)
                {
                    signal_hook::low_level::exit(128 + signal);
                }
            })
            .map(drop)
    }
}
