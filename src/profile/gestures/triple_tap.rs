//! Three touches soon after each other.

use super::definition::{BindingReader, GestureDefinition, Warning};
use super::shared_keys::{SLOP_MM, TAPPING_TERM_MS};
use crate::profile::keys::{Key, NumberKey, time_ms};
use crate::profile::settings::Settings;
use crate::types::{Nanos, ms_from_nanos};

const TRIPLE_TAP_MS: NumberKey = time_ms(
    "triple_tap_ms",
    300.0,
    "each further touch of a triple tap comes sooner than this after the one before lifts",
);

/// Two taps, and a third touch, soon after each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TripleTap {
    /// From the lift of a touch to the next touch, at most.
    pub gap_ns: Nanos,
    /// The tapping term of the first two touches.
    pub within_ns: Nanos,
    /// The first two touches move less than this.
    pub slop_mm: f64,
}

impl GestureDefinition for TripleTap {
    const KEYS: &'static [Key] = &[TAPPING_TERM_MS.key, SLOP_MM.key, TRIPLE_TAP_MS.key];

    fn read(binding: &mut BindingReader<'_>) -> Option<Self> {
        Some(Self {
            gap_ns: binding.time(&TRIPLE_TAP_MS),
            within_ns: binding.time(&TAPPING_TERM_MS),
            slop_mm: binding.number(&SLOP_MM),
        })
    }

    fn describe(&self) -> String {
        let gap_ms = ms_from_nanos(self.gap_ns).round();
        format!("triple tap, each within {gap_ms} ms")
    }

    fn never_fires(&self, _settings: &Settings) -> Option<Warning> {
        if self.gap_ns == 0 {
            return Some(("`triple_tap_ms` is 0", None));
        }
        (self.within_ns == 0).then_some(("its tapping term is 0", None))
    }
}
