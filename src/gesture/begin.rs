//! A touch begins to play: which bindings it concerns, and which gesture of each it may become.

use super::active::{Active, State};
use super::double_tap::DoubleTap;
use super::fingers::Finger;
use super::force;
use super::hold::Hold;
use super::play::{Players, begin_if};
use super::pointer::Following;
use super::step::Step;
use super::swipe::Stroke;
use super::tap::Tap;
use super::tap_hold::{Decision, Side, Undecided};
use crate::profile::{Gesture, Profile, Target};

/// Which bindings a touch may concern: found once, not at every step.
#[derive(Clone, Debug)]
pub(super) struct Index {
    /// By place; several touches' gestures are not among them.
    of_place: Vec<Vec<usize>>,
    of_pad: Vec<usize>,
    /// Chords, contacts, swipes of several touches.
    pub(super) of_several: Vec<usize>,
    /// The places of each binding: regions by their index, parts of gamepads counted on from these.
    pub(super) places: Vec<Vec<usize>>,
}

impl Index {
    pub(super) fn new(profile: &Profile) -> Self {
        let of_several = |index: &usize| match &profile.bindings[*index].gesture {
            Gesture::Chord { .. } | Gesture::Contacts { .. } => true,
            Gesture::Swipe(own) => own.fingers > 1,
            _ => false,
        };
        let (regions, parts) = (profile.regions.len(), profile.parts.len());
        let places: Vec<Vec<usize>> = profile
            .bindings
            .iter()
            .map(|binding| {
                let parts = binding.parts.iter().map(|part| regions + part);
                binding.regions.iter().copied().chain(parts).collect()
            })
            .collect();
        let all = 0..profile.bindings.len();
        let of_one = || all.clone().filter(|index| !of_several(index));
        Self {
            of_place: (0..regions + parts)
                .map(|place| {
                    of_one()
                        .filter(|index| places[*index].contains(&place))
                        .collect()
                })
                .collect(),
            of_pad: of_one().filter(|index| places[*index].is_empty()).collect(),
            of_several: all.clone().filter(of_several).collect(),
            places,
        }
    }
}

impl Players {
    /// A finger comes down on the pad: bindings without a region.
    pub(super) fn enter_pad(&mut self, step: &mut Step<'_>, finger: &Finger) {
        let profile = step.profile;
        for at in 0..self.index.of_pad.len() {
            let index = self.index.of_pad[at];
            if self.counts(profile, index, None) {
                self.start(step, index, None, finger);
            }
        }
    }

    /// A finger comes to count for a region, or a part of a gamepad for itself.
    pub(super) fn enter(&mut self, step: &mut Step<'_>, place: usize, finger: &Finger) {
        let profile = step.profile;
        for at in 0..self.index.of_place[place].len() {
            let index = self.index.of_place[place][at];
            if self.counts(profile, index, Some(place)) {
                self.start(step, index, Some(place), finger);
            }
        }
    }

    /// Whether a binding counts now: on the topmost layer that is on and binds the place, and not in a pause.
    pub(super) fn counts(&self, profile: &Profile, index: usize, place: Option<usize>) -> bool {
        let binding = &profile.bindings[index];
        if self.paused && !binding.targets.contains(&Target::Pause) {
            return false;
        }
        if profile.layers.is_empty() {
            return true;
        }
        let on = |layer: Option<usize>| layer.is_none_or(|layer| self.driver.is_on(layer));
        let Some(place) = place else {
            return on(binding.layer);
        };
        let all = profile.bindings.iter().zip(&self.index.places);
        let top = all
            .filter(|(_, places)| places.contains(&place))
            .map(|(other, _)| other.layer)
            .filter(|layer| on(*layer))
            .max();
        top == Some(binding.layer)
    }

    /// A touch begins to play a binding.
    fn start(&mut self, step: &mut Step<'_>, index: usize, region: Option<usize>, finger: &Finger) {
        let Step {
            profile,
            layout,
            t_ns,
            ..
        } = *step;
        let binding = &profile.bindings[index];
        let alone = !self.active.iter().any(|active| active.binding == index);
        let (state, decision) = match &binding.gesture {
            Gesture::Press => (State::Press, Decision::Begin(Side::First)),
            Gesture::Tap { within_ns, slop_mm } => (
                State::Tap(Tap::new(t_ns, *within_ns, *slop_mm)),
                Decision::None,
            ),
            Gesture::Hold { after_ns, slop_mm } => (
                State::Hold(Hold::new(t_ns, *after_ns, *slop_mm)),
                Decision::None,
            ),
            Gesture::DoubleTap { gap_ns, within_ns } => {
                let double = DoubleTap::new(t_ns, self.last_tap[index].take(), *gap_ns, *within_ns);
                let decision = match double {
                    DoubleTap::First(_) => Decision::None,
                    DoubleTap::Second => Decision::Begin(Side::First),
                };
                (State::DoubleTap(double), decision)
            }
            Gesture::Swipe(own) if own.fingers == 1 => {
                let open = Stroke::Open {
                    from_mm: finger.at_mm,
                    since_ns: t_ns,
                };
                (State::Swipe(open), Decision::None)
            }
            // Several touches make these: see `gather`.
            Gesture::Swipe(_) | Gesture::Chord { .. } | Gesture::Contacts { .. } => return,
            Gesture::Force { press, release } => {
                let down = force::is_down(false, finger.force, *press, *release);
                (State::Force { down }, begin_if(down))
            }
            // These have one master at a time.
            Gesture::Dpad(_) | Gesture::Stick(_) | Gesture::Trigger(_) | Gesture::Pointer(_)
                if !alone =>
            {
                return;
            }
            Gesture::Dpad(_) => {
                let (middle_mm, radius_mm) = layout.middle(region);
                let dpad = State::Dpad {
                    down: 0,
                    middle_mm,
                    radius_mm,
                };
                (dpad, Decision::None)
            }
            Gesture::Stick(own) => {
                let (middle_mm, radius_mm) = layout.middle(region);
                let middle_mm = if own.floating {
                    finger.at_mm
                } else {
                    middle_mm
                };
                let stick = State::Stick {
                    middle_mm,
                    radius_mm,
                };
                (stick, Decision::None)
            }
            Gesture::Trigger(_) => (State::Trigger, Decision::None),
            Gesture::Pointer(_) => (State::Pointer(Following::new(finger.at_mm)), Decision::None),
            Gesture::TapHold(own) => {
                let (undecided, decision) =
                    Undecided::new(t_ns, own, self.last_tap[index], self.last_press);
                (State::TapHold(undecided), decision)
            }
        };
        self.active.push(Active {
            touch: finger.id,
            binding: index,
            region,
            state,
        });
        let at = self.active.len() - 1;
        self.carry_out(step, at, decision);
        // What follows places and force begins where the touch is.
        if matches!(
            state,
            State::Dpad { .. } | State::Stick { .. } | State::Trigger
        ) {
            self.follow(step, at, finger);
        }
    }
}
