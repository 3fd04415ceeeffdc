//! Keys that several gestures take.

use super::definition::BindingReader;
use crate::profile::keys::{CountKey, MM, NumberKey, Table, count, define_keys, number, time_ms};

define_keys! {
    pub(super) TAPPING_TERM_MS: NumberKey = time_ms("tapping_term_ms", 200.0, "a touch that lifts sooner is a tap");
    pub(super) SLOP_MM: NumberKey = number("slop_mm", Table::Setting, MM, 8.0, "a touch that moves this far is neither a tap nor a hold");
    pub(super) WAYS: CountKey = count("ways", Table::Binding, (4, 8), 4, "number of directions: 4 or 8");
    pub(super) FINGERS: CountKey = count("fingers", Table::Binding, (1, 10), 1, "touches that move together or are down at once");
    pub(super) DEAD_ZONE: NumberKey = number("dead_zone", Table::Binding, (0.0, 0.95, "of the way"), 0.2, "nothing happens nearer to the centre, or below this force");
    pub(super) CURVE: NumberKey = number("curve", Table::Binding, (0.1, 10.0, ""), 1.0, "exponent of the response: 2 is finer near the centre");
    pub(super) GAIN: NumberKey = number("gain", Table::Binding, (0.0, 100.0, ""), 1.0, "factor; for a pointer, pixels or notches per millimetre");
}

/// The response of an axis, 0..1, to a share 0..1 of the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    /// The response is 0 below this share.
    pub dead_zone: f64,
    /// Exponent: 1 is linear, 2 finer near the centre.
    pub exponent: f64,
}

impl BindingReader<'_> {
    pub(super) fn curve(&mut self) -> Curve {
        Curve {
            dead_zone: self.number(&DEAD_ZONE),
            exponent: self.number(&CURVE),
        }
    }

    /// `ways`, or what holds without it.
    pub(super) fn ways_or(&mut self, default: u32) -> u8 {
        let ways = self.reader.count(self.entries, &WAYS.key);
        if ways.is_some_and(|ways| ways != 4 && ways != 8) {
            self.mistake("ways", "`ways` must be 4 or 8", "neither 4 nor 8");
        }
        ways.unwrap_or(default) as u8
    }
}
