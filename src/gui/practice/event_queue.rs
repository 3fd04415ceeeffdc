//! Assigns events to steps of the level by the time of their source.

use std::collections::VecDeque;

use super::physics::STEPS_PER_S;
use crate::types::Event;

/// Length of a step, ns.
const STEP_NS: i64 = (1e9 / STEPS_PER_S) as i64;
/// Longest advance at once, s: a window that was hidden for longer does not catch up.
const MAX_ADVANCE_S: f64 = 0.25;
/// Waiting events; the oldest are dropped.
const MAX_EVENTS: usize = 256;
/// A late event raises the clock offset; it decays at this rate, ns per second.
const OFFSET_DECAY_NS_PER_S: f64 = 1e6;
/// A larger jump of the clock offset means that the source restarted, ns.
const RESTART_NS: i64 = 1_000_000_000;

/// Events that wait for their step, and the clock of the level.
#[derive(Clone, Debug, Default)]
pub(super) struct EventQueue {
    waiting: VecDeque<Event>,
    /// Level time of the last step, and of the last advance, ns.
    step_ns: i64,
    now_ns: i64,
    /// Source time minus level time, ns; unknown before the first event.
    offset_ns: Option<i64>,
}

impl EventQueue {
    pub(super) fn push(&mut self, event: Event) {
        if self.waiting.len() == MAX_EVENTS {
            self.waiting.pop_front();
        }
        self.waiting.push_back(event);
    }

    pub(super) fn clear(&mut self) {
        self.waiting.clear();
    }

    pub(super) fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// Advances the clock of the level; ignores times that are negative or not finite.
    pub(super) fn advance(&mut self, dt_s: f64) {
        let dt_s = if dt_s.is_finite() {
            dt_s.clamp(0.0, MAX_ADVANCE_S)
        } else {
            0.0
        };
        self.now_ns += (dt_s * 1e9) as i64;
        // The newest event has just arrived: the source's clock shows at least its time.
        if let Some(newest) = self.waiting.iter().map(|event| event.t_ns as i64).max() {
            let offset = newest - self.now_ns;
            let decay = (dt_s * OFFSET_DECAY_NS_PER_S) as i64;
            self.offset_ns = Some(match self.offset_ns.map(|old| old - decay) {
                Some(old) if (offset - old).abs() < RESTART_NS => old.max(offset),
                _ => offset,
            });
        }
    }

    /// Starts the next step if it is due.
    pub(super) fn start_step(&mut self) -> bool {
        let is_due = self.step_ns + STEP_NS <= self.now_ns;
        if is_due {
            self.step_ns += STEP_NS;
        }
        is_due
    }

    /// The next event of the current step.
    pub(super) fn pop_due(&mut self) -> Option<Event> {
        let until = self.step_ns + self.offset_ns.unwrap_or(0);
        let event = self.waiting.front()?;
        if event.t_ns as i64 <= until {
            self.waiting.pop_front()
        } else {
            None
        }
    }
}
