//! A macro that runs: one step after the other, each at its own time.

use crate::profile::{MacroStep, Target};
use crate::types::Nanos;

/// Where a macro is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Runner {
    next: usize,
    at: Nanos,
}

/// What to do next.
#[derive(Clone, Copy, Debug)]
pub(super) enum Due {
    Press(Target),
    Release(Target),
    /// Not before [`Runner::next_due`].
    Wait,
    End,
}

impl Runner {
    pub(super) fn new(t_ns: Nanos) -> Self {
        Self { next: 0, at: t_ns }
    }

    pub(super) fn next_due(&self) -> Nanos {
        self.at
    }

    /// The next thing to do at a time.
    pub(super) fn step(&mut self, steps: &[MacroStep], t_ns: Nanos) -> Due {
        loop {
            if self.at > t_ns {
                return Due::Wait;
            }
            let Some(step) = steps.get(self.next) else {
                return Due::End;
            };
            self.next += 1;
            match step {
                MacroStep::Press(target) => return Due::Press(*target),
                MacroStep::Release(target) => return Due::Release(*target),
                MacroStep::Wait(time) => self.at += time,
            }
        }
    }
}
