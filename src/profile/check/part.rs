//! Parts of a gamepad that play a binding, beside a region or instead of one.

use crate::profile::entries::{Entries, Place};
use crate::profile::gestures::{Listed, PlayedFrom};
use crate::profile::reader::{Reader, index_of};
use crate::types::GamepadPart;

impl Reader {
    /// The parts that a binding with a gesture is played from, as indices into the profile's.
    pub(super) fn parts(&mut self, entries: &Entries, gesture: &Listed) -> Vec<usize> {
        let mut parts = Vec::new();
        for (text, place) in self.texts(entries, "from") {
            match text.parse::<GamepadPart>() {
                Ok(part) => {
                    self.refuse_unfit(gesture, part, &text, &place);
                    parts.push(index_of(&mut self.parts, part));
                }
                Err(unknown) => {
                    let help = match unknown.suggestion.clone() {
                        Some(name) => format!("did you mean `{name}`?"),
                        None => "write a button such as pad:a, pad:start or pad:up, a trigger (pad:left-trigger) or a stick (stick:left)".to_owned(),
                    };
                    self.errors
                        .help(&place, unknown.to_string(), "unknown", help);
                }
            }
        }
        parts
    }

    fn refuse_unfit(&mut self, gesture: &Listed, part: GamepadPart, text: &str, place: &Place) {
        let is_stick = matches!(part, GamepadPart::Stick(..));
        let word = gesture.word;
        let (message, help) = match gesture.played_from {
            PlayedFrom::TouchesOnly => (
                format!("a gamepad cannot play the gesture {word}: only touches can"),
                "remove it, or choose another gesture",
            ),
            PlayedFrom::Sticks if !is_stick => (
                format!("the gesture {word} needs directions, and `{text}` has none"),
                "write `from = \"stick:left\"`; for single buttons add one binding for each",
            ),
            PlayedFrom::Pressed if is_stick => (
                format!("the gesture {word} needs pressure, and `{text}` has none"),
                "write `from = \"pad:right-trigger\"`, or choose the gesture stick or dpad",
            ),
            _ => return,
        };
        self.errors.help(place, message, "does not fit", help);
    }
}
