//! Which touches count, and when: resting hands, SlowKeys, BounceKeys, dwelling, tremor, touch assistance.
//!
//! ```text
//! slow_keys     touch  __/~~~~~~~~\__        bounce_keys   touch  __/~~\_/~\____/~~\__
//!               passed ______/~~~~\__                      passed __/~~\________/~~\__
//!                        |slow|                                        |bounce|
//! activate up   touch  __/~~~~~~~\___        tremor        touch  __/~~\_/~~~\_____
//!               passed __________|___                      passed __/~~~~~~~~~~~~\_
//!                                                                             |tremor|
//! ```
//! A touch that never passes gives nothing. Each finger is judged for itself: none waits for another.

use super::layout::Layout;
use super::parts::Change;
use crate::profile::{Activate, Assist, Settings};
use crate::types::{NANOS_PER_MS, Nanos, Phase, PointMm, Touch, TouchId};

/// A place is rested on for this long after the contact there has gone: several frames of a slow board.
const RESTED_NS: Nanos = 150 * NANOS_PER_MS;
/// Touches that are watched at once; more give nothing.
const MOST_TOUCHES: usize = 32;

/// A finger that counts, at one moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passed {
    pub phase: Phase,
    pub id: TouchId,
    /// The one place that it is for, if it is no finger but a part of a gamepad.
    pub part: Option<usize>,
    /// Of a part: share of its way.
    pub at_mm: PointMm,
    /// 0 to 1 of this person's range.
    pub force: f64,
    /// Of a disc of the same area.
    pub radius_mm: f64,
}

#[derive(Clone, Debug)]
pub(super) struct Accept {
    settings: Settings,
    watched: Vec<Watched>,
    /// Last accepted release by region and part; the last entry is for fingers in no region.
    released: Vec<Option<Nanos>>,
    pub(super) passed: Vec<Passed>,
}

#[derive(Clone, Copy, Debug)]
struct Watched {
    /// The touch as the source names it now; a finger that came back has another one than it passed as.
    source: TouchId,
    finger: TouchId,
    /// A region, or a part.
    place: Option<usize>,
    is_part: bool,
    since_ns: Nanos,
    /// Where it went down.
    first_mm: PointMm,
    /// Where it is taken to be.
    at_mm: PointMm,
    force: f64,
    radius_mm: f64,
    /// When it came back the last time, and when it had lifted before.
    back: Option<(Nanos, Nanos)>,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Counts from then on, if it is still there.
    Waiting { due: Nanos },
    /// Lifted while it waited; goes on waiting if it comes back until then.
    Away { due: Nanos, until: Nanos },
    /// Counts when it lifts.
    UntilLift,
    /// Counts.
    Passed,
    /// Lifted; unless it comes back until then.
    Lifting { at: Nanos },
    /// Gives nothing until it lifts.
    Silent,
    /// A resting hand or arm (large), or what touches one.
    Resting { large: bool },
    /// Where one rested: an arm's image falls into pieces and joins again from frame to frame.
    Rested { until: Nanos },
}

impl Accept {
    pub(super) fn new(settings: &Settings, places: usize) -> Self {
        Self {
            settings: settings.clone(),
            watched: Vec::with_capacity(MOST_TOUCHES),
            released: vec![None; places + 1],
            passed: Vec::with_capacity(2 * MOST_TOUCHES),
        }
    }

    /// Forgets every touch: the source is gone.
    pub(super) fn clear(&mut self) {
        self.watched.clear();
        self.passed.clear();
    }

    pub(super) fn next_due(&self) -> Option<Nanos> {
        let due = |watched: &Watched| match watched.state {
            State::Waiting { due: at }
            | State::Away { until: at, .. }
            | State::Lifting { at }
            | State::Rested { until: at } => Some(at),
            State::UntilLift | State::Passed | State::Silent | State::Resting { .. } => None,
        };
        self.watched.iter().filter_map(due).min()
    }

