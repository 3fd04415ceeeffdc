//! Gestures: each with its own numbers.

use super::Check;
use crate::profile::keys::{DIRECTIONS, Table};
use crate::profile::text::Entries;
use crate::profile::{
    Curve, DeadZone, Direction, Dpad, Flavour, Gains, Gesture, Pointer, Profile, Stick, Swipe,
    TapHold, Trigger,
};
use crate::types::{Axis, Nanos, nearest};

impl Check {
    pub(super) fn gesture(
        &mut self,
        word: &str,
        top: &Entries,
        entries: &Entries,
        places: usize,
        profile: &mut Profile,
    ) -> Option<Gesture> {
        let term_ns = self.own_ms(top, entries, "tapping_term_ms", 200.0);
        let slop_mm = self.own_number(top, entries, "slop_mm", 8.0);
        Some(match word {
            "tap" => Gesture::Tap {
                within_ns: term_ns,
                slop_mm,
            },
            "hold" => Gesture::Hold {
                after_ns: self.own_ms(top, entries, "hold_ms", 400.0),
                slop_mm,
            },
            "double-tap" => Gesture::DoubleTap {
                gap_ns: self.own_ms(top, entries, "double_tap_ms", 300.0),
                within_ns: term_ns,
            },
            "swipe" => Gesture::Swipe(self.swipe(top, entries)?),
            "chord" => {
                if places < 2 {
                    let place = entries
                        .values
                        .get("region")
                        .map_or(&entries.place, |value| &value.place);
                    self.faults.help(
                        place,
                        "a chord has two regions or more, or buttons",
                        "too few",
                        "write `region = [\"a\", \"b\"]`",
                    );
                }
                Gesture::Chord {
                    window_ns: self.own_ms(top, entries, "chord_ms", 60.0),
                }
            }
            "contacts" => {
                if !entries.values.contains_key("fingers") {
                    self.faults.push(
                        &entries.place,
                        "contacts need `fingers`: how many",
                        "this binding",
                    );
                }
                Gesture::Contacts {
                    count: self.count(entries, "fingers", Table::Binding).unwrap_or(2) as usize,
                }
            }
            "force" => self.force(entries),
            "dpad" => Gesture::Dpad(self.dpad(entries, profile)),
            "stick" => Gesture::Stick(self.stick(entries)),
            "trigger" => {
                let axis = self.axis(entries, "axis");
                if !entries.values.contains_key("axis") {
                    self.faults.push(
                        &entries.place,
                        "a trigger needs `axis`: pad:right-trigger or another",
                        "this binding",
                    );
                }
                Gesture::Trigger(Trigger {
                    axis: axis?,
                    curve: self.curve(entries, 0.0),
                    gain: self.number(entries, "gain", Table::Binding).unwrap_or(1.0),
                })
            }
            "pointer" => Gesture::Pointer(Pointer {
                wheel: self.choice(entries, "pointer", Table::Binding) == Some("wheel"),
                gain: self.number(entries, "gain", Table::Binding).unwrap_or(1.0),
            }),
            "tap-hold" => Gesture::TapHold(self.tap_hold(top, entries, term_ns, profile)),
            _ => Gesture::Press,
        })
    }

    fn swipe(&mut self, top: &Entries, entries: &Entries) -> Option<Swipe> {
        let word = self.choice(entries, "direction", Table::Binding);
        if !entries.values.contains_key("direction") {
            self.faults.push(
                &entries.place,
                "a swipe needs a `direction`: left, up-right or another",
                "this binding",
            );
        }
        let eighth = DIRECTIONS
            .iter()
            .position(|direction| Some(*direction) == word)? as u8;
        let ways = self
            .ways(entries)
            .unwrap_or(if eighth % 2 == 1 { 8 } else { 4 });
        if eighth % 2 == 1
            && ways == 4
            && let Some(value) = entries.values.get("direction")
        {
            self.faults.help(
                &value.place,
                "4 ways have no diagonals",
                "a diagonal",
                "write `ways = 8`",
            );
        }
        Some(Swipe {
            direction: Direction { eighth },
            ways,
            fingers: self.count(entries, "fingers", Table::Binding).unwrap_or(1) as usize,
            distance_mm: self.own_number(top, entries, "swipe_mm", 15.0),
            within_ns: self.own_ms(top, entries, "swipe_ms", 300.0),
        })
    }

    fn ways(&mut self, entries: &Entries) -> Option<u8> {
        let ways = self.count(entries, "ways", Table::Binding)? as u8;
        if ways != 4
            && ways != 8
            && let Some(value) = entries.values.get("ways")
        {
            self.faults.push(
                &value.place,
                format!("`ways` = {ways}: 4 or 8 directions are told apart"),
                "here",
            );
        }
        Some(ways)
    }

