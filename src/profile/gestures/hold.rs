//! A touch that stays in place for a time.

use super::definition::{BindingReader, GestureDefinition, Warning};
use super::shared_keys::SLOP_MM;
use crate::profile::keys::{Key, NumberKey, define_keys, time_ms};
use crate::profile::settings::{Activate, Settings};
use crate::types::{Nanos, ms_from_nanos};

define_keys! {
    HOLD_MS: NumberKey = time_ms("hold_ms", 400.0, "a touch that stays this long is a hold (long press)");
}

/// A touch that is still down after a time, having moved less than a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// The time.
    pub after_ns: Nanos,
    /// The distance.
    pub slop_mm: f64,
}

impl GestureDefinition for Hold {
    const KEYS: &'static [Key] = &[HOLD_MS.key, SLOP_MM.key];

    fn read(binding: &mut BindingReader<'_>) -> Option<Self> {
        Some(Self {
            after_ns: binding.time(&HOLD_MS),
            slop_mm: binding.number(&SLOP_MM),
        })
    }

    fn describe(&self) -> String {
        format!("hold for {} ms", ms_from_nanos(self.after_ns).round())
    }

    fn never_fires(&self, settings: &Settings) -> Option<Warning> {
        (settings.activate == Activate::Up).then_some((
            "with `activate = \"up\"` a touch acts only when it lifts, so nothing is held",
            None,
        ))
    }
}
