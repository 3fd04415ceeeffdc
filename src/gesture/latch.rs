//! The paper's short and long press: the touch selects one of two lengths of a press.
//!
//! ```text
//! touch    ____/~~~~\___________   lifted before long_after: short
//! output   ____/~~~~~~~\________   up at the later of lift and short
//!
//! touch    ____/~~~~~~~~~~~\____   still down at long_after: long
//! output   ____/~~~~~~~~~~~~~~~~~\   up at long, whatever the lift
//!               |<-- long ------>|
//! ```
//! The press goes out at touch-down in either case: nothing waits for the decision.

use crate::profile::Latch;
use crate::types::Nanos;

/// One classified press.
#[derive(Clone, Copy, Debug)]
pub(super) struct Latched {
    lengths: Latch,
    /// When the output goes down; lengths count from here.
    pressed_ns: Nanos,
    state: State,
}

#[derive(Clone, Copy, Debug)]
enum State {
    /// Not yet long: decided at this time at the latest.
    Undecided { long_at: Nanos },
    /// Ends at this time.
    Ending { at: Nanos },
}

impl Latched {
    /// A touch that went down at a time and whose output goes down at `pressed_ns`.
    pub(super) fn new(lengths: Latch, down_ns: Nanos, pressed_ns: Nanos) -> Self {
        Self {
            lengths,
            pressed_ns,
            state: State::Undecided {
                long_at: down_ns + lengths.long_after_ns,
            },
        }
    }

    pub(super) fn next_due(&self) -> Option<Nanos> {
        match self.state {
            State::Undecided { long_at } => Some(long_at),
            State::Ending { at } => Some(at),
        }
    }

    /// The touch lifts; ticks up to this time have been given.
    pub(super) fn lift(&mut self, t_ns: Nanos) {
        if let State::Undecided { .. } = self.state {
            self.state = State::Ending {
                at: t_ns.max(self.pressed_ns + self.lengths.short_ns),
            };
        }
    }

    /// Decides what falls due; returns whether the press ends now.
    pub(super) fn tick(&mut self, t_ns: Nanos) -> bool {
        match self.state {
            State::Undecided { long_at } if t_ns >= long_at => {
                // A long_after beyond the long length ends the press as soon as it is known to be long.
                self.state = State::Ending {
                    at: t_ns.max(self.pressed_ns + self.lengths.long_ns),
                };
                false
            }
            State::Ending { at } => t_ns >= at,
            State::Undecided { .. } => false,
        }
    }
}
