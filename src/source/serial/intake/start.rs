//! What arrives before the first whole frame since the port was opened: a few garbled frames were cut by the opening, many
//! mean that the board speaks otherwise, or at another baud rate.

use crate::source::SourceError;
use crate::types::{NANOS_PER_MS, Nanos};

/// Garbled frames are reported each time that this many more have come: a second of a usual board.
const GARBLED: u64 = 100;
/// A board that has sent something for this long, but no frame, ns, will not send one: all start commands have been tried
/// (`wire/auto.rs`).
const MOST_NS: Nanos = 15_000 * NANOS_PER_MS;

/// What has arrived before the first frame.
#[derive(Debug, Default)]
pub(super) struct Start {
    garbled: u64,
    /// The last garbled frame.
    last: String,
    bytes: u64,
    since_ns: Option<Nanos>,
}

impl Start {
    /// Counts a garbled frame, and reports every hundredth.
    pub(super) fn garbled(&mut self, reason: String) {
        self.garbled += 1;
        if self.garbled.is_multiple_of(GARBLED) {
            tracing::warn!(
                "no frame yet, but {} garbled ones; the last: {reason}",
                self.garbled
            );
        } else {
            tracing::debug!("before the first frame: {reason}");
        }
        self.last = reason;
    }

    /// Takes bytes without a frame.
    ///
    /// # Errors
    /// A frame is required, and far too long none has come.
    pub(super) fn take(
        &mut self,
        bytes: usize,
        now_ns: Nanos,
        requires_frames: bool,
    ) -> Result<(), SourceError> {
        if bytes == 0 {
            return Ok(());
        }
        self.bytes += bytes as u64;
        let waited_ns = now_ns.saturating_sub(*self.since_ns.get_or_insert(now_ns));
        if !requires_frames || waited_ns < MOST_NS {
            return Ok(());
        }
        Err(SourceError::NoFrame {
            bytes: self.bytes,
            seconds: waited_ns / (1000 * NANOS_PER_MS),
            last: match self.last.as_str() {
                "" => String::new(),
                last => format!(": {last}"),
            },
        })
    }
}
