//! Counts the holders of each output, and enforces the shortest press and gap that a game can see and the longest press.
//!
//! ```text
//! wanted   __/~\____/~~~\_/~~~~~\__
//! output   __/~~~~\_/~~~\__/~~~~\__     min_hold stretches the first press,
//!            |hold|     |gap|           min_gap delays the third
//! ```
//! A press that is over before its delayed start still gets its minimum hold; further presses within the same delay are
//! merged with it. An axis sends a value only when it changes.

use crate::profile::Profile;
use crate::types::{Action, Axis, Event, Nanos, Output};

/// Steps of an axis between rest and its end: finer than games read.
const AXIS_STEPS: f32 = 1000.0;

/// The outputs of a profile and their state.
#[derive(Clone, Debug)]
pub(super) struct Outputs {
    min_hold_ns: Nanos,
    min_gap_ns: Nanos,
    max_hold_ns: Option<Nanos>,
    slots: Vec<OutputSlot>,
    /// Value of each axis, in the order of [`Axis::ALL`].
    axes: [f32; Axis::ALL.len()],
}

#[derive(Clone, Copy, Debug)]
struct OutputSlot {
    output: Output,
    /// Bindings that hold it down.
    holders: usize,
    state: OutputState,
}

/// What was sent to the device, and what will be sent when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OutputState {
    /// Never pressed, or long ago.
    Idle,
    /// Up since then.
    Up { since: Nanos },
    /// Up; goes down at this time.
    Rising { at: Nanos },
    /// Down since then.
    Down { since: Nanos },
    /// Down for its minimum hold; goes up at this time, and down again after a gap if it was pressed meanwhile.
    Falling { at: Nanos, again: bool },
    /// Released by force then: held too long, and still held.
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
                .map(|output| OutputSlot {
                    output: *output,
                    holders: 0,
                    state: OutputState::Idle,
                })
                .collect(),
        }
    }

    pub(super) fn held(&self) -> impl Iterator<Item = Output> + '_ {
        self.slots
            .iter()
            .filter(|slot| {
                matches!(
                    slot.state,
                    OutputState::Down { .. } | OutputState::Falling { .. }
                )
            })
            .map(|slot| slot.output)
    }

    /// Whether nothing is down, nothing is about to be, and every axis is at rest.
    pub(super) fn is_idle(&self) -> bool {
        let idle = |slot: &OutputSlot| {
            slot.holders == 0 && matches!(slot.state, OutputState::Idle | OutputState::Up { .. })
        };
        self.slots.iter().all(idle) && self.axes.iter().all(|value| *value == 0.0)
    }

    pub(super) fn next_due(&self) -> Option<Nanos> {
        self.slots
            .iter()
            .filter_map(|slot| match slot.state {
                OutputState::Rising { at } | OutputState::Falling { at, .. } => Some(at),
                OutputState::Down { since } => self
                    .max_hold_ns
                    .map(|most| since + most.max(self.min_hold_ns)),
                OutputState::Idle | OutputState::Up { .. } | OutputState::Spent { .. } => None,
            })
            .min()
    }

    /// Sets an axis, -1..1.
    pub(super) fn set_axis(
        &mut self,
        axis: Axis,
        value: f32,
        t_ns: Nanos,
        events: &mut Vec<Event>,
    ) {
        // Adding zero turns negative zero into zero.
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

    /// When a press that begins now goes out.
    pub(super) fn press_time(&self, index: usize, t_ns: Nanos) -> Nanos {
        let slot = &self.slots[index];
        match slot.state {
            OutputState::Idle | OutputState::Down { .. } => t_ns,
            OutputState::Up { since } | OutputState::Spent { since } => {
                t_ns.max(since + self.min_gap_ns)
            }
            OutputState::Rising { at } => at,
            OutputState::Falling { at, .. } => at + self.min_gap_ns,
        }
    }

    /// One more binding holds an output down.
    pub(super) fn hold(&mut self, index: usize, t_ns: Nanos, events: &mut Vec<Event>) {
        let press_ns = self.press_time(index, t_ns);
        let slot = &mut self.slots[index];
        slot.holders += 1;
        match slot.state {
            OutputState::Idle | OutputState::Up { .. } if press_ns <= t_ns => {
                slot.press(t_ns, events)
            }
            OutputState::Idle | OutputState::Up { .. } => {
                slot.state = OutputState::Rising { at: press_ns }
            }
            OutputState::Falling { at, .. } => {
                slot.state = OutputState::Falling { at, again: true }
            }
            // After a forced release only a new holder presses again.
            OutputState::Spent { .. } => {
                slot.state = OutputState::Rising {
                    at: press_ns.max(t_ns),
                };
            }
            OutputState::Rising { .. } | OutputState::Down { .. } => {}
        }
    }

    /// One binding less holds an output down.
    pub(super) fn let_go(&mut self, index: usize, t_ns: Nanos, events: &mut Vec<Event>) {
        let min_hold_ns = self.min_hold_ns;
        let slot = &mut self.slots[index];
        slot.holders = slot.holders.saturating_sub(1);
        if slot.holders > 0 {
            return;
        }
        if let OutputState::Spent { since } = slot.state {
            slot.state = OutputState::Up { since };
        }
        if let OutputState::Down { since } = slot.state {
            let at = since + min_hold_ns;
            if at <= t_ns {
                slot.release(t_ns, events);
            } else {
                slot.state = OutputState::Falling { at, again: false };
            }
        }
    }

    /// Sends what is due.
    pub(super) fn tick(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        for slot in &mut self.slots {
            match slot.state {
                OutputState::Rising { at } if at <= t_ns => {
                    slot.press(at, events);
                    if slot.holders == 0 {
                        slot.state = OutputState::Falling {
                            at: at + self.min_hold_ns,
                            again: false,
                        };
                    }
                }
                OutputState::Falling { at, again } if at <= t_ns => {
                    slot.release(at, events);
                    if again {
                        slot.state = OutputState::Rising {
                            at: at + self.min_gap_ns,
                        };
                    }
                }
                OutputState::Down { since } => {
                    let most = self
                        .max_hold_ns
                        .map(|most| since + most.max(self.min_hold_ns));
                    if let Some(at) = most.filter(|at| *at <= t_ns) {
                        slot.release(at, events);
                        slot.state = OutputState::Spent { since: at };
                    }
                }
                _ => {}
            }
        }
    }

    /// Releases everything that is down, without a minimum hold.
    pub(super) fn release_all(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        for slot in &mut self.slots {
            slot.holders = 0;
            match slot.state {
                OutputState::Down { .. } | OutputState::Falling { .. } => {
                    slot.release(t_ns, events)
                }
                OutputState::Rising { .. } => slot.state = OutputState::Idle,
                OutputState::Spent { since } => slot.state = OutputState::Up { since },
                OutputState::Idle | OutputState::Up { .. } => {}
            }
        }
        for axis in Axis::ALL {
            self.set_axis(*axis, 0.0, t_ns, events);
        }
    }
}

impl OutputSlot {
    fn press(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        self.state = OutputState::Down { since: t_ns };
        events.push(Event {
            t_ns,
            action: Action::Press(self.output),
        });
    }

    fn release(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        self.state = OutputState::Up { since: t_ns };
        events.push(Event {
            t_ns,
            action: Action::Release(self.output),
        });
    }
}