    /// Passes what falls due.
    pub(super) fn tick(&mut self, t_ns: Nanos) {
        let Self {
            watched,
            released,
            passed,
            ..
        } = self;
        watched.retain_mut(|watched| match watched.state {
            State::Waiting { due } if due <= t_ns => {
                watched.state = State::Passed;
                passed.push(watched.passed(Phase::Down));
                true
            }
            State::Lifting { at } if at <= t_ns => {
                passed.push(watched.passed(Phase::Up));
                note_release(released, watched.place, at);
                false
            }
            State::Rested { until } | State::Away { until, .. } => until > t_ns,
            _ => true,
        });
    }

    /// Takes what became of a touch.
    pub(super) fn touch(&mut self, t_ns: Nanos, touch: &Touch, layout: &Layout) {
        let at_mm = layout.seen(touch.contact.centre_mm);
        match touch.phase {
            Phase::Down => self.down(t_ns, touch, at_mm, layout),
            Phase::Move => self.moved(t_ns, touch, at_mm),
            Phase::Up => self.up(t_ns, touch.id, Some(layout)),
        }
    }

    /// Takes what became of a part of a gamepad: what is about times holds for it as for a finger, what is about
    /// places does not.
    pub(super) fn part(&mut self, t_ns: Nanos, change: &Change) {
        match change.phase {
            Phase::Down => self.part_down(t_ns, change),
            Phase::Move => self.part_moved(change),
            Phase::Up => self.up(t_ns, change.id, None),
        }
    }

    fn part_down(&mut self, t_ns: Nanos, change: &Change) {
        let settings = &self.settings;
        let back = self.watched.iter_mut().find(|watched| {
            watched.is_part
                && watched.place == Some(change.place)
                && matches!(watched.state, State::Lifting { .. })
        });
        if let Some(watched) = back {
            watched.source = change.id;
            watched.state = State::Passed;
            return;
        }
        if self.watched.len() == MOST_TOUCHES {
            return;
        }
        let mut watched = Watched {
            source: change.id,
            finger: change.id,
            place: Some(change.place),
            is_part: true,
            since_ns: t_ns,
            first_mm: change.at,
            at_mm: change.at,
            force: change.force,
            radius_mm: 0.0,
            back: None,
            state: State::Passed,
        };
        if bounces(&self.released, settings, watched.place, t_ns) {
            watched.state = State::Silent;
        } else if settings.activate == Activate::Up {
            watched.state = State::UntilLift;
        } else if settings.slow_keys_ns > 0 {
            watched.state = State::Waiting {
                due: t_ns + settings.slow_keys_ns,
            };
        } else {
            self.passed.push(watched.passed(Phase::Down));
        }
        self.watched.push(watched);
    }

    fn part_moved(&mut self, change: &Change) {
        let moved = self
            .watched
            .iter_mut()
            .find(|watched| watched.source == change.id);
        if let Some(watched) = moved {
            watched.at_mm = change.at;
            watched.force = change.force;
            if watched.state == State::Passed {
                self.passed.push(watched.passed(Phase::Move));
            }
        }
    }

