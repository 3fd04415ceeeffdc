//! Bindings in words: for the live view and `gelpad profile show`.

use super::{Binding, Gesture, Mode, Profile, Target};
use crate::types::ms_from_nanos;

impl Profile {
    /// Where a binding is played: its regions and parts of a gamepad, or the pad.
    #[must_use]
    pub fn place_of(&self, binding: &Binding) -> String {
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

    /// Everything that a binding drives, as profiles name it.
    #[must_use]
    pub fn outputs_of(&self, binding: &Binding) -> String {
        let mut names: Vec<String> = binding
            .targets
            .iter()
            .map(|target| self.name_of(*target))
            .collect();
        match &binding.gesture {
            Gesture::Dpad(dpad) => names.extend(
                dpad.targets
                    .iter()
                    .flatten()
                    .map(|target| self.name_of(*target)),
            ),
            Gesture::Stick(stick) => names.extend(
                [stick.x, stick.y]
                    .iter()
                    .flatten()
                    .map(|axis| format!("pad:{axis}")),
            ),
            Gesture::Trigger(trigger) => names.push(format!("pad:{}", trigger.axis)),
            Gesture::Pointer(pointer) if pointer.wheel => names.push("mouse wheel".to_owned()),
            Gesture::Pointer(_) => names.push("mouse motion".to_owned()),
            Gesture::TapHold(own) => {
                let hold: Vec<String> = own
                    .hold
                    .iter()
                    .map(|target| self.name_of(*target))
                    .collect();
                names.push(format!("or {}", hold.join(" + ")));
            }
            _ => {}
        }
        names.join(" ")
    }

    /// What a target is called.
    #[must_use]
    pub fn name_of(&self, target: Target) -> String {
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

    /// What the touch must be, and how long the output is down.
    #[must_use]
    pub fn how(&self, binding: &Binding) -> String {
        let ms = |ns| ms_from_nanos(ns).round();
        let gesture = match &binding.gesture {
            Gesture::Press => "touch".to_owned(),
            Gesture::Tap { within_ns, .. } => format!("tap within {} ms", ms(*within_ns)),
            Gesture::Hold { after_ns, .. } => format!("hold for {} ms", ms(*after_ns)),
            Gesture::DoubleTap { gap_ns, .. } => format!("double tap within {} ms", ms(*gap_ns)),
            Gesture::Swipe(swipe) => format!(
                "swipe {}{}",
                super::keys::DIRECTIONS[usize::from(swipe.direction.eighth) % 8],
                if swipe.fingers > 1 {
                    format!(" with {} fingers", swipe.fingers)
                } else {
                    String::new()
                }
            ),
            Gesture::Chord { window_ns } => format!("all within {} ms", ms(*window_ns)),
            Gesture::Contacts { count } => format!("{count} touches at once"),
            Gesture::Force { press, .. } => format!("force over {press}"),
            Gesture::Dpad(dpad) => format!("d-pad, {} ways", dpad.ways),
            Gesture::Stick(stick) if stick.floating => "floating stick".to_owned(),
            Gesture::Stick(_) => "stick".to_owned(),
            Gesture::Trigger(_) => "force".to_owned(),
            Gesture::Pointer(_) => "moving touch".to_owned(),
            Gesture::TapHold(own) => format!("tap, or hold for {} ms", ms(own.term_ns)),
        };
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
        format!("{gesture}{mode}{layer}")
    }
}
