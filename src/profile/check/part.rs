//! Parts of a gamepad: what a binding is played from beside a region, or instead of one.

use super::Check;
use crate::profile::Profile;
use crate::profile::text::{Entries, Place};
use crate::types::Part;

/// Gestures that only touches make.
const OF_TOUCHES: &[&str] = &["swipe", "contacts", "pointer"];
/// Gestures that a stick makes, and no button.
const OF_STICKS: &[&str] = &["dpad", "stick"];
/// Gestures that go by how far something is pressed.
const OF_FORCE: &[&str] = &["force", "trigger"];

impl Check {
    /// The parts that a binding with a gesture is played from, as indices into the profile's.
    pub(super) fn parts(
        &mut self,
        entries: &Entries,
        gesture: &str,
        profile: &mut Profile,
    ) -> Vec<usize> {
        let mut parts = Vec::new();
        for (text, place) in self.placed_texts(entries, "from") {
            let part = match text.parse::<Part>() {
                Ok(part) => part,
                Err(unknown) => {
                    let help = match unknown.suggestion.clone() {
                        Some(name) => format!("did you mean `{name}`?"),
                        None => "write pad:a, pad:start, pad:up or another button, pad:left-trigger, stick:left".to_owned(),
                    };
                    self.faults
                        .help(&place, unknown.to_string(), "not known", help);
                    continue;
                }
            };
            self.refuse_unfit(gesture, part, &text, &place);
            let known = profile.parts.iter().position(|known| *known == part);
            parts.push(known.unwrap_or_else(|| {
                profile.parts.push(part);
                profile.parts.len() - 1
            }));
        }
        if !parts.is_empty()
            && let Some(value) = entries.values.get("stick")
            && self.choice(entries, "stick", crate::profile::Table::Binding) == Some("floating")
        {
            self.faults.push(
                &value.place,
                "a gamepad's stick has its own middle: it cannot float",
                "take this out",
            );
        }
        parts
    }

    fn refuse_unfit(&mut self, gesture: &str, part: Part, text: &str, place: &Place) {
        let is_stick = matches!(part, Part::Stick(..));
        let (message, help) = if OF_TOUCHES.contains(&gesture) {
            (
                format!("no part of a gamepad makes a {gesture}: only touches do"),
                "take it out, or choose another gesture",
            )
        } else if OF_STICKS.contains(&gesture) && !is_stick {
            (
                format!("`{text}` has no directions, as a {gesture} wants"),
                "write `from = \"stick:left\"`; for single buttons write a binding each",
            )
        } else if OF_FORCE.contains(&gesture) && is_stick {
            (
                format!("`{text}` is not pressed more or less, as a {gesture} wants"),
                "write `from = \"pad:right-trigger\"`, or choose the gesture stick or dpad",
            )
        } else {
            return;
        };
        self.faults.help(place, message, "does not fit", help);
    }
}
