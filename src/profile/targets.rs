//! Reads outputs: the keys, buttons, axes, layers and actions that a binding names.

use super::entries::{Entries, Place};
use super::reader::{Reader, index_of};
use super::target::Target;
use crate::types::{Axis, Output, nearest};

/// Examples of names.
const NAMES: &str = "keys are named like key:a, key:7, key:f5, key:space, key:enter, key:up, key:left-shift, key:keypad-4; \
                     buttons like pad:a, pad:start, pad:left-shoulder; others are mouse:left, mouse:wheel-up, layer:NAME, gelpad:pause";

impl Reader {
    /// The outputs of a key.
    pub(super) fn targets(&mut self, entries: &Entries, key: &str) -> Vec<Target> {
        let texts = self.texts(entries, key);
        texts
            .iter()
            .filter_map(|(text, place)| self.target(text, place))
            .collect()
    }

    /// The output that a text names.
    pub(super) fn target(&mut self, text: &str, place: &Place) -> Option<Target> {
        match text.split_once(':') {
            Some(("layer", name)) => return self.layer(name, place),
            Some(("gelpad", "pause")) => return Some(Target::Pause),
            Some(("gelpad", _)) => {
                self.errors.help(
                    place,
                    format!("unknown action `{text}`"),
                    "unknown",
                    "write `gelpad:pause`; there is no other action",
                );
                return None;
            }
            Some(("mouse", name)) => {
                if let Some(wheel) = wheel(name) {
                    return Some(wheel);
                }
            }
            _ => {}
        }
        match text.parse::<Output>() {
            Ok(output) => Some(Target::Output(index_of(&mut self.outputs, output))),
            Err(unknown) => {
                let help = match unknown.suggestion.clone() {
                    Some(name) => format!("did you mean `{name}`?"),
                    None => NAMES.to_owned(),
                };
                self.errors
                    .help(place, unknown.to_string(), "unknown", help);
                None
            }
        }
    }

    fn layer(&mut self, name: &str, place: &Place) -> Option<Target> {
        let found = self.layers.iter().position(|layer| layer == name);
        if found.is_none() {
            let help = match nearest(name, self.layers.iter().map(String::as_str)) {
                Some(layer) => format!("did you mean `layer:{layer}`?"),
                None => format!("add `layer = \"{name}\"` to the bindings that it switches on"),
            };
            let message = format!("no binding is on the layer `{name}`");
            self.errors.help(place, message, "unknown layer", help);
        }
        found.map(Target::Layer)
    }

    /// The axis that a key names.
    pub(super) fn axis(&mut self, entries: &Entries, key: &str) -> Option<Axis> {
        let (text, place) = self.text(entries, key)?;
        let found = text.strip_prefix("pad:").and_then(|name| name.parse().ok());
        if found.is_none() {
            let names: Vec<String> = Axis::ALL.iter().map(|axis| format!("pad:{axis}")).collect();
            let help = match nearest(&text, names.iter().map(String::as_str)) {
                Some(name) => format!("did you mean `{name}`?"),
                None => format!("axes are {}", names.join(", ")),
            };
            self.errors
                .help(&place, format!("unknown axis `{text}`"), "unknown", help);
        }
        found
    }
}

fn wheel(name: &str) -> Option<Target> {
    let (dx, dy) = match name {
        "wheel-up" => (0, 1),
        "wheel-down" => (0, -1),
        "wheel-right" => (1, 0),
        "wheel-left" => (-1, 0),
        _ => return None,
    };
    Some(Target::Wheel { dx, dy })
}
