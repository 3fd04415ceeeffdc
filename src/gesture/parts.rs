//! Parts of a gamepad as places that are touched or not, so that all gestures and settings are theirs too.
//!
//! ```text
//! button   touched while it is down
//! trigger  touched while it is pulled; how far is the force
//! stick    touched while it is tilted; the place is where to: the middle (0, 0), its end 1 away
//! ```
//! What is held as a profile takes over, or when everything was released, is held for nothing until it is let go of.

use crate::profile::Profile;
use crate::types::{Control, Part, Phase, TouchId};

/// A trigger or stick counts as moved from this share of its way on, ...
const MOVED: f64 = 0.12;
/// ... and as at rest below this: worn sticks rest up to a tenth off their middle.
const AT_REST: f64 = 0.09;
/// Fingers on the pad count up from 0: these names are not theirs.
const FIRST_ID: u64 = 1 << 63;

/// What became of one part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change {
    pub phase: Phase,
    pub id: TouchId,
    /// The place that it is: those of regions come first.
    pub place: usize,
    /// Of a stick: share of its way to the right and up.
    pub at: [f64; 2],
    /// 0 to 1.
    pub force: f64,
}

/// The parts of a profile, and which of them are moved.
#[derive(Clone, Debug)]
pub(super) struct Parts {
    parts: Vec<Part>,
    regions: usize,
    held: Vec<Held>,
    next_id: u64,
    /// The last state: what another profile begins with.
    last: Control,
    pub(super) changes: Vec<Change>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Held {
    No,
    /// As a touch with a name, at a place.
    By(TouchId, [f64; 2]),
    /// For nothing.
    Idly,
}

impl Parts {
    pub(super) fn new(profile: &Profile) -> Self {
        Self {
            regions: profile.regions.len(),
            held: vec![Held::No; profile.parts.len()],
            changes: Vec::with_capacity(profile.parts.len()),
            parts: profile.parts.clone(),
            next_id: FIRST_ID,
            last: Control::default(),
        }
    }

    /// The same gamepad under another profile.
    pub(super) fn under(self, profile: &Profile) -> Self {
        let mut fresh = Self {
            next_id: self.next_id,
            last: self.last,
            ..Self::new(profile)
        };
        for (part, held) in fresh.parts.iter().zip(&mut fresh.held) {
            if strength(*part, fresh.last.moved(*part)) >= AT_REST {
                *held = Held::Idly;
            }
        }
        fresh
    }

    /// Whether a gamepad was there.
    pub(super) fn is_present(&self) -> bool {
        self.last.present
    }

    /// No part is held any more, nor is a gamepad there.
    pub(super) fn clear(&mut self) {
        self.held.fill(Held::No);
        self.last = Control::default();
    }

    /// Finds what a state changes: what is let go of first.
    pub(super) fn take(&mut self, control: &Control) {
        self.last = *control;
        self.changes.clear();
        for lifts in [true, false] {
            for index in 0..self.parts.len() {
                self.look(index, control, lifts);
            }
        }
    }

    fn look(&mut self, index: usize, control: &Control, lifts: bool) {
        let part = self.parts[index];
        let at = control.moved(part);
        let strength = strength(part, at);
        let held = self.held[index];
        let is_held = held != Held::No;
        let holds = strength >= if is_held { AT_REST } else { MOVED };
        if (is_held && !holds) != lifts {
            return;
        }
        let (phase, id) = match (held, holds) {
            (Held::No, true) => {
                self.next_id += 1;
                (Phase::Down, TouchId(self.next_id))
            }
            (Held::By(id, before), true) if before != at => (Phase::Move, id),
            (Held::By(id, _), false) => (Phase::Up, id),
            (Held::Idly, false) => {
                self.held[index] = Held::No;
                return;
            }
            _ => return,
        };
        self.held[index] = match phase {
            Phase::Up => Held::No,
            Phase::Down | Phase::Move => Held::By(id, at),
        };
        self.changes.push(Change {
            phase,
            id,
            place: self.regions + index,
            at,
            force: strength.min(1.0),
        });
    }
}

/// How far a part is moved, as a share of its way.
fn strength(part: Part, [x, y]: [f64; 2]) -> f64 {
    match part {
        Part::Button(_) | Part::Trigger(_) => x,
        Part::Stick(..) => libm::sqrt(x * x + y * y),
    }
}
