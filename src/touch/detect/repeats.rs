//! A board that hangs and sends its last frame again and again: what is down would stay down for ever.
//!
//! Readings of a real board are noisy, so that no two frames are equal. A board without noise, as in a simulation, repeats
//! frames at rest as well, and there nothing can be concluded from it.

use super::Detector;
use crate::types::{Frame, NANOS_PER_MS, Nanos, Touch};

/// Touches are lifted when the same frame has come for so long, ...
const HUNG_NS: Nanos = 250 * NANOS_PER_MS;
/// ... in this many times as many frames as the board ever repeated on an untouched pad.
const TIMES_AT_REST: u64 = 4;

/// How often the last frame has come, and how often one came at rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Repeats {
    volts: Vec<f32>,
    /// When the last frame came for the first time.
    since_ns: Nanos,
    /// How often it came again.
    repeats: u64,
    /// Most repetitions of a frame while nothing was down.
    most_at_rest: u64,
    /// How many times the board has hung.
    pub(super) hangs: u64,
    is_hung: bool,
}

impl Repeats {
    /// Takes the next frame; whether the board hangs.
    fn take(&mut self, frame: &Frame, is_touched: bool) -> bool {
        if self.volts != frame.volts {
            self.volts.clone_from(&frame.volts);
            self.since_ns = frame.t_ns;
            self.repeats = 0;
            self.is_hung = false;
            return false;
        }
        self.repeats += 1;
        if !is_touched && !self.is_hung {
            self.most_at_rest = self.most_at_rest.max(self.repeats);
        }
        let is_long = frame.t_ns.saturating_sub(self.since_ns) >= HUNG_NS;
        let is_unusual = self.repeats > TIMES_AT_REST * self.most_at_rest;
        if is_touched && is_long && is_unusual && !self.is_hung {
            self.is_hung = true;
            self.hangs += 1;
        }
        self.is_hung
    }
}

impl Detector {
    /// Whether the board hangs and its frame must be skipped: what was down is lifted.
    pub(super) fn is_hung(&mut self, frame: &Frame, changed: &mut Vec<Touch>) -> bool {
        let is_touched = !self.tracker.down().is_empty();
        if !self.repeats.take(frame, is_touched) {
            return false;
        }
        self.lift_all(changed);
        true
    }

    /// How many times the board has repeated a frame for so long that touches were lifted.
    #[must_use]
    pub fn hangs(&self) -> u64 {
        self.repeats.hangs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(index: u64, volt: f32) -> Frame {
        Frame {
            t_ns: index * 10 * NANOS_PER_MS,
            volts: vec![volt; 3],
        }
    }

    #[test]
    fn a_frame_that_comes_for_a_quarter_of_a_second_under_a_finger_is_a_hung_board() {
        let mut repeats = Repeats::default();
        for index in 0..50 {
            assert!(!repeats.take(&frame(index, index as f32), false));
        }
        let first_hung = (50..120).find(|index| repeats.take(&frame(*index, 7.5), true));
        assert_eq!(first_hung, Some(75));
        assert!(repeats.take(&frame(120, 7.5), false), "until another frame");
        assert!(!repeats.take(&frame(121, 8.5), false));
        assert_eq!(repeats.hangs, 1);
    }

    #[test]
    fn a_board_without_noise_is_not_hung() {
        let mut repeats = Repeats::default();
        for index in 0..30 {
            assert!(!repeats.take(&frame(index, 1.0), false));
        }
        for index in 30..130 {
            assert!(!repeats.take(&frame(index, 2.0), true));
        }
    }
}
