//! Macros: words to steps. A macro must release whatever it presses.

use crate::profile::entries::Place;
use crate::profile::gestures::BindingReader;
use crate::profile::keys::{Key, KeyKind, LONGEST_MS, NumberKey, Table, define_keys, time_ms};
use crate::profile::reader::Reader;
use crate::profile::{MacroStep, Target};
use crate::types::{Nanos, nanos_from_ms};

define_keys! {
    pub(super) TAP_MS: NumberKey = time_ms("tap_ms", 34.0, "length of a press in mode tap and of `tap` in a macro");
    pub(super) MACRO: Key = Key::new("macro", Table::Binding, KeyKind::Texts, "steps: `press X`, `release X`, `tap X`, `wait MS`");
}

/// The steps so far, and the outputs that are down after them.
struct Recording {
    tap_ns: Nanos,
    steps: Vec<MacroStep>,
    down: Vec<Target>,
}

impl BindingReader<'_> {
    pub(super) fn macro_steps(&mut self) -> Option<Vec<MacroStep>> {
        if !self.has("macro") {
            self.mistake_with_help(
                "macro",
                "the binding has no `macro`",
                "this binding",
                "add `macro = [\"tap key:a\", \"wait 50\", \"tap key:b\"]`",
            );
            return None;
        }
        let mut recording = Recording {
            tap_ns: self.time(&TAP_MS),
            steps: Vec::new(),
            down: Vec::new(),
        };
        for (text, place) in self.reader.texts(self.entries, "macro") {
            recording.add(self.reader, &text, &place);
        }
        if !recording.down.is_empty() {
            self.mistake(
                "macro",
                "the macro ends with an output still pressed",
                "release it at the end",
            );
        }
        Some(recording.steps)
    }
}

impl Recording {
    fn add(&mut self, reader: &mut Reader, text: &str, place: &Place) {
        let (word, rest) = text.split_once(' ').unwrap_or((text, ""));
        let rest = rest.trim();
        match word {
            "wait" => match rest.parse::<f64>() {
                Ok(ms) if (0.0..=LONGEST_MS).contains(&ms) => {
                    self.steps.push(MacroStep::Wait(nanos_from_ms(ms)));
                }
                _ => reader.errors.push(
                    place,
                    format!("`{rest}` is not a time to wait: write 0 to {LONGEST_MS}, in ms"),
                    "not a time",
                ),
            },
            "press" | "release" | "tap" => {
                if let Some(target) = reader.target(rest, place) {
                    self.add_target(reader, word, target, (rest, place));
                }
            }
            _ => reader.errors.help(
                place,
                format!("unknown macro step `{word}`"),
                "unknown",
                "write `press key:a`, `release key:a`, `tap key:a` or `wait 50`",
            ),
        }
    }

    fn add_target(
        &mut self,
        reader: &mut Reader,
        word: &str,
        target: Target,
        (name, place): (&str, &Place),
    ) {
        let is_down = self.down.contains(&target);
        match (word, is_down) {
            ("press" | "tap", true) => reader.errors.push(
                place,
                format!("the macro presses `{name}` while it is down"),
                "release it first",
            ),
            ("press", false) => {
                self.down.push(target);
                self.steps.push(MacroStep::Press(target));
            }
            ("release", true) => {
                self.down.retain(|other| *other != target);
                self.steps.push(MacroStep::Release(target));
            }
            ("release", false) => reader.errors.push(
                place,
                format!("the macro releases `{name}` while it is up"),
                "nothing to release",
            ),
            _ => self.steps.extend([
                MacroStep::Press(target),
                MacroStep::Wait(self.tap_ns),
                MacroStep::Release(target),
            ]),
        }
    }
}
