//! Treats parts of a gamepad as places that are touched or not, so that all gestures and settings apply to them.
//!
//! ```text
//! button   touched while it is down
//! trigger  touched while it is pulled; the travel is the force
//! stick    touched while it is tilted; the place is the tilt: the centre is (0, 0), the end is 1 away
//! ```
//! A part that is held when a profile takes over is ignored until it is let go of.

use crate::profile::Profile;
use crate::types::{Control, GamepadPart, Phase, TouchId};

/// A trigger or stick counts as moved from this share of its travel on, ...
const MOVED: f64 = 0.12;
/// ... and as at rest below this: worn sticks rest up to a tenth off their centre.
const AT_REST: f64 = 0.09;
/// The first touch id of parts; those of fingers on the pad count up from 0.
const FIRST_ID: u64 = 1 << 63;

/// A change of one part.
#[derive(Clone, Copy, Debug)]
pub(super) struct PartChange {
    pub phase: Phase,
    pub id: TouchId,
    /// Its place: after those of the regions.
    pub place: usize,
    /// Of a stick: share of its travel to the right and up.
    pub at: [f64; 2],
    /// 0..1.
    pub force: f64,
}

/// The parts of a profile, and which of them are held.
#[derive(Clone, Debug)]
pub(super) struct Parts {
    parts: Vec<GamepadPart>,
    regions: usize,
    held: Vec<HeldPart>,
    next_id: u64,
    /// The last state.
    last: Control,
    pub(super) changes: Vec<PartChange>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum HeldPart {
    No,
    /// As a touch, at a place.
    By(TouchId, [f64; 2]),
    /// Ignored until it is let go of.
    Ignored,
}

impl Parts {
    pub(super) fn new(profile: &Profile) -> Self {
        Self {
            regions: profile.regions.len(),
            held: vec![HeldPart::No; profile.parts.len()],
            changes: Vec::with_capacity(profile.parts.len()),
            parts: profile.parts.clone(),
            next_id: FIRST_ID,
            last: Control::default(),
        }
    }

    /// The same gamepad with another profile.
    pub(super) fn with_profile(self, profile: &Profile) -> Self {
        let mut fresh = Self {
            next_id: self.next_id,
            last: self.last,
            ..Self::new(profile)
        };
        for (part, held) in fresh.parts.iter().zip(&mut fresh.held) {
            if strength(*part, fresh.last.part_position(*part)) >= AT_REST {
                *held = HeldPart::Ignored;
            }
        }
        fresh
    }

    /// Whether a gamepad is plugged in.
    pub(super) fn is_present(&self) -> bool {
        self.last.present
    }

    /// The gamepad was unplugged: no part is held.
    pub(super) fn clear(&mut self) {
        self.held.fill(HeldPart::No);
        self.last = Control::default();
    }

    /// Lists the changes to a new state; parts that are let go of come first.
    pub(super) fn update(&mut self, control: &Control) {
        self.last = *control;
        self.changes.clear();
        for lifts in [true, false] {
            for index in 0..self.parts.len() {
                self.update_part(index, control, lifts);
            }
        }
    }

    fn update_part(&mut self, index: usize, control: &Control, lifts: bool) {
        let part = self.parts[index];
        let at = control.part_position(part);
        let strength = strength(part, at);
        let held = self.held[index];
        let is_held = held != HeldPart::No;
        let holds = strength >= if is_held { AT_REST } else { MOVED };
        if (is_held && !holds) != lifts {
            return;
        }
        let (phase, id) = match (held, holds) {
            (HeldPart::No, true) => {
                self.next_id += 1;
                (Phase::Down, TouchId(self.next_id))
            }
            (HeldPart::By(id, before), true) if before != at => (Phase::Move, id),
            (HeldPart::By(id, _), false) => (Phase::Up, id),
            (HeldPart::Ignored, false) => {
                self.held[index] = HeldPart::No;
                return;
            }
            _ => return,
        };
        self.held[index] = match phase {
            Phase::Up => HeldPart::No,
            Phase::Down | Phase::Move => HeldPart::By(id, at),
        };
        self.changes.push(PartChange {
            phase,
            id,
            place: self.regions + index,
            at,
            force: strength.min(1.0),
        });
    }
}

/// How far a part is moved, as a share of its travel.
fn strength(part: GamepadPart, [x, y]: [f64; 2]) -> f64 {
    match part {
        GamepadPart::Button(_) | GamepadPart::Trigger(_) => x,
        GamepadPart::Stick(..) => libm::sqrt(x * x + y * y),
    }
}
