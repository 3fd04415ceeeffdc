//! Tap or hold: one thing when tapped, another when held.
//!
//! ```text
//! touch             __/~~~\______    __/~~~~~~~~~~\__
//! tap-preferred     ______/\tap__    _______/hold~\__     the term decides
//! speculative       __/tap\______    __/tap~\hold~\__     the tap is pressed at once and gives way
//!                     |term|           |term|
//! another touch             __/~~\__
//! hold-preferred    __/~~~~~hold~~~~\__                   it came: hold
//! balanced          __/~~~~~~~~~hold\__                   it came and went: hold
//! ```
//! The other touch is never held back, whatever this one turns out to be.

use crate::profile::{Flavour, TapHold};
use crate::types::{Nanos, TouchId};

/// Which of the two outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    /// The binding's own, and the tap's.
    First,
    /// The hold's.
    Second,
}

/// What follows for the outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Decision {
    /// Nothing yet.
    None,
    /// This one goes down and stays.
    Begin(Side),
    /// The first gives way to the second.
    Swap,
    /// The first goes down and up.
    Pulse,
}

/// A touch that is one or the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Undecided {
    flavour: Flavour,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Decided by time then; another touch may have come since.
    Open {
        at: Nanos,
        other: Option<TouchId>,
    },
    Tap,
    Hold,
}

impl Undecided {
    /// A touch that goes down after a tap of this binding, and any other press, at times.
    pub(super) fn new(
        t_ns: Nanos,
        own: &TapHold,
        last_tap_ns: Option<Nanos>,
        last_press_ns: Option<Nanos>,
    ) -> (Self, Decision) {
        let sooner =
            |since: Option<Nanos>, than: Nanos| since.is_some_and(|since| t_ns < since + than);
        let at_once =
            sooner(last_tap_ns, own.quick_tap_ns) || sooner(last_press_ns, own.prior_idle_ns);
        let open = State::Open {
            at: t_ns + own.term_ns,
            other: None,
        };
        let (state, decision) = match own.flavour {
            _ if at_once => (State::Tap, Decision::Begin(Side::First)),
            Flavour::Speculative => (open, Decision::Begin(Side::First)),
            _ => (open, Decision::None),
        };
        let undecided = Self {
            flavour: own.flavour,
            state,
        };
        (undecided, decision)
    }

    pub(super) fn next_due(&self) -> Option<Nanos> {
        match self.state {
            State::Open { at, .. } => Some(at),
            State::Tap | State::Hold => None,
        }
    }

    /// The tapping term may be over.
    pub(super) fn tick(&mut self, t_ns: Nanos) -> Decision {
        match self.state {
            State::Open { at, .. } if at <= t_ns => self.hold(),
            _ => Decision::None,
        }
    }

    /// Another touch went down.
    pub(super) fn other_down(&mut self, id: TouchId) -> Decision {
        match (&mut self.state, self.flavour) {
            (State::Open { .. }, Flavour::HoldPreferred) => self.hold(),
            (State::Open { other, .. }, Flavour::Balanced) => {
                other.get_or_insert(id);
                Decision::None
            }
            _ => Decision::None,
        }
    }

    /// Another touch lifted.
    pub(super) fn other_up(&mut self, id: TouchId) -> Decision {
        match self.state {
            State::Open {
                other: Some(other), ..
            } if other == id => self.hold(),
            _ => Decision::None,
        }
    }

    /// It lifts itself, within the term unless decided. Returns what follows, and whether it was a tap.
    pub(super) fn lift(&self) -> (Decision, bool) {
        match (self.state, self.flavour) {
            (State::Open { .. }, Flavour::Speculative) => (Decision::None, true),
            (State::Open { .. }, _) => (Decision::Pulse, true),
            (State::Tap, _) => (Decision::None, true),
            (State::Hold, _) => (Decision::None, false),
        }
    }

    fn hold(&mut self) -> Decision {
        self.state = State::Hold;
        match self.flavour {
            Flavour::Speculative => Decision::Swap,
            _ => Decision::Begin(Side::Second),
        }
    }
}
