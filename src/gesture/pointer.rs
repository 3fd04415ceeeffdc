//! The mouse by a touch: it moves as the touch moves, and what is less than a pixel is kept for the next move.

use crate::profile::Pointer;
use crate::types::{Action, PointMm};

/// A touch that moves the mouse.
#[derive(Clone, Copy, Debug)]
pub(super) struct Following {
    at_mm: PointMm,
    /// Parts of a pixel, or of a notch.
    rest: PointMm,
}

impl Following {
    pub(super) fn new(at_mm: PointMm) -> Self {
        Self {
            at_mm,
            rest: [0.0; 2],
        }
    }

    /// What a move to a place does.
    pub(super) fn moved(&mut self, own: &Pointer, at_mm: PointMm) -> Option<Action> {
        let mut whole = [0; 2];
        for i in 0..2 {
            self.rest[i] += (at_mm[i] - self.at_mm[i]) * own.gain;
            let pixels = libm::trunc(self.rest[i]);
            self.rest[i] -= pixels;
            whole[i] = pixels as i32;
        }
        self.at_mm = at_mm;
        let [dx, dy] = whole;
        match (dx, dy) {
            (0, 0) => None,
            _ if own.wheel => Some(Action::Wheel { dx, dy }),
            // Screens count downwards.
            _ => Some(Action::Motion { dx, dy: -dy }),
        }
    }
}