    fn force(&mut self, entries: &Entries) -> Gesture {
        let press = self.number(entries, "force", Table::Binding).unwrap_or(0.5);
        let release = self
            .number(entries, "force_release", Table::Binding)
            .unwrap_or(0.8 * press);
        if release > press
            && let Some(value) = entries.values.get("force_release")
        {
            self.faults.push(
                &value.place,
                "`force_release` lies above `force`: the press would end as it begins",
                "here",
            );
        }
        Gesture::Force { press, release }
    }

    fn dpad(&mut self, entries: &Entries, profile: &mut Profile) -> Dpad {
        let targets = ["right", "up", "left", "down"].map(|key| {
            let (text, place) = self.text(entries, key)?;
            self.target(&text, &place, profile)
        });
        if !["right", "up", "left", "down"]
            .iter()
            .any(|key| entries.values.contains_key(*key))
        {
            self.faults.push(
                &entries.place,
                "a dpad needs outputs: `up`, `down`, `left`, `right`",
                "this binding",
            );
        }
        Dpad {
            ways: self.ways(entries).unwrap_or(4),
            dead_zone: self
                .number(entries, "dead_zone", Table::Binding)
                .unwrap_or(0.2),
            diagonal: self
                .number(entries, "diagonal", Table::Binding)
                .unwrap_or(0.5),
            targets,
        }
    }

    fn curve(&mut self, entries: &Entries, dead_zone: f64) -> Curve {
        Curve {
            dead_zone: self
                .number(entries, "dead_zone", Table::Binding)
                .unwrap_or(dead_zone),
            exponent: self.number(entries, "curve", Table::Binding).unwrap_or(1.0),
        }
    }

    fn stick(&mut self, entries: &Entries) -> Stick {
        let gain = self.number(entries, "gain", Table::Binding).unwrap_or(1.0);
        let [right, up, left, down] = ["gain_right", "gain_up", "gain_left", "gain_down"]
            .map(|key| self.number(entries, key, Table::Binding).unwrap_or(gain));
        if !["axis_x", "axis_y"]
            .iter()
            .any(|key| entries.values.contains_key(*key))
        {
            self.faults.push(
                &entries.place,
                "a stick needs `axis_x` or `axis_y`: pad:left-x and pad:left-y",
                "this binding",
            );
        }
        Stick {
            floating: self.choice(entries, "stick", Table::Binding) == Some("floating"),
            dead_zone: match self.choice(entries, "dead_zone_shape", Table::Binding) {
                Some("square") => DeadZone::Square,
                _ => DeadZone::Round,
            },
            curve: self.curve(entries, 0.2),
            gains: Gains {
                right,
                up,
                left,
                down,
            },
            x: self.axis(entries, "axis_x"),
            y: self.axis(entries, "axis_y"),
        }
    }

    fn axis(&mut self, entries: &Entries, key: &str) -> Option<Axis> {
        let (text, place) = self.text(entries, key)?;
        let names: Vec<String> = Axis::ALL.iter().map(|axis| format!("pad:{axis}")).collect();
        let found = text.strip_prefix("pad:").and_then(|name| name.parse().ok());
        if found.is_none() {
            let help = match nearest(&text, names.iter().map(String::as_str)) {
                Some(name) => format!("did you mean `{name}`?"),
                None => format!("axes are {}", names.join(", ")),
            };
            self.faults.help(
                &place,
                format!("no axis is named `{text}`"),
                "not known",
                help,
            );
        }
        found
    }

    fn tap_hold(
        &mut self,
        top: &Entries,
        entries: &Entries,
        term_ns: Nanos,
        profile: &mut Profile,
    ) -> TapHold {
        if !entries.values.contains_key("hold") {
            self.faults.push(
                &entries.place,
                "a tap-hold has no `hold`: its second output",
                "this binding",
            );
        }
        TapHold {
            flavour: match self.choice(entries, "flavour", Table::Binding) {
                Some("tap-preferred") => Flavour::TapPreferred,
                Some("balanced") => Flavour::Balanced,
                Some("hold-preferred") => Flavour::HoldPreferred,
                _ => Flavour::Speculative,
            },
            term_ns,
            quick_tap_ns: self.own_ms(top, entries, "quick_tap_ms", 0.0),
            prior_idle_ns: self.own_ms(top, entries, "require_prior_idle_ms", 0.0),
            hold: self.targets(entries, "hold", profile),
        }
    }
}
