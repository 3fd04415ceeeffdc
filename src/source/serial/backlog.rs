//! What a board sent between the opening of the port and the first reading, while the pad was solved: a press of then would
//! come as a short one now.
//!
//! The system has kept these bytes and gives them immediately, so the first read that waits in vain shows that they are over. How
//! long other reads take shows nothing: a busy machine may delay each of them.

use std::collections::VecDeque;
use std::time::Duration;

use crate::source::SourceReading;
use crate::types::{NANOS_PER_MS, Nanos};

/// If the first reading comes this long after the port was opened, ns, what has arrived meanwhile is too old to play.
const STALE_NS: Nanos = 500 * NANOS_PER_MS;
/// How long a read waits for bytes: less than most boards pause between two frames.
pub(super) const WAIT: Duration = Duration::from_millis(3);
/// A board that never pauses ends it by both: time, ns, and reads. The system keeps less than this many reads return.
const MOST_DROPPING_NS: Nanos = 300 * NANOS_PER_MS;
const MOST_READS: u32 = 64;

/// Frames from before the first reading, while they arrive.
#[derive(Debug)]
pub(super) struct Backlog {
    until_ns: Nanos,
    reads: u32,
    dropped: usize,
}

impl Backlog {
    /// The backlog of a first reading at this time after the port was opened, if it is old.
    pub(super) fn at_first_reading(asked_ns: Nanos) -> Option<Self> {
        (asked_ns > STALE_NS).then_some(Self {
            until_ns: asked_ns + MOST_DROPPING_NS,
            reads: 0,
            dropped: 0,
        })
    }

    /// Takes the number of bytes of a read that waited for [`WAIT`]; returns whether the backlog is over.
    pub(super) fn ends_with(&mut self, received: usize, now_ns: Nanos) -> bool {
        self.reads += 1;
        received == 0 || (self.reads >= MOST_READS && now_ns >= self.until_ns)
    }

    /// Drops the frames among readings; `unsure` others were dropped already.
    pub(super) fn drop_frames(
        &mut self,
        readings: &mut VecDeque<SourceReading>,
        unsure: usize,
        channels: usize,
    ) {
        self.dropped += unsure;
        readings.retain(|reading| match reading {
            SourceReading::Frame(_) => {
                self.dropped += 1;
                false
            }
            SourceReading::Part(part) => {
                self.dropped += usize::from(part.first + part.volts.len() == channels);
                false
            }
            _ => true,
        });
    }

    /// Number of frames that were dropped.
    pub(super) fn dropped(&self) -> usize {
        self.dropped
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::{Frame, Part};

    #[test]
    fn a_slow_read_does_not_end_it_and_an_empty_one_does() {
        assert!(Backlog::at_first_reading(STALE_NS).is_none());
        let first_ns = 4 * STALE_NS;
        let mut backlog = Backlog::at_first_reading(first_ns).expect("old");
        for read in 1..MOST_READS {
            // Each was delayed by a busy machine.
            let now_ns = first_ns + Nanos::from(read) * MOST_DROPPING_NS;
            assert!(!backlog.ends_with(1000, now_ns), "read {read}");
        }
        assert!(backlog.ends_with(0, first_ns));
    }

    #[test]
    fn a_board_that_never_pauses_is_heard_after_a_while() {
        let first_ns = 4 * STALE_NS;
        let mut backlog = Backlog::at_first_reading(first_ns).expect("old");
        let at = |read: Nanos| first_ns + read * NANOS_PER_MS;
        let end = (1..1000).find(|read| backlog.ends_with(10, at(*read)));
        assert_eq!(end, Some(MOST_DROPPING_NS / NANOS_PER_MS));
    }

    #[test]
    fn dropped_frames_are_counted() {
        let mut backlog = Backlog::at_first_reading(2 * STALE_NS).expect("old");
        let frame = |t_ns| {
            SourceReading::Frame(Frame {
                t_ns,
                volts: vec![1.0; 4],
            })
        };
        let part = |first| {
            SourceReading::Part(Part {
                t_ns: 1,
                first,
                volts: vec![1.0; 2],
            })
        };
        let skipped = SourceReading::Skipped {
            reason: "cut".to_owned(),
            frames: 1,
        };
        let mut readings = VecDeque::from([
            frame(1),
            skipped.clone(),
            frame(2),
            part(0),
            part(2),
            part(0),
        ]);
        backlog.drop_frames(&mut readings, 2, 4);
        assert_eq!((backlog.dropped(), readings.len()), (5, 1));
        assert_eq!(readings[0], skipped);
    }
}
