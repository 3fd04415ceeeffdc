//! Macros: words to steps. Whatever a macro presses it releases, or it is refused.

use super::Check;
use crate::profile::text::Entries;
use crate::profile::{MacroStep, Profile, Target};
use crate::types::nanos_from_ms;

/// Longest wait in a macro, ms.
const LONGEST_MS: f64 = 60_000.0;

impl Check {
    pub(super) fn macro_steps(
        &mut self,
        top: &Entries,
        entries: &Entries,
        profile: &mut Profile,
    ) -> Option<Vec<MacroStep>> {
        let tap_ns = self.own_ms(top, entries, "tap_ms", 34.0);
        let Some(value) = entries.values.get("macro") else {
            self.faults.help(
                &entries.place,
                "the binding has no `macro`",
                "this binding",
                "write `macro = [\"tap key:a\", \"wait 50\", \"tap key:b\"]`",
            );
            return None;
        };
        let whole = value.place.clone();
        let mut steps = Vec::new();
        let mut down: Vec<Target> = Vec::new();
        for (text, place) in self.placed_texts(entries, "macro") {
            let (word, rest) = text.split_once(' ').unwrap_or((&text, ""));
            match word {
                "wait" => match rest.trim().parse::<f64>() {
                    Ok(ms) if (0.0..=LONGEST_MS).contains(&ms) => {
                        steps.push(MacroStep::Wait(nanos_from_ms(ms)))
                    }
                    _ => self.faults.push(
                        &place,
                        format!("`{rest}` is no time to wait: 0 to {LONGEST_MS} ms"),
                        "here",
                    ),
                },
                "press" | "release" | "tap" => {
                    let Some(target) = self.target(rest.trim(), &place, profile) else {
                        continue;
                    };
                    let is_down = down.contains(&target);
                    match (word, is_down) {
                        ("press" | "tap", true) => {
                            self.faults.push(
                                &place,
                                format!("`{}` is down already", rest.trim()),
                                "release it first",
                            );
                        }
                        ("press", false) => {
                            down.push(target);
                            steps.push(MacroStep::Press(target));
                        }
                        ("release", true) => {
                            down.retain(|other| *other != target);
                            steps.push(MacroStep::Release(target));
                        }
                        ("release", false) => {
                            self.faults.push(
                                &place,
                                format!("`{}` is not down", rest.trim()),
                                "nothing to release",
                            );
                        }
                        _ => steps.extend([
                            MacroStep::Press(target),
                            MacroStep::Wait(tap_ns),
                            MacroStep::Release(target),
                        ]),
                    }
                }
                _ => self.faults.help(
                    &place,
                    format!("a macro does not `{word}`"),
                    "not known",
                    "write `press key:a`, `release key:a`, `tap key:a` or `wait 50`",
                ),
            }
        }
        if !down.is_empty() {
            self.faults.push(
                &whole,
                "the macro ends with something pressed",
                "release it at the end",
            );
        }
        Some(steps)
    }
}
