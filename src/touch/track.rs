//! Contacts followed through time: ids that are never reused, and down, move and up phases.
//!
//! A contact continues the nearest touch of the previous frame, nearest pairs first, if a hand can move that far between
//! two frames. There is no smoothing and no delay: a contact that continues no touch goes down in the same frame, and a
//! touch without contact goes up in it.

use crate::types::{Contact, Nanos, Phase, Touch, TouchId};

/// A touch moves at most this far between two frames, mm, ...
const REACH_MM: f64 = 12.0;
/// ... plus this much per millisecond between them: a fast swipe covers one metre per second.
const REACH_MM_PER_MS: f64 = 1.0;
/// Most milliseconds that count: with a slow board, a lift and a press elsewhere must not become one touch.
const LONGEST_MS: f64 = 10.0;

/// Follows contacts from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct Tracker {
    touches: Vec<Touch>,
    next_id: u64,
    last_ns: Nanos,
    pairs: Vec<(f64, usize, usize)>,
    taken: Vec<bool>,
}

impl Tracker {
    /// The touches that are down.
    #[must_use]
    pub fn down(&self) -> &[Touch] {
        &self.touches
    }

    /// Takes the contacts of a frame and appends every touch with its new phase: moves and ups of touches that were down, in
    /// the order in which they went down, then downs in the order of the contacts.
    pub fn follow(&mut self, t_ns: Nanos, contacts: &[Contact], changed: &mut Vec<Touch>) {
        let elapsed_ms = t_ns.saturating_sub(self.last_ns) as f64 * 1e-6;
        self.last_ns = t_ns;
        self.assign(
            contacts,
            REACH_MM + REACH_MM_PER_MS * elapsed_ms.min(LONGEST_MS),
        );
        let first_changed = changed.len();
        for touch in self.touches.drain(..) {
            changed.push(Touch {
                phase: Phase::Up,
                ..touch
            });
        }
        for (_, old, new) in &self.pairs {
            let touch = &mut changed[first_changed + old];
            touch.phase = Phase::Move;
            touch.contact = contacts[*new];
        }
        for (contact, taken) in contacts.iter().zip(&self.taken) {
            if !taken {
                changed.push(Touch {
                    id: TouchId(self.next_id),
                    phase: Phase::Down,
                    since_ns: t_ns,
                    contact: *contact,
                });
                self.next_id += 1;
            }
        }
        let still_down = changed[first_changed..]
            .iter()
            .filter(|touch| touch.phase != Phase::Up);
        self.touches.extend(still_down);
    }

    /// Lifts all touches.
    pub fn lift_all(&mut self, changed: &mut Vec<Touch>) {
        for touch in self.touches.drain(..) {
            changed.push(Touch {
                phase: Phase::Up,
                ..touch
            });
        }
    }

    /// Pairs touches with contacts within reach, nearest first, each in at most one pair.
    fn assign(&mut self, contacts: &[Contact], reach_mm: f64) {
        self.pairs.clear();
        for (old, touch) in self.touches.iter().enumerate() {
            for (new, contact) in contacts.iter().enumerate() {
                let [dx, dy] = [0, 1].map(|i| touch.contact.centre_mm[i] - contact.centre_mm[i]);
                let distance = libm::sqrt(dx * dx + dy * dy);
                if distance <= reach_mm {
                    self.pairs.push((distance, old, new));
                }
            }
        }
        self.pairs
            .sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        self.taken.clear();
        self.taken.resize(contacts.len(), false);
        let mut continued = vec![false; self.touches.len()];
        let taken = &mut self.taken;
        self.pairs.retain(|(_, old, new)| {
            let free = !continued[*old] && !taken[*new];
            if free {
                continued[*old] = true;
                taken[*new] = true;
            }
            free
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(x: f64, y: f64) -> Contact {
        Contact {
            centre_mm: [x, y],
            area_mm2: 100.0,
            force: 0.5,
            confidence: 1.0,
        }
    }

    fn step(tracker: &mut Tracker, t_ms: u64, contacts: &[Contact]) -> Vec<(u64, Phase)> {
        let mut changed = Vec::new();
        tracker.follow(t_ms * 1_000_000, contacts, &mut changed);
        changed
            .iter()
            .map(|touch| (touch.id.0, touch.phase))
            .collect()
    }

    #[test]
    fn a_touch_goes_down_moves_and_goes_up() {
        let mut tracker = Tracker::default();
        assert_eq!(step(&mut tracker, 0, &[at(10.0, 10.0)]), [(0, Phase::Down)]);
        assert_eq!(
            step(&mut tracker, 10, &[at(12.0, 10.0)]),
            [(0, Phase::Move)]
        );
        assert_eq!(step(&mut tracker, 20, &[]), [(0, Phase::Up)]);
        assert_eq!(
            step(&mut tracker, 30, &[at(12.0, 10.0)]),
            [(1, Phase::Down)]
        );
    }

    #[test]
    fn a_jump_across_the_pad_is_another_touch() {
        let mut tracker = Tracker::default();
        step(&mut tracker, 0, &[at(10.0, 10.0)]);
        assert_eq!(
            step(&mut tracker, 10, &[at(80.0, 10.0)]),
            [(0, Phase::Up), (1, Phase::Down)]
        );
    }

    #[test]
    fn the_nearest_pair_is_matched_first() {
        let mut tracker = Tracker::default();
        step(&mut tracker, 0, &[at(10.0, 10.0), at(20.0, 10.0)]);
        let changed = step(&mut tracker, 10, &[at(19.0, 10.0), at(60.0, 10.0)]);
        assert_eq!(
            changed,
            [(0, Phase::Up), (1, Phase::Move), (2, Phase::Down)]
        );
    }

    proptest! {
        #[test]
        fn ids_go_down_once_and_up_once(frames in proptest::collection::vec(
            proptest::collection::vec((0.0..100.0f64, 0.0..100.0f64), 0..5), 1..40)) {
            let mut tracker = Tracker::default();
            let mut changed = Vec::new();
            for (index, frame) in frames.iter().enumerate() {
                let contacts: Vec<Contact> = frame.iter().map(|(x, y)| at(*x, *y)).collect();
                tracker.follow(index as u64 * 10_000_000, &contacts, &mut changed);
                prop_assert_eq!(tracker.down().len(), contacts.len());
            }
            tracker.lift_all(&mut changed);
            for phase in [Phase::Down, Phase::Up] {
                let mut ids: Vec<u64> = changed.iter().filter(|t| t.phase == phase).map(|t| t.id.0).collect();
                let count = ids.len();
                ids.sort_unstable();
                ids.dedup();
                prop_assert_eq!(ids.len(), count, "{:?} twice", phase);
            }
        }
    }
}
