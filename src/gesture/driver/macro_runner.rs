//! A running macro: one step after the other, each at its own time.

use crate::profile::{MacroStep, Target};
use crate::types::Nanos;

/// The position in a macro.
#[derive(Clone, Copy, Debug)]
pub(super) struct MacroRunner {
    next: usize,
    at: Nanos,
}

/// What a macro does next.
#[derive(Clone, Copy, Debug)]
pub(super) enum MacroAction {
    Press(Target),
    Release(Target),
    /// Nothing until [`MacroRunner::next_due`].
    Wait,
    End,
}

impl MacroRunner {
    pub(super) fn new(t_ns: Nanos) -> Self {
        Self { next: 0, at: t_ns }
    }

    pub(super) fn next_due(&self) -> Nanos {
        self.at
    }

    /// The next action at a time.
    pub(super) fn next_action(&mut self, steps: &[MacroStep], t_ns: Nanos) -> MacroAction {
        loop {
            if self.at > t_ns {
                return MacroAction::Wait;
            }
            let Some(step) = steps.get(self.next) else {
                return MacroAction::End;
            };
            self.next += 1;
            match step {
                MacroStep::Press(target) => return MacroAction::Press(*target),
                MacroStep::Release(target) => return MacroAction::Release(*target),
                MacroStep::Wait(time) => self.at += time,
            }
        }
    }
}