    fn down(&mut self, t_ns: Nanos, touch: &Touch, at_mm: PointMm, layout: &Layout) {
        let settings = &self.settings;
        let force = in_range(touch.contact.force, settings.force_range);
        let radius_mm = radius_mm(touch.contact.area_mm2);
        let back = self.watched.iter_mut().find(|watched| {
            !watched.is_part
                && matches!(watched.state, State::Lifting { .. } | State::Away { .. })
                && distance_mm(watched.at_mm, at_mm) < settings.tremor_mm
        });
        if let Some(watched) = back {
            watched.source = touch.id;
            match watched.state {
                State::Away { due, .. } if due > t_ns => watched.state = State::Waiting { due },
                State::Away { .. } => {
                    watched.state = State::Passed;
                    self.passed.push(watched.passed(Phase::Down));
                }
                State::Lifting { at } => {
                    watched.back = Some((t_ns, at - settings.tremor_ns));
                    watched.state = State::Passed;
                }
                _ => {}
            }
            return;
        }
        if self.watched.len() == MOST_TOUCHES {
            return;
        }
        let region = layout.topmost(at_mm);
        let bounces = bounces(&self.released, settings, region, t_ns);
        let large = self.is_large(touch.contact.area_mm2);
        let rests = large || self.touches_rest(at_mm, radius_mm);
        let delay_ns = settings.slow_keys_ns.max(settings.dwell_ns);
        let at_lift = settings.activate == Activate::Up || settings.assist == Assist::Last;
        let mut watched = Watched {
            source: touch.id,
            finger: touch.id,
            place: region,
            is_part: false,
            since_ns: t_ns,
            first_mm: at_mm,
            at_mm,
            force,
            radius_mm,
            back: None,
            state: State::Passed,
        };
        if rests {
            watched.state = State::Resting { large };
        } else if bounces || region.is_some_and(|region| layout.is_for_rest(region)) {
            watched.state = State::Silent;
        } else if at_lift && settings.dwell_ns == 0 {
            watched.state = State::UntilLift;
        } else if delay_ns > 0 {
            watched.state = State::Waiting {
                due: t_ns + delay_ns,
            };
        } else {
            self.passed.push(watched.passed(Phase::Down));
        }
        self.watched.push(watched);
    }

    fn moved(&mut self, t_ns: Nanos, touch: &Touch, at_mm: PointMm) {
        let settings = &self.settings;
        let Some(watched) = self
            .watched
            .iter_mut()
            .find(|watched| watched.source == touch.id)
        else {
            return;
        };
        watched.force = in_range(touch.contact.force, settings.force_range);
        watched.radius_mm = radius_mm(touch.contact.area_mm2);
        let rests = settings
            .rest_area_mm2
            .is_some_and(|most| touch.contact.area_mm2 > most);
        match &mut watched.state {
            State::Silent | State::Lifting { .. } | State::Away { .. } | State::Rested { .. } => {
                return;
            }
            State::Resting { large } => {
                *large |= rests;
                watched.at_mm = at_mm;
                return;
            }
            state @ (State::Waiting { .. } | State::UntilLift) if rests => {
                *state = State::Resting { large: true };
                return;
            }
            State::Passed if rests => {
                // A palm that comes down behind its fingertip.
                watched.state = State::Resting { large: true };
                self.passed.push(watched.passed(Phase::Up));
                return;
            }
            State::Waiting { due } => {
                if settings.dwell_ns > 0 && distance_mm(watched.at_mm, at_mm) >= settings.dwell_mm {
                    *due = (watched.since_ns + settings.slow_keys_ns).max(t_ns + settings.dwell_ns);
                    watched.at_mm = at_mm;
                } else if settings.dwell_ns == 0 && settings.assist == Assist::Off {
                    watched.at_mm = at_mm;
                }
                return;
            }
            State::UntilLift => {
                watched.at_mm = at_mm;
                return;
            }
            State::Passed => {}
        }
        if settings.assist == Assist::Off {
            watched.at_mm = drawn(watched.at_mm, at_mm, settings.tremor_mm);
        }
        self.passed.push(watched.passed(Phase::Move));
    }

