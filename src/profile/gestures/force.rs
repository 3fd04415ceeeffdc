//! A touch that presses hard.

use super::definition::{BindingReader, GestureDefinition, PlayedFrom};
use crate::profile::keys::{FORCE, Key, KeyKind, NumberKey, Table, define_keys, number};

define_keys! {
    PRESS: NumberKey = number("force", Table::Binding, FORCE, 0.5, "pressed from this force on");
}
/// The hysteresis between press and release, as a share of the force of a press.
const RELEASE_SHARE: f64 = 0.8;
define_keys! {
    RELEASE: Key = Key::new("force_release", Table::Binding, KeyKind::Number(FORCE.0, FORCE.1, FORCE.2), "released below this force").or("0.8 of force");
}

/// Pressed harder than a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Force {
    /// Pressed from this force on, 0..1.
    pub press: f64,
    /// Released below this force.
    pub release: f64,
}

impl GestureDefinition for Force {
    const KEYS: &'static [Key] = &[PRESS.key, RELEASE];
    const PLAYED_FROM: PlayedFrom = PlayedFrom::Pressed;

    fn read(binding: &mut BindingReader<'_>) -> Option<Self> {
        let press = binding.number(&PRESS);
        let release = binding.own_number(&RELEASE);
        let release = release.unwrap_or(RELEASE_SHARE * press);
        if release > press && binding.has("force_release") {
            binding.mistake(
                "force_release",
                "`force_release` must not be above `force`: a press would end at once",
                "too high",
            );
        }
        Some(Self { press, release })
    }

    fn describe(&self) -> String {
        format!("force over {}", self.press)
    }
}
