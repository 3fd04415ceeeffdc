//! Tap or hold: one output when tapped, another when held.
//!
//! ```text
//! touch             __/~~~\______    __/~~~~~~~~~~\__
//! tap-preferred     ______/\tap__    _______/hold~\__     the term decides
//! speculative       __/tap\______    __/tap~\hold~\__     the tap is pressed at once, the hold replaces it
//!                     |term|           |term|
//! another touch             __/~~\__
//! hold-preferred    __/~~~~~hold~~~~\__                   it came: hold
//! balanced          __/~~~~~~~~~hold\__                   it came and went: hold
//! ```
//! The other touch is never delayed.

use super::recognizer::{Playing, Recognizer, TapMemory};
use crate::gesture::driver::TargetSet;
use crate::gesture::fingers::TouchSample;
use crate::profile::{Flavour, TapHold};
use crate::types::{Nanos, TouchId};

/// A touch that becomes a tap or a hold.
#[derive(Clone, Copy, Debug)]
pub(in crate::gesture) enum TapHoldRecognizer {
    /// Decided at this time at the latest; another touch may have come since.
    Open {
        due_ns: Nanos,
        other: Option<TouchId>,
    },
    Tap,
    Hold,
}

impl Recognizer for TapHoldRecognizer {
    type Gesture = TapHold;

    fn down(own: &TapHold, _touch: &TouchSample, playing: &mut Playing<'_, '_>) -> Self {
        let t_ns = playing.t_ns();
        let is_within = |since_ns: Option<Nanos>, time_ns: Nanos| {
            since_ns.is_some_and(|since_ns| t_ns < since_ns + time_ns)
        };
        let is_tap = is_within(playing.taps.last_ns, own.quick_tap_ns)
            || is_within(*playing.last_press_ns, own.prior_idle_ns);
        if is_tap || own.flavour == Flavour::Speculative {
            playing.press(TargetSet::Main);
        }
        if is_tap {
            return Self::Tap;
        }
        Self::Open {
            due_ns: t_ns + own.term_ns,
            other: None,
        }
    }

    fn up(&mut self, own: &TapHold, playing: &mut Playing<'_, '_>) {
        match self {
            Self::Hold => return,
            Self::Open { .. } if own.flavour != Flavour::Speculative => {
                playing.press(TargetSet::Main);
            }
            Self::Open { .. } | Self::Tap => {}
        }
        *playing.taps = TapMemory {
            count: 1,
            last_ns: Some(playing.t_ns()),
        };
    }

    fn tick(&mut self, own: &TapHold, playing: &mut Playing<'_, '_>) {
        if self
            .next_due()
            .is_some_and(|due_ns| due_ns <= playing.t_ns())
        {
            self.hold(own, playing);
        }
    }

    fn next_due(&self) -> Option<Nanos> {
        match self {
            Self::Open { due_ns, .. } => Some(*due_ns),
            Self::Tap | Self::Hold => None,
        }
    }

    fn other_down(&mut self, own: &TapHold, id: TouchId, playing: &mut Playing<'_, '_>) {
        match (&mut *self, own.flavour) {
            (Self::Open { .. }, Flavour::HoldPreferred) => self.hold(own, playing),
            (Self::Open { other, .. }, Flavour::Balanced) => {
                other.get_or_insert(id);
            }
            _ => {}
        }
    }

    fn other_up(&mut self, own: &TapHold, id: TouchId, playing: &mut Playing<'_, '_>) {
        if matches!(self, Self::Open { other: Some(other), .. } if *other == id) {
            self.hold(own, playing);
        }
    }
}

impl TapHoldRecognizer {
    fn hold(&mut self, own: &TapHold, playing: &mut Playing<'_, '_>) {
        *self = Self::Hold;
        if own.flavour == Flavour::Speculative {
            playing.release();
        }
        playing.press(TargetSet::Hold);
    }
}
