//! A number of touches at once.

use super::definition::{BindingReader, GestureDefinition, PlayedFrom, Warning};
use super::shared_keys::FINGERS;
use crate::profile::keys::Key;
use crate::profile::settings::Settings;

/// At least this many touches at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contacts {
    /// The number of touches.
    pub count: usize,
}

impl GestureDefinition for Contacts {
    const KEYS: &'static [Key] = &[FINGERS.key];
    const PLAYED_FROM: PlayedFrom = PlayedFrom::TouchesOnly;

    fn read(binding: &mut BindingReader<'_>) -> Option<Self> {
        if !binding.has("fingers") {
            binding.mistake(
                "fingers",
                "the gesture contacts needs `fingers`, the number of touches",
                "this binding",
            );
        }
        Some(Self {
            count: binding.count(&FINGERS) as usize,
        })
    }

    fn describe(&self) -> String {
        format!("{} touches at once", self.count)
    }

    fn never_fires(&self, settings: &Settings) -> Option<Warning> {
        let panic = settings.panic_contacts?;
        (self.count >= panic).then_some((
            "this many contacts are the panic gesture",
            Some("set `panic_contacts` higher, or to 0"),
        ))
    }
}
