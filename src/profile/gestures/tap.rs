//! A touch that lifts soon and in place.

use super::definition::{BindingReader, GestureDefinition, Warning};
use super::shared_keys::{SLOP_MM, TAPPING_TERM_MS};
use crate::profile::keys::Key;
use crate::profile::settings::Settings;
use crate::types::{Nanos, ms_from_nanos};

/// A touch that lifts sooner than a time, having moved less than a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tap {
    /// The tapping term.
    pub within_ns: Nanos,
    /// The distance.
    pub slop_mm: f64,
}

impl GestureDefinition for Tap {
    const KEYS: &'static [Key] = &[TAPPING_TERM_MS.key, SLOP_MM.key];

    fn read(binding: &mut BindingReader<'_>) -> Option<Self> {
        Some(Self {
            within_ns: binding.time(&TAPPING_TERM_MS),
            slop_mm: binding.number(&SLOP_MM),
        })
    }

    fn describe(&self) -> String {
        format!("tap within {} ms", ms_from_nanos(self.within_ns).round())
    }

    fn never_fires(&self, _settings: &Settings) -> Option<Warning> {
        (self.within_ns == 0).then_some(("its tapping term is 0", None))
    }
}
