//! Two touches soon after each other.

use super::definition::{BindingReader, GestureDefinition, Warning};
use super::shared_keys::{SLOP_MM, TAPPING_TERM_MS};
use crate::profile::keys::{Key, NumberKey, define_keys, time_ms};
use crate::profile::settings::Settings;
use crate::types::{Nanos, ms_from_nanos};

define_keys! {
    DOUBLE_TAP_MS: NumberKey = time_ms("double_tap_ms", 300.0, "the second touch of a double tap comes sooner than this after the first lifts");
}

/// A tap, and a second touch soon after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleTap {
    /// From the lift of the first touch to the second touch, at most.
    pub gap_ns: Nanos,
    /// The tapping term of the first touch.
    pub within_ns: Nanos,
    /// The first touch moves less than this.
    pub slop_mm: f64,
}

impl GestureDefinition for DoubleTap {
    const KEYS: &'static [Key] = &[TAPPING_TERM_MS.key, DOUBLE_TAP_MS.key];

    fn read(binding: &mut BindingReader<'_>) -> Option<Self> {
        Some(Self {
            gap_ns: binding.time(&DOUBLE_TAP_MS),
            within_ns: binding.time(&TAPPING_TERM_MS),
            slop_mm: SLOP_MM.default,
        })
    }

    fn describe(&self) -> String {
        format!(
            "double tap within {} ms",
            ms_from_nanos(self.gap_ns).round()
        )
    }

    fn never_fires(&self, _settings: &Settings) -> Option<Warning> {
        (self.within_ns == 0).then_some(("its tapping term is 0", None))
    }
}
