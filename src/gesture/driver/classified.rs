//! The paper's short and long press: the length of the touch selects one of two lengths of the press.
//!
//! ```text
//! touch    ____/~~~~\___________   lifts before long_after: short
//! output   ____/~~~~~~~\________   up at the later of lift and short
//!
//! touch    ____/~~~~~~~~~~~\____   still down at long_after: long
//! output   ____/~~~~~~~~~~~~~~~~~\   up at long, whatever the lift
//!               |<-- long ------>|
//! ```
//! The press goes out at touch-down in both cases.

use crate::profile::Latch;
use crate::types::Nanos;

/// One classified press.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClassifiedPress {
    lengths: Latch,
    /// When the output goes down; lengths count from here.
    pressed_ns: Nanos,
    length: PressLength,
}

#[derive(Clone, Copy, Debug)]
enum PressLength {
    /// Long from this time on.
    Undecided { long_at: Nanos },
    /// Ends at this time.
    Ending { at: Nanos },
}

impl ClassifiedPress {
    /// A touch that went down at `down_ns` and whose output goes down at `pressed_ns`.
    pub(super) fn new(lengths: Latch, down_ns: Nanos, pressed_ns: Nanos) -> Self {
        Self {
            lengths,
            pressed_ns,
            length: PressLength::Undecided {
                long_at: down_ns + lengths.long_after_ns,
            },
        }
    }

    pub(super) fn next_due(&self) -> Option<Nanos> {
        match self.length {
            PressLength::Undecided { long_at: at } | PressLength::Ending { at } => Some(at),
        }
    }

    /// The touch lifts; all ticks up to this time were made.
    pub(super) fn lift(&mut self, t_ns: Nanos) {
        if let PressLength::Undecided { .. } = self.length {
            self.end_after(t_ns, self.lengths.short_ns);
        }
    }

    /// Decides what is due; returns whether the press ends.
    pub(super) fn tick(&mut self, t_ns: Nanos) -> bool {
        match self.length {
            PressLength::Undecided { long_at } => {
                if t_ns >= long_at {
                    self.end_after(t_ns, self.lengths.long_ns);
                }
                false
            }
            PressLength::Ending { at } => t_ns >= at,
        }
    }

    /// Ends after a length, but not before a time.
    fn end_after(&mut self, t_ns: Nanos, length_ns: Nanos) {
        let at = t_ns.max(self.pressed_ns + length_ns);
        self.length = PressLength::Ending { at };
    }
}
