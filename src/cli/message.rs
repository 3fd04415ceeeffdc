//! Lines for the user on stderr.

use std::borrow::Cow;
use std::io::{self, IsTerminal as _, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::platform::terminal::can_write;
use crate::types::printable;

/// A terminal or pipe that takes nothing for this long is not read; the rest of what is written to it is dropped.
const PATIENCE: Duration = Duration::from_millis(500);
/// Bytes that fit where anything fits.
const PIECE_BYTES: usize = 256;
/// Whether stderr is not read. Global, as there is one stderr.
static IS_STALLED: AtomicBool = AtomicBool::new(false);

/// Prints a line on stderr; a closed stderr is ignored.
pub(super) fn say(text: &str) {
    let _ = writeln!(Stderr, "{}", printable(text));
}

/// A text for stdout: as it is in a file or a pipe, without control characters on a terminal.
pub(super) fn for_stdout(text: &str) -> Cow<'_, str> {
    match io::stdout().is_terminal() {
        true => printable(text),
        false => Cow::Borrowed(text),
    }
}

/// Standard error that does not wait for a reader that has stopped reading: that must not hold up the end of a game.
pub(super) struct Stderr;

impl Write for Stderr {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let patience = match IS_STALLED.load(Ordering::Relaxed) {
            true => Duration::ZERO,
            false => PATIENCE,
        };
        let can_write = can_write(&io::stderr(), patience);
        IS_STALLED.store(!can_write, Ordering::Relaxed);
        if !can_write {
            return Ok(bytes.len());
        }
        io::stderr().write(&bytes[..bytes.len().min(PIECE_BYTES)])
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
