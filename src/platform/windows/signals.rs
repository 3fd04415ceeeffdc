//! What ends a game: Ctrl-C, Ctrl-Break, a closed console, the end of the session.
//!
//! Windows calls a handler in a thread of its own; the end of the session comes to a hidden window (`session_end.rs`). When the handler of a
//! closed console or of the end of a session returns, Windows ends the program, so that handler waits: the game releases its keys and ends the program meanwhile. As on other systems, a
//! program that does not react is ended, and a second event ends it immediately; the watchers then release the keys.
#![allow(
    unsafe_code,
    reason = "no safe interface handles events of the console"
)]

use std::io;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::time::Duration;

use windows_sys::Win32::System::Console::{
    CTRL_BREAK_EVENT, CTRL_C_EVENT, CTRL_CLOSE_EVENT, CTRL_LOGOFF_EVENT, SetConsoleCtrlHandler,
};
use windows_sys::Win32::System::Threading::{GetCurrentProcess, TerminateProcess};
use windows_sys::core::BOOL;

use super::session_end;

/// Number of Ctrl-C, as on other systems.
pub const INTERRUPT: i32 = 2;
/// Number of a closed console: that of a closed terminal.
pub const HANG_UP: i32 = 1;
/// Number of Ctrl-Break: that of Ctrl-\.
const QUIT: i32 = 3;
/// Number of the end of the session, or of Windows.
const TERMINATE: i32 = 15;

/// Longest time until the program reacts.
const REACTION: Duration = Duration::from_secs(3);

/// The first event; 0: none yet. Global, as the handler is.
static RECEIVED: AtomicI32 = AtomicI32::new(0);
/// Whether the program has reacted to it.
static IS_NOTICED: AtomicBool = AtomicBool::new(false);

/// Received events.
pub struct Signals(());

impl Signals {
    /// Catches the events from here on.
    ///
    /// # Errors
    /// The system refuses the handler.
    pub fn listen() -> io::Result<Self> {
        // SAFETY: the handler only uses atomics, threads and calls of the system.
        match unsafe { SetConsoleCtrlHandler(Some(handle), 1) } {
            0 => Err(io::Error::last_os_error()),
            _ => {
                session_end::listen(|| {
                    // SAFETY: it may be called from any thread.
                    unsafe { handle(CTRL_LOGOFF_EVENT) };
                });
                Ok(Self(()))
            }
        }
    }

    /// Number of a received event, if there is one. The caller reacts to it.
    #[must_use]
    pub fn received(&self) -> Option<i32> {
        let number = RECEIVED.load(Ordering::Relaxed);
        if number == 0 {
            return None;
        }
        IS_NOTICED.store(true, Ordering::Relaxed);
        Some(number)
    }
}

unsafe extern "system" fn handle(event: u32) -> BOOL {
    let number = match event {
        CTRL_C_EVENT => INTERRUPT,
        CTRL_BREAK_EVENT => QUIT,
        CTRL_CLOSE_EVENT => HANG_UP,
        _ => TERMINATE,
    };
    if RECEIVED.swap(number, Ordering::Relaxed) != 0 {
        end(number);
    }
    let limit = move || {
        std::thread::sleep(REACTION);
        if !IS_NOTICED.load(Ordering::Relaxed) {
            end(number);
        }
    };
    if matches!(event, CTRL_C_EVENT | CTRL_BREAK_EVENT) {
        let thread = std::thread::Builder::new().name("signals".to_owned());
        // Without the thread, a second event still ends the program.
        let _ = thread.spawn(limit);
        return 1;
    }
    limit();
    loop {
        std::thread::park();
    }
}

/// Ends this process.
fn end(number: i32) {
    let code = 128 + number.unsigned_abs();
    // SAFETY: the handle stands for this process.
    unsafe { TerminateProcess(GetCurrentProcess(), code) };
}
