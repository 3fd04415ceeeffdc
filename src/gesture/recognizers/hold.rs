//! A hold, or long press: still there after a time, moved less than the slop.
//!
//! ```text
//! touch    ____/~~~~~~~~~~~~~\____
//! output   ___________/~~~~~~\____
//!              | hold |
//! ```

use super::recognizer::{Playing, Recognizer};
use crate::gesture::driver::TargetSet;
use crate::gesture::fingers::TouchSample;
use crate::profile::Hold;
use crate::types::Nanos;

/// A touch that may become a hold.
#[derive(Clone, Copy, Debug)]
pub(in crate::gesture) enum HoldRecognizer {
    /// Becomes a hold at this time.
    Waiting { due_ns: Nanos },
    /// Is a hold, or moved too far.
    Decided,
}

impl Recognizer for HoldRecognizer {
    type Gesture = Hold;

    fn down(own: &Hold, _touch: &TouchSample, playing: &mut Playing<'_, '_>) -> Self {
        Self::Waiting {
            due_ns: playing.t_ns() + own.after_ns,
        }
    }

    fn moved(&mut self, own: &Hold, touch: &TouchSample, _playing: &mut Playing<'_, '_>) {
        if touch.moved_mm >= own.slop_mm {
            *self = Self::Decided;
        }
    }

    fn tick(&mut self, _own: &Hold, playing: &mut Playing<'_, '_>) {
        if self
            .next_due()
            .is_some_and(|due_ns| due_ns <= playing.t_ns())
        {
            *self = Self::Decided;
            playing.press(TargetSet::Main);
        }
    }

    fn next_due(&self) -> Option<Nanos> {
        match self {
            Self::Waiting { due_ns } => Some(*due_ns),
            Self::Decided => None,
        }
    }
}
