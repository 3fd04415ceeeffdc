//! Decides which touches count, and when: resting hands, slow keys, bounce keys, dwell, tremor, touch assistance.
//!
//! ```text
//! slow_keys     touch     __/~~~~~~~~\__        bounce_keys   touch     __/~~\_/~\____/~~\__
//!               accepted  ______/~~~~\__                      accepted  __/~~\________/~~\__
//!                           |slow|                                          |bounce|
//! activate up   touch     __/~~~~~~~\___        tremor        touch     __/~~\_/~~~\_____
//!               accepted  __________|___                      accepted  __/~~~~~~~~~~~~\_
//!                                                                                 |tremor|
//! ```
//! Each finger is judged separately: none waits for another.

mod watched;

pub(super) use watched::{AcceptedTouch, distance_mm};

use super::layout::Layout;
use super::parts::PartChange;
use crate::profile::{Activate, Assist, Settings};
use crate::types::{NANOS_PER_MS, Nanos, Phase, PointMm, Touch, TouchId};
use watched::{Watched, WatchedState, follow_with_slack, radius_mm};

/// Touches near the place of a palm are ignored for this long after it lifts: several frames of a slow board.
const AFTER_REST_NS: Nanos = 150 * NANOS_PER_MS;
/// Most touches that are watched at once; further ones are ignored.
const MAX_TOUCHES: usize = 32;

/// Watches all touches, and collects those that count.
#[derive(Clone, Debug)]
pub(super) struct Accept {
    settings: Settings,
    watched: Vec<Watched>,
    /// Last accepted release of each place; the last entry is for fingers outside all regions.
    released: Vec<Option<Nanos>>,
    /// What was accepted since the caller last took it.
    pub(super) accepted: Vec<AcceptedTouch>,
}

impl Accept {
    /// For a number of regions and parts of gamepads.
    pub(super) fn new(settings: &Settings, places: usize) -> Self {
        Self {
            settings: settings.clone(),
            watched: Vec::with_capacity(MAX_TOUCHES),
            released: vec![None; places + 1],
            accepted: Vec::with_capacity(2 * MAX_TOUCHES),
        }
    }

    /// Forgets every touch.
    pub(super) fn clear(&mut self) {
        self.watched.clear();
        self.accepted.clear();
    }

    pub(super) fn next_due(&self) -> Option<Nanos> {
        let watched = self.watched.iter();
        watched.filter_map(|one| one.state.next_due()).min()
    }

    /// Accepts what is due.
    pub(super) fn tick(&mut self, t_ns: Nanos) {
        let Self {
            watched,
            released,
            accepted,
            ..
        } = self;
        watched.retain_mut(|one| match one.state {
            WatchedState::Waiting { due_ns } if due_ns <= t_ns => {
                one.state = WatchedState::Accepted;
                accepted.push(one.accepted(Phase::Down));
                true
            }
            WatchedState::Lifting { due_ns } if due_ns <= t_ns => {
                accepted.push(one.accepted(Phase::Up));
                note_release(released, one.place, due_ns);
                false
            }
            WatchedState::JustRested { until_ns } | WatchedState::Away { until_ns, .. } => {
                until_ns > t_ns
            }
            _ => true,
        });
    }

    /// A touch went down, moved or lifted.
    pub(super) fn touch(&mut self, t_ns: Nanos, touch: &Touch, layout: &Layout) {
        let at_mm = layout.as_seen(touch.contact.centre_mm);
        match touch.phase {
            Phase::Down => self.down(t_ns, touch, at_mm, layout),
            Phase::Move => self.moved(t_ns, touch, at_mm),
            Phase::Up => self.up(t_ns, touch.id, Some(layout)),
        }
    }

    /// A part of a gamepad changed: the settings about times apply to it, those about places do not.
    pub(super) fn part(&mut self, t_ns: Nanos, change: &PartChange) {
        match change.phase {
            Phase::Down => self.part_down(t_ns, change),
            Phase::Move => self.part_moved(change),
            Phase::Up => self.up(t_ns, change.id, None),
        }
    }

    fn part_down(&mut self, t_ns: Nanos, change: &PartChange) {
        let returning = self.watched.iter_mut().find(|one| {
            one.is_part
                && one.place == Some(change.place)
                && matches!(one.state, WatchedState::Lifting { .. })
        });
        if let Some(watched) = returning {
            watched.source = change.id;
            watched.state = WatchedState::Accepted;
            return;
        }
        let settings = &self.settings;
        let state = if self.is_bounce(Some(change.place), t_ns) {
            WatchedState::Ignored
        } else if settings.activate == Activate::Up {
            WatchedState::UntilLift
        } else {
            waiting_or_accepted(t_ns, settings.slow_keys_ns)
        };
        self.watch(Watched {
            source: change.id,
            finger: change.id,
            place: Some(change.place),
            is_part: true,
            since_ns: t_ns,
            first_mm: change.at,
            at_mm: change.at,
            force: change.force,
            radius_mm: 0.0,
            returned: None,
            state,
        });
    }

