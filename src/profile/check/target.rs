//! Outputs: the keys, buttons, layers and wishes that a binding names.

use super::Check;
use crate::profile::text::{Entries, Place};
use crate::profile::{Profile, Target};
use crate::types::{Output, nearest};

/// What keys and buttons are called.
const NAMES: &str = "keys are named like a, 7, f5, space, enter, escape, up, left-shift, right-ctrl, keypad-4, comma, page-up; \
                     buttons like pad:a, pad:start, pad:left-shoulder, pad:up; others mouse:left, mouse:wheel-up, layer:NAME, gelpad:pause";
impl Check {
    pub(super) fn targets(
        &mut self,
        entries: &Entries,
        key: &str,
        profile: &mut Profile,
    ) -> Vec<Target> {
        let texts = self.placed_texts(entries, key);
        texts
            .iter()
            .filter_map(|(text, place)| self.target(text, place, profile))
            .collect()
    }

    /// What an output's text names.
    pub(super) fn target(
        &mut self,
        text: &str,
        place: &Place,
        profile: &mut Profile,
    ) -> Option<Target> {
        match text.split_once(':') {
            Some(("layer", name)) => return self.layer(name, place, profile),
            Some(("gelpad", "pause")) => return Some(Target::Pause),
            Some(("gelpad", name)) => {
                self.faults.help(
                    place,
                    format!("gelpad does nothing named `{name}`"),
                    "not known",
                    "write `gelpad:pause`",
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
            Ok(output) => {
                let known = profile.outputs.iter().position(|known| *known == output);
                Some(Target::Output(known.unwrap_or_else(|| {
                    profile.outputs.push(output);
                    profile.outputs.len() - 1
                })))
            }
            Err(unknown) => {
                let help = match unknown.suggestion.clone() {
                    Some(name) => format!("did you mean `{name}`?"),
                    None => NAMES.to_owned(),
                };
                self.faults
                    .help(place, unknown.to_string(), "not known", help);
                None
            }
        }
    }

    fn layer(&mut self, name: &str, place: &Place, profile: &Profile) -> Option<Target> {
        let found = profile.layers.iter().position(|layer| layer == name);
        if found.is_none() {
            let help = match nearest(name, profile.layers.iter().map(String::as_str)) {
                Some(layer) => format!("did you mean `layer:{layer}`?"),
                None => format!("write `layer = \"{name}\"` in the bindings that lie on it"),
            };
            self.faults.help(
                place,
                format!("no binding lies on a layer `{name}`"),
                "not known",
                help,
            );
        }
        found.map(Target::Layer)
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
