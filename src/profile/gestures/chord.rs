//! Several places touched together.

use super::definition::{BindingReader, GestureDefinition, Warning};
use crate::profile::keys::{Key, NumberKey, define_keys, time_ms};
use crate::profile::settings::Settings;
use crate::types::{Nanos, ms_from_nanos};

define_keys! {
    CHORD_MS: NumberKey = time_ms("chord_ms", 60.0, "the touches of a chord begin sooner than this after each other");
}

/// Every region of the binding is touched, and the touches began soon after each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chord {
    /// From the first touch to the last, at most.
    pub window_ns: Nanos,
}

impl GestureDefinition for Chord {
    const KEYS: &'static [Key] = &[CHORD_MS.key];

    fn read(binding: &mut BindingReader<'_>) -> Option<Self> {
        if binding.places < 2 {
            binding.mistake_with_help(
                "region",
                "a chord needs at least two regions or buttons",
                "too few",
                "write `region = [\"a\", \"b\"]`",
            );
        }
        Some(Self {
            window_ns: binding.time(&CHORD_MS),
        })
    }

    fn describe(&self) -> String {
        format!("all within {} ms", ms_from_nanos(self.window_ns).round())
    }

    fn never_fires(&self, _settings: &Settings) -> Option<Warning> {
        (self.window_ns == 0).then_some(("`chord_ms` is 0", None))
    }
}
