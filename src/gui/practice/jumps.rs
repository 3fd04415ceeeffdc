//! The last jumps: length of the press and height reached.

use std::collections::VecDeque;

use super::physics::STEPS_PER_S;
use crate::types::{Nanos, ms_from_nanos};

/// Jumps kept.
const MAX_JUMPS: usize = 40;
/// Length of a step, ms.
const STEP_MS: f64 = 1000.0 / STEPS_PER_S;

/// One jump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// Start of the press, source time.
    since_ns: Nanos,
    /// Length of the press so far; final once `released`.
    pub held_ms: f64,
    /// Whether the press is over.
    pub released: bool,
    /// Height so far, px; final once `peaked`.
    pub height_px: f64,
    /// Whether the highest point is reached.
    pub peaked: bool,
    /// Whether the jump began from a run.
    pub running: bool,
}

/// The last jumps, the newest at the back.
#[derive(Clone, Debug, Default)]
pub(super) struct JumpLog {
    jumps: VecDeque<Jump>,
}

impl JumpLog {
    pub(super) fn iter(&self) -> impl DoubleEndedIterator<Item = &Jump> + ExactSizeIterator {
        self.jumps.iter()
    }

    /// A press that began at `since_ns` jumps.
    pub(super) fn start(&mut self, since_ns: Nanos, released: bool, running: bool) {
        if self.jumps.len() == MAX_JUMPS {
            self.jumps.pop_front();
        }
        self.jumps.push_back(Jump {
            since_ns,
            held_ms: STEP_MS,
            released,
            height_px: 0.0,
            peaked: false,
            running,
        });
    }

    /// The press that began at `since_ns` is over.
    pub(super) fn release(&mut self, since_ns: Nanos, t_ns: Nanos) {
        let is_open = |jump: &&mut Jump| jump.since_ns == since_ns && !jump.released;
        if let Some(jump) = self.jumps.back_mut().filter(is_open) {
            jump.held_ms = ms_from_nanos(t_ns.saturating_sub(since_ns));
            jump.released = true;
        }
    }

    /// Extends the last jump by a step. `rise_px` is the height above its start, `started` whether it began in this step.
    pub(super) fn measure_step(&mut self, rise_px: f64, started: bool, peaked: bool) {
        let Some(jump) = self.jumps.back_mut() else {
            return;
        };
        if !jump.released && !started {
            jump.held_ms += STEP_MS;
        }
        if !jump.peaked {
            jump.height_px = jump.height_px.max(rise_px);
            jump.peaked = peaked;
        }
    }
}
