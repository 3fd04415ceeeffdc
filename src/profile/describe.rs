//! Describes bindings, for the live view and `gelpad profile show`.

use super::{Binding, Mode, Profile, Target};
use crate::types::ms_from_nanos;

impl Profile {
    /// Where a binding is played: its regions and parts of a gamepad, else the whole pad.
    #[must_use]
    pub fn binding_place(&self, binding: &Binding) -> String {
        let regions = binding.regions.iter();
        let parts = binding.parts.iter().map(|part| self.parts[*part]);
        let names: Vec<String> = regions
            .map(|region| self.regions[*region].name.clone())
            .chain(parts.map(|part| part.to_string()))
            .collect();
        if names.is_empty() {
            "the pad".to_owned()
        } else {
            names.join(" + ")
        }
    }

    /// Everything that a binding drives, by the names that profiles use.
    #[must_use]
    pub fn output_names(&self, binding: &Binding) -> String {
        let name_of = |target| self.target_name(target);
        let mut names: Vec<String> = binding.targets.iter().copied().map(name_of).collect();
        names.extend(binding.gesture.output_names(&name_of));
        names.join(" ")
    }

    /// The name of a target in profiles.
    #[must_use]
    pub fn target_name(&self, target: Target) -> String {
        match target {
            Target::Output(index) => self.outputs[index].to_string(),
            Target::Layer(layer) => format!("layer:{}", self.layers[layer]),
            Target::Pause => "gelpad:pause".to_owned(),
            Target::Wheel { dx: 0, dy } if dy > 0 => "mouse:wheel-up".to_owned(),
            Target::Wheel { dx: 0, .. } => "mouse:wheel-down".to_owned(),
            Target::Wheel { dx, .. } if dx > 0 => "mouse:wheel-right".to_owned(),
            Target::Wheel { .. } => "mouse:wheel-left".to_owned(),
        }
    }

    /// What the touch must do, and how long the output is down.
    #[must_use]
    pub fn describe_binding(&self, binding: &Binding) -> String {
        let ms = |ns| ms_from_nanos(ns).round();
        let mode = match &binding.mode {
            Mode::Direct => String::new(),
            Mode::Classified(latch) => format!(
                ": {} ms, or {} ms if it lasts {} ms{}",
                ms(latch.short_ns),
                ms(latch.long_ns),
                ms(latch.long_after_ns),
                if latch.when_decided {
                    ", when that is known"
                } else {
                    ""
                }
            ),
            Mode::Latch(length_ns) => format!(": for {} ms", ms(*length_ns)),
            Mode::Toggle => ": on, and off with the next".to_owned(),
            Mode::Turbo { period_ns, .. } => format!(": again every {} ms", ms(*period_ns)),
            Mode::Sticky => ": until another press is over".to_owned(),
            Mode::Macro(steps) => format!(": {} steps", steps.len()),
        };
        let layer = binding.layer.map_or(String::new(), |layer| {
            format!(" (layer {})", self.layers[layer])
        });
        format!("{}{mode}{layer}", binding.gesture.describe())
    }
}
