//! Force as an axis.

use super::definition::{BindingReader, GestureDefinition, PlayedFrom};
use super::shared_keys::{CURVE, Curve, DEAD_ZONE, GAIN};
use crate::profile::keys::{Key, KeyKind, Table, define_keys};
use crate::profile::target::Target;
use crate::types::Axis;

define_keys! {
    AXIS: Key = Key::new("axis", Table::Binding, KeyKind::Text, "pad:right-trigger or another axis");
}

/// Force as an axis, 0..1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trigger {
    /// The axis.
    pub axis: Axis,
    /// Its response.
    pub curve: Curve,
    /// Factor.
    pub gain: f64,
}

impl GestureDefinition for Trigger {
    const KEYS: &'static [Key] = &[AXIS, DEAD_ZONE.key, CURVE.key, GAIN.key];
    const OUTPUT: Option<&'static str> = None;
    const TAKES_MODE: bool = false;
    const PLAYED_FROM: PlayedFrom = PlayedFrom::Pressed;

    fn read(binding: &mut BindingReader<'_>) -> Option<Self> {
        let axis = binding.axis(&AXIS);
        if !binding.has("axis") {
            binding.mistake_with_help(
                "axis",
                "a trigger needs an `axis`",
                "this binding",
                "write `axis = \"pad:right-trigger\"`",
            );
        }
        Some(Self {
            axis: axis?,
            curve: binding.curve(),
            gain: binding.number(&GAIN),
        })
    }

    fn describe(&self) -> String {
        "force".to_owned()
    }

    fn output_names(&self, _name_of: &dyn Fn(Target) -> String) -> Vec<String> {
        vec![format!("pad:{}", self.axis)]
    }
}