    fn part_moved(&mut self, change: &PartChange) {
        let mut watched = self.watched.iter_mut();
        if let Some(watched) = watched.find(|one| one.source == change.id) {
            watched.at_mm = change.at;
            watched.force = change.force;
            if watched.state == WatchedState::Accepted {
                self.accepted.push(watched.accepted(Phase::Move));
            }
        }
    }

    /// Adds a touch, and accepts it if nothing delays it.
    fn watch(&mut self, watched: Watched) {
        if self.watched.len() == MAX_TOUCHES {
            return;
        }
        if watched.state == WatchedState::Accepted {
            self.accepted.push(watched.accepted(Phase::Down));
        }
        self.watched.push(watched);
    }

    /// A touch goes down: a finger that returns goes on, any other is watched in the state that size, place and settings give.
    fn down(&mut self, t_ns: Nanos, touch: &Touch, at_mm: PointMm, layout: &Layout) {
        if self.resume_lifted(t_ns, touch.id, at_mm) {
            return;
        }
        let place = layout.topmost(at_mm);
        let radius_mm = radius_mm(touch.contact.area_mm2);
        let settings = &self.settings;
        let is_large = self.is_large(touch.contact.area_mm2);
        let acts_at_lift = settings.activate == Activate::Up || settings.assist == Assist::Last;
        let state = if is_large || self.meets_resting(at_mm, radius_mm) {
            WatchedState::Resting { is_large }
        } else if self.is_bounce(place, t_ns)
            || place.is_some_and(|region| layout.ignores_touches(region))
        {
            WatchedState::Ignored
        } else if acts_at_lift && settings.dwell_ns == 0 {
            WatchedState::UntilLift
        } else {
            waiting_or_accepted(t_ns, settings.slow_keys_ns.max(settings.dwell_ns))
        };
        let watched = Watched {
            source: touch.id,
            finger: touch.id,
            place,
            is_part: false,
            since_ns: t_ns,
            first_mm: at_mm,
            at_mm,
            force: self.force_in_range(touch.contact.force),
            radius_mm,
            returned: None,
            state,
        };
        self.watch(watched);
    }

    /// If the touch is a finger that has just lifted nearby (a tremor, not a new touch), that finger goes on under its new id, and
    /// counts if its waiting time ended meanwhile. Returns whether it did.
    fn resume_lifted(&mut self, t_ns: Nanos, id: TouchId, at_mm: PointMm) -> bool {
        let settings = &self.settings;
        let returning = self.watched.iter_mut().find(|one| {
            let is_away = matches!(
                one.state,
                WatchedState::Lifting { .. } | WatchedState::Away { .. }
            );
            !one.is_part && is_away && distance_mm(one.at_mm, at_mm) < settings.tremor_mm
        });
        let Some(watched) = returning else {
            return false;
        };
        watched.source = id;
        match watched.state {
            WatchedState::Away { due_ns, .. } if due_ns > t_ns => {
                watched.state = WatchedState::Waiting { due_ns };
            }
            WatchedState::Away { .. } => {
                watched.state = WatchedState::Accepted;
                self.accepted.push(watched.accepted(Phase::Down));
            }
            WatchedState::Lifting { due_ns } => {
                watched.returned = Some((t_ns, due_ns - settings.tremor_ns));
                watched.state = WatchedState::Accepted;
            }
            _ => {}
        }
        true
    }

    fn moved(&mut self, t_ns: Nanos, touch: &Touch, at_mm: PointMm) {
        let force = self.force_in_range(touch.contact.force);
        let is_large = self.is_large(touch.contact.area_mm2);
        let settings = &self.settings;
        let mut watched = self.watched.iter_mut();
        let Some(watched) = watched.find(|one| one.source == touch.id) else {
            return;
        };
        watched.force = force;
        watched.radius_mm = radius_mm(touch.contact.area_mm2);
        match &mut watched.state {
            WatchedState::Resting { is_large: rests } => {
                *rests |= is_large;
                watched.at_mm = at_mm;
            }
            state @ (WatchedState::Waiting { .. } | WatchedState::UntilLift) if is_large => {
                *state = WatchedState::Resting { is_large };
            }
            WatchedState::Accepted if is_large => {
                // The palm comes down after its fingertip.
                watched.state = WatchedState::Resting { is_large };
                self.accepted.push(watched.accepted(Phase::Up));
            }
            WatchedState::Waiting { due_ns } => {
                if settings.dwell_ns == 0 {
                    if settings.assist == Assist::Off {
                        watched.at_mm = at_mm;
                    }
                } else if distance_mm(watched.at_mm, at_mm) >= settings.dwell_mm {
                    let slow_ns = watched.since_ns + settings.slow_keys_ns;
                    *due_ns = slow_ns.max(t_ns + settings.dwell_ns);
                    watched.at_mm = at_mm;
                }
            }
            WatchedState::UntilLift => watched.at_mm = at_mm,
            WatchedState::Accepted => {
                if settings.assist == Assist::Off {
                    watched.at_mm = follow_with_slack(watched.at_mm, at_mm, settings.tremor_mm);
                }
                self.accepted.push(watched.accepted(Phase::Move));
            }
            WatchedState::Ignored
            | WatchedState::Lifting { .. }
            | WatchedState::Away { .. }
            | WatchedState::JustRested { .. } => {}
        }
    }