    fn up(&mut self, t_ns: Nanos, id: TouchId, layout: Option<&Layout>) {
        let Some(index) = self.watched.iter().position(|watched| watched.source == id) else {
            return;
        };
        let watched = &mut self.watched[index];
        match watched.state {
            State::Passed if self.settings.tremor_ns > 0 => {
                // A re-touch that SlowKeys would not count makes the press no longer.
                let lifted_ns = match watched.back {
                    Some((since_ns, before_ns)) if t_ns - since_ns < self.settings.slow_keys_ns => {
                        before_ns
                    }
                    _ => t_ns,
                };
                watched.state = State::Lifting {
                    at: (lifted_ns + self.settings.tremor_ns).max(t_ns),
                };
                return;
            }
            State::Passed => {
                self.passed.push(watched.passed(Phase::Up));
                note_release(&mut self.released, watched.place, t_ns);
            }
            State::Waiting { due } if self.settings.tremor_ns > 0 => {
                watched.state = State::Away {
                    due,
                    until: t_ns + self.settings.tremor_ns,
                };
                return;
            }
            State::UntilLift => {
                let lasted = t_ns - watched.since_ns >= self.settings.slow_keys_ns;
                let stayed = match (self.settings.assist, layout) {
                    (Assist::Off, Some(layout)) => layout.topmost(watched.at_mm) == watched.place,
                    (Assist::First, Some(_)) => {
                        watched.at_mm = watched.first_mm;
                        true
                    }
                    (Assist::Last, _) | (_, None) => true,
                };
                if lasted && stayed {
                    self.passed.push(watched.passed(Phase::Down));
                    self.passed.push(watched.passed(Phase::Up));
                    note_release(&mut self.released, watched.place, t_ns);
                }
            }
            State::Resting { large: true } => {
                watched.state = State::Rested {
                    until: t_ns + RESTED_NS,
                };
                return;
            }
            State::Waiting { .. }
            | State::Silent
            | State::Resting { large: false }
            | State::Lifting { .. }
            | State::Away { .. }
            | State::Rested { .. } => {}
        }
        self.watched.remove(index);
    }

    /// Whether a contact of an area rests.
    pub(super) fn is_large(&self, area_mm2: f64) -> bool {
        let most = self.settings.rest_area_mm2;
        most.is_some_and(|most| area_mm2 > most)
    }

    /// Whether a footprint meets one that rests, or has just rested.
    fn touches_rest(&self, at_mm: PointMm, radius_mm: f64) -> bool {
        self.watched.iter().any(|watched| {
            matches!(watched.state, State::Resting { .. } | State::Rested { .. })
                && distance_mm(watched.at_mm, at_mm) < watched.radius_mm + radius_mm
        })
    }
}

impl Watched {
    fn passed(&self, phase: Phase) -> Passed {
        Passed {
            phase,
            id: self.finger,
            part: self.place.filter(|_| self.is_part),
            at_mm: self.at_mm,
            force: self.force,
            radius_mm: self.radius_mm,
        }
    }
}

/// Whether what goes down comes too soon after the last accepted release of its place.
fn bounces(
    released: &[Option<Nanos>],
    settings: &Settings,
    place: Option<usize>,
    t_ns: Nanos,
) -> bool {
    let since = released[place.unwrap_or(released.len() - 1)];
    since.is_some_and(|since| t_ns < since + settings.bounce_keys_ns)
}

fn note_release(released: &mut [Option<Nanos>], place: Option<usize>, t_ns: Nanos) {
    let slot = place.unwrap_or(released.len() - 1);
    released[slot] = Some(t_ns);
}

/// A place that follows another one as if drawn by a string of a length: what shakes less does not move it.
fn drawn(at_mm: PointMm, to_mm: PointMm, slack_mm: f64) -> PointMm {
    let distance = distance_mm(at_mm, to_mm);
    if slack_mm == 0.0 {
        return to_mm;
    }
    if distance < slack_mm {
        return at_mm;
    }
    let share = (distance - slack_mm) / distance;
    [0, 1].map(|i| at_mm[i] + share * (to_mm[i] - at_mm[i]))
}

/// A force in this person's range.
fn in_range(force: f64, [least, most]: [f64; 2]) -> f64 {
    ((force - least) / (most - least)).clamp(0.0, 1.0)
}

fn radius_mm(area_mm2: f64) -> f64 {
    libm::sqrt(area_mm2.max(0.0) / core::f64::consts::PI)
}

pub(super) fn distance_mm(a: PointMm, b: PointMm) -> f64 {
    let [dx, dy] = [a[0] - b[0], a[1] - b[1]];
    libm::sqrt(dx * dx + dy * dy)
}
