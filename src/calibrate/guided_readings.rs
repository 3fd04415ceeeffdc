//! What guided presses give: the presses, and what the pad reads between them.

use std::collections::VecDeque;

use super::presses::Press;

/// Frames of the untouched pad that are kept: a second of most boards.
const MOST_UNTOUCHED: usize = 100;

/// Presses at known places, and readings of the untouched pad.
#[derive(Clone, Debug, Default)]
pub struct GuidedReadings {
    /// The presses.
    pub presses: Vec<Press>,
    /// Readings of the untouched pad, frame by frame: the last ones, since something may have lain on the pad at first.
    pub untouched: VecDeque<Vec<f32>>,
}

impl GuidedReadings {
    /// Keeps the readings of a frame in which nothing touches the pad.
    pub fn take_untouched(&mut self, volts: &[f32]) {
        if self.untouched.len() == MOST_UNTOUCHED {
            self.untouched.pop_front();
        }
        self.untouched.push_back(volts.to_vec());
    }
}
