//! What is held, by how many; the shortest press and gap that a game can see, the longest press that is allowed.
//!
//! ```text
//! wanted   __/~\____/~~~\_/~~~~~\__
//! output   __/~~~~\_/~~~\__/~~~~\__     min_hold stretches the first press,
//!            |hold|     |gap|           min_gap delays the third
//! ```
//! A press that is over before its delayed beginning still gets its minimum hold; further ones within the same delay
//! are one with it. An axis tells a value only when it changes.

use crate::profile::Profile;
use crate::types::{Action, Axis, Event, Nanos, Output};

/// Steps of an axis between rest and its end: finer than any game reads.
const AXIS_STEPS: f32 = 1000.0;

/// The outputs of a profile and their state.
#[derive(Clone, Debug)]
pub(super) struct Outputs {
    min_hold_ns: Nanos,
    min_gap_ns: Nanos,
    max_hold_ns: Option<Nanos>,
    slots: Vec<Slot>,
    /// Value of each axis, in the order of [`Axis::ALL`].
    axes: [f32; Axis::ALL.len()],
}

#[derive(Clone, Copy, Debug)]
struct Slot {
    output: Output,
    /// Bindings that want it down.
    holders: usize,
    state: State,
}

/// What the device has been told, and what it will be told when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Never pressed, or long ago.
    Idle,
    /// Up since then.
    Up { since: Nanos },
    /// Up; goes down then.
    Rising { at: Nanos },
    /// Down since then.
    Down { since: Nanos },
    /// Down for its minimum hold; goes up then, and down again after a gap if asked for.
    Falling { at: Nanos, again: bool },
    /// Up since then, by force: held too long, and not yet let go of.
    Spent { since: Nanos },
}

impl Outputs {
    pub(super) fn new(profile: &Profile) -> Self {
        Self {
            min_hold_ns: profile.settings.min_hold_ns,
            min_gap_ns: profile.settings.min_gap_ns,
            max_hold_ns: profile.settings.max_hold_ns,
            axes: [0.0; Axis::ALL.len()],
            slots: profile
                .outputs
                .iter()
                .map(|output| Slot {
                    output: *output,
                    holders: 0,
                    state: State::Idle,
                })
                .collect(),
        }
    }

    pub(super) fn held(&self) -> impl Iterator<Item = Output> + '_ {
        self.slots
            .iter()
            .filter(|slot| matches!(slot.state, State::Down { .. } | State::Falling { .. }))
            .map(|slot| slot.output)
    }

    /// Whether nothing is down, nothing is about to be, and every axis is at rest.
    pub(super) fn is_idle(&self) -> bool {
        let idle =
            |slot: &Slot| slot.holders == 0 && matches!(slot.state, State::Idle | State::Up { .. });
        self.slots.iter().all(idle) && self.axes.iter().all(|value| *value == 0.0)
    }

    pub(super) fn next_due(&self) -> Option<Nanos> {
        self.slots
            .iter()
            .filter_map(|slot| match slot.state {
                State::Rising { at } | State::Falling { at, .. } => Some(at),
                State::Down { since } => self
                    .max_hold_ns
                    .map(|most| since + most.max(self.min_hold_ns)),
                State::Idle | State::Up { .. } | State::Spent { .. } => None,
            })
            .min()
    }

    /// An axis takes a value.
    pub(super) fn axis(&mut self, axis: Axis, value: f32, t_ns: Nanos, events: &mut Vec<Event>) {
        // Adding zero turns a negative one into the other.
        let value = libm::roundf(value * AXIS_STEPS) / AXIS_STEPS + 0.0;
        let Some(index) = Axis::ALL.iter().position(|one| *one == axis) else {
            return;
        };
        if self.axes[index] != value {
            self.axes[index] = value;
            events.push(Event {
                t_ns,
                action: Action::Axis(axis, value),
            });
        }
    }

    /// When a press that is wanted now would go out.
    pub(super) fn press_time(&self, index: usize, t_ns: Nanos) -> Nanos {
        let slot = &self.slots[index];
        match slot.state {
            State::Idle | State::Down { .. } => t_ns,
            State::Up { since } | State::Spent { since } => t_ns.max(since + self.min_gap_ns),
            State::Rising { at } => at,
            State::Falling { at, .. } => at + self.min_gap_ns,
        }
    }

    /// One more binding wants an output down.
    pub(super) fn hold(&mut self, index: usize, t_ns: Nanos, events: &mut Vec<Event>) {
        let press_ns = self.press_time(index, t_ns);
        let slot = &mut self.slots[index];
        slot.holders += 1;
        match slot.state {
            State::Idle | State::Up { .. } if press_ns <= t_ns => slot.press(t_ns, events),
            State::Idle | State::Up { .. } => slot.state = State::Rising { at: press_ns },
            State::Falling { at, .. } => slot.state = State::Falling { at, again: true },
            // What was spent is pressed again by a fresh wish only.
            State::Spent { .. } => {
                slot.state = State::Rising {
                    at: press_ns.max(t_ns),
                };
            }
            State::Rising { .. } | State::Down { .. } => {}
        }
    }

    /// One binding less wants an output down.
    pub(super) fn let_go(&mut self, index: usize, t_ns: Nanos, events: &mut Vec<Event>) {
        let min_hold_ns = self.min_hold_ns;
        let slot = &mut self.slots[index];
        slot.holders = slot.holders.saturating_sub(1);
        if slot.holders > 0 {
            return;
        }
        if let State::Spent { since } = slot.state {
            slot.state = State::Up { since };
        }
        if let State::Down { since } = slot.state {
            let at = since + min_hold_ns;
            if at <= t_ns {
                slot.release(t_ns, events);
            } else {
                slot.state = State::Falling { at, again: false };
            }
        }
    }

    /// Tells the device what falls due at a time.
    pub(super) fn tick(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        for slot in &mut self.slots {
            match slot.state {
                State::Rising { at } if at <= t_ns => {
                    slot.press(at, events);
                    if slot.holders == 0 {
                        slot.state = State::Falling {
                            at: at + self.min_hold_ns,
                            again: false,
                        };
                    }
                }
                State::Falling { at, again } if at <= t_ns => {
                    slot.release(at, events);
                    if again {
                        slot.state = State::Rising {
                            at: at + self.min_gap_ns,
                        };
                    }
                }
                State::Down { since } => {
                    let most = self
                        .max_hold_ns
                        .map(|most| since + most.max(self.min_hold_ns));
                    if let Some(at) = most.filter(|at| *at <= t_ns) {
                        slot.release(at, events);
                        slot.state = State::Spent { since: at };
                    }
                }
                _ => {}
            }
        }
    }

    /// Releases whatever is down, at once.
    pub(super) fn release_all(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        for slot in &mut self.slots {
            slot.holders = 0;
            match slot.state {
                State::Down { .. } | State::Falling { .. } => slot.release(t_ns, events),
                State::Rising { .. } => slot.state = State::Idle,
                State::Spent { since } => slot.state = State::Up { since },
                State::Idle | State::Up { .. } => {}
            }
        }
        for axis in Axis::ALL {
            self.axis(*axis, 0.0, t_ns, events);
        }
    }
}

impl Slot {
    fn press(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        self.state = State::Down { since: t_ns };
        events.push(Event {
            t_ns,
            action: Action::Press(self.output),
        });
    }

    fn release(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        self.state = State::Up { since: t_ns };
        events.push(Event {
            t_ns,
            action: Action::Release(self.output),
        });
    }
}
