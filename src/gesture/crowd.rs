//! What several fingers make together: chords, contacts, swipes of more than one finger.

use super::active::{Active, State};
use super::play::Players;
use super::step::Step;
use super::swipe::Stroke;
use super::tap_hold::{Decision, Side};
use crate::profile::Gesture;
use crate::types::TouchId;

impl Players {
    /// What several fingers make together begins or ends, now that one has come or gone.
    pub(super) fn gather(&mut self, step: &mut Step<'_>, id: TouchId) {
        let Step { profile, t_ns, .. } = *step;
        for listed in 0..self.index.of_several.len() {
            let index = self.index.of_several[listed];
            let binding = &profile.bindings[index];
            let (is_there, state) = match &binding.gesture {
                Gesture::Chord { window_ns } => {
                    let spread = self.fingers.chord(&self.index.places[index]);
                    let plays = self.active.iter().any(|active| active.binding == index);
                    // What has become a chord stays one while every region is touched.
                    (
                        spread.is_some_and(|spread| plays || spread < *window_ns),
                        State::Chord,
                    )
                }
                Gesture::Contacts { count } => (
                    self.fingers.count(&binding.regions) >= *count,
                    State::Contacts,
                ),
                Gesture::Swipe(own) if own.fingers > 1 => {
                    let open = Stroke::Open {
                        from_mm: self.fingers.middle(&binding.regions),
                        since_ns: t_ns,
                    };
                    (
                        self.fingers.count(&binding.regions) == own.fingers,
                        State::CrowdSwipe(open),
                    )
                }
                _ => continue,
            };
            let plays = self.active.iter().any(|active| active.binding == index);
            let place = self.index.places[index].first().copied();
            if is_there && !plays && self.counts(profile, index, place) {
                self.active.push(Active {
                    touch: id,
                    binding: index,
                    region: None,
                    state,
                });
                let at = self.active.len() - 1;
                if !matches!(state, State::CrowdSwipe(_)) {
                    self.carry_out(step, at, Decision::Begin(Side::First));
                }
            } else if !is_there && plays {
                self.end_all(step, |active| active.binding == index);
            }
        }
    }
}
