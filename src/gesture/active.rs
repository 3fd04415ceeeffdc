//! A binding that a touch has begun to play: which gesture it may become, and how far it is.

use super::double_tap::DoubleTap;
use super::hold::Hold;
use super::pointer::Following;
use super::swipe::Stroke;
use super::tap::Tap;
use super::tap_hold::Undecided;
use crate::types::{Nanos, PointMm, TouchId};

/// A gesture in the making, or made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Active {
    pub touch: TouchId,
    pub binding: usize,
    /// None: the whole pad.
    pub region: Option<usize>,
    pub state: State,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum State {
    /// Down from its first moment.
    Press,
    Tap(Tap),
    Hold(Hold),
    DoubleTap(DoubleTap),
    /// Of one touch.
    Swipe(Stroke),
    /// Of several: their middle moves.
    CrowdSwipe(Stroke),
    Chord,
    Contacts,
    Force {
        down: bool,
    },
    /// Directions that are down, bits 0 to 3.
    Dpad {
        down: u8,
        middle_mm: PointMm,
        radius_mm: f64,
    },
    Stick {
        middle_mm: PointMm,
        radius_mm: f64,
    },
    Trigger,
    Pointer(Following),
    TapHold(Undecided),
}

impl Active {
    pub(super) fn next_due(&self) -> Option<Nanos> {
        match &self.state {
            State::Hold(hold) => hold.next_due(),
            State::TapHold(undecided) => undecided.next_due(),
            _ => None,
        }
    }
}
