//! Which outputs are down.

use crate::types::{Action, Output};

/// The outputs that are down, each once, in the order in which they were pressed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HeldOutputs(Vec<Output>);

impl HeldOutputs {
    /// Records a press or a release; other actions hold nothing down.
    pub fn record(&mut self, action: &Action) {
        match *action {
            Action::Press(output) => self.press(output),
            Action::Release(output) => self.release(output),
            Action::Axis(..) | Action::Motion { .. } | Action::Wheel { .. } => {}
        }
    }

    /// The output is down.
    pub fn press(&mut self, output: Output) {
        if !self.0.contains(&output) {
            self.0.push(output);
        }
    }

    /// The output is up.
    pub fn release(&mut self, output: Output) {
        self.0.retain(|held| *held != output);
    }

    /// Empties the record and returns what it held.
    pub fn take(&mut self) -> Vec<Output> {
        std::mem::take(&mut self.0)
    }

    /// What is down, the longest held first.
    pub fn iter(&self) -> impl Iterator<Item = Output> + '_ {
        self.0.iter().copied()
    }

    /// Whether everything is up.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}
