//! The mouse follows a touch.

use super::definition::{BindingReader, GestureDefinition, PlayedFrom};
use super::shared_keys::GAIN;
use crate::profile::keys::{Key, Table, WordKey, define_keys, word};
use crate::profile::target::Target;

define_keys! {
    WHEEL: WordKey<bool> = word("pointer", Table::Binding, &["motion", "wheel"], &[false, true], "what a moving touch moves: the pointer or the wheel");
}

/// The mouse follows a touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pointer {
    /// Whether the wheel turns instead of the pointer moving.
    pub wheel: bool,
    /// Pixels (or notches) per millimetre.
    pub gain: f64,
}

impl GestureDefinition for Pointer {
    const KEYS: &'static [Key] = &[WHEEL.key, GAIN.key];
    const OUTPUT: Option<&'static str> = None;
    const TAKES_MODE: bool = false;
    const PLAYED_FROM: PlayedFrom = PlayedFrom::TouchesOnly;

    fn read(binding: &mut BindingReader<'_>) -> Option<Self> {
        Some(Self {
            wheel: binding.choice(&WHEEL),
            gain: binding.number(&GAIN),
        })
    }

    fn describe(&self) -> String {
        "moving touch".to_owned()
    }

    fn output_names(&self, _name_of: &dyn Fn(Target) -> String) -> Vec<String> {
        let moved = if self.wheel { "wheel" } else { "motion" };
        vec![format!("mouse {moved}")]
    }
}