    fn up(&mut self, t_ns: Nanos, id: TouchId, layout: Option<&Layout>) {
        let Some(index) = self.watched.iter().position(|one| one.source == id) else {
            return;
        };
        let tremor_ns = self.settings.tremor_ns;
        let next = match self.watched[index].state {
            WatchedState::Accepted if tremor_ns > 0 => Some(WatchedState::Lifting {
                due_ns: self.lift_due(index, t_ns),
            }),
            WatchedState::Waiting { due_ns } if tremor_ns > 0 => Some(WatchedState::Away {
                due_ns,
                until_ns: t_ns + tremor_ns,
            }),
            WatchedState::Resting { is_large: true } => Some(WatchedState::JustRested {
                until_ns: t_ns + AFTER_REST_NS,
            }),
            WatchedState::Accepted => {
                self.accept_up(index, t_ns);
                None
            }
            WatchedState::UntilLift => {
                if self.acts_at_lift(index, t_ns, layout) {
                    self.accepted
                        .push(self.watched[index].accepted(Phase::Down));
                    self.accept_up(index, t_ns);
                }
                None
            }
            _ => None,
        };
        match next {
            Some(state) => self.watched[index].state = state,
            None => {
                self.watched.remove(index);
            }
        }
    }

    fn accept_up(&mut self, index: usize, t_ns: Nanos) {
        let watched = &self.watched[index];
        self.accepted.push(watched.accepted(Phase::Up));
        note_release(&mut self.released, watched.place, t_ns);
    }

    /// When a finger that lifts now has lifted for good.
    fn lift_due(&self, index: usize, t_ns: Nanos) -> Nanos {
        // A return that slow keys would not count does not prolong the press.
        let lifted_ns = match self.watched[index].returned {
            Some((since_ns, before_ns)) if t_ns - since_ns < self.settings.slow_keys_ns => {
                before_ns
            }
            _ => t_ns,
        };
        (lifted_ns + self.settings.tremor_ns).max(t_ns)
    }

    /// Whether a touch that acts when it lifts lasted long enough and is still in its region.
    fn acts_at_lift(&mut self, index: usize, t_ns: Nanos, layout: Option<&Layout>) -> bool {
        let watched = &mut self.watched[index];
        let is_in_place = match (self.settings.assist, layout) {
            (Assist::Off, Some(layout)) => layout.topmost(watched.at_mm) == watched.place,
            (Assist::First, Some(_)) => {
                watched.at_mm = watched.first_mm;
                true
            }
            (Assist::Last, _) | (_, None) => true,
        };
        is_in_place && t_ns - watched.since_ns >= self.settings.slow_keys_ns
    }

    /// Whether a contact of an area rests.
    pub(super) fn is_large(&self, area_mm2: f64) -> bool {
        let limit = self.settings.rest_area_mm2;
        limit.is_some_and(|limit| area_mm2 > limit)
    }

    /// Whether a footprint meets one that rests, or has just rested.
    fn meets_resting(&self, at_mm: PointMm, radius_mm: f64) -> bool {
        self.watched.iter().any(|one| {
            matches!(
                one.state,
                WatchedState::Resting { .. } | WatchedState::JustRested { .. }
            ) && distance_mm(one.at_mm, at_mm) < one.radius_mm + radius_mm
        })
    }

    /// Whether a touch comes too soon after the last accepted release of its place.
    fn is_bounce(&self, place: Option<usize>, t_ns: Nanos) -> bool {
        let released = self.released[place.unwrap_or(self.released.len() - 1)];
        released.is_some_and(|since_ns| t_ns < since_ns + self.settings.bounce_keys_ns)
    }

    /// A force as a share of the person's range.
    fn force_in_range(&self, force: f64) -> f64 {
        let [least, most] = self.settings.force_range;
        ((force - least) / (most - least)).clamp(0.0, 1.0)
    }
}

fn waiting_or_accepted(t_ns: Nanos, delay_ns: Nanos) -> WatchedState {
    if delay_ns > 0 {
        WatchedState::Waiting {
            due_ns: t_ns + delay_ns,
        }
    } else {
        WatchedState::Accepted
    }
}

fn note_release(released: &mut [Option<Nanos>], place: Option<usize>, t_ns: Nanos) {
    let slot = place.unwrap_or(released.len() - 1);
    released[slot] = Some(t_ns);
}
