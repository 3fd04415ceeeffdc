//! Bindings: the gesture with its numbers, the mode with its own, and the outputs that they name.

use super::Check;
use crate::profile::keys::{DIRECTIONS, Table};
use crate::profile::text::{Entries, Place, Text};
use crate::profile::{
    Binding, Curve, DeadZone, Direction, Dpad, Flavour, Gains, Gesture, Latch, Mode, Pointer,
    Profile, Stick, Swipe, TapHold, Target, Trigger,
};
use crate::types::{Axis, Nanos, Output, nanos_from_ms, nearest};

/// Frames a second of the NES (NTSC).
const NES_FRAMES_PER_S: f64 = 60.0988;
/// What keys and buttons are called.
const NAMES: &str = "keys are named like a, 7, f5, space, enter, escape, up, left-shift, right-ctrl, keypad-4, comma, page-up; \
                     buttons like pad:a, pad:start, pad:left-shoulder, pad:up; others mouse:left, mouse:wheel-up, layer:NAME, gelpad:pause";
/// Gestures that drive their outputs themselves, moment by moment.
const SELF_DRIVEN: &[&str] = &["dpad", "stick", "trigger", "pointer", "tap-hold"];

impl Check {
    /// The layers that bindings lie on, each once, in the order of the text.
    pub(super) fn layers(&mut self, tables: &[Entries]) -> Vec<String> {
        let mut layers = Vec::new();
        for entries in tables {
            if let Some((name, _)) = self.text(entries, "layer")
                && !layers.contains(&name)
            {
                layers.push(name);
            }
        }
        layers
    }

    /// Fills in the bindings, and the outputs that they drive.
    pub(super) fn bindings(&mut self, text: &Text, profile: &mut Profile) {
        let (mut off, mut grids) = (Vec::new(), Vec::new());
        for entries in &text.regions {
            let Some((name, _)) = self.text(entries, "name") else {
                continue;
            };
            if self.flag(entries, "off") == Some(true) {
                off.push(name);
            } else if entries.values.contains_key("columns") {
                grids.push(name);
            }
        }
        for entries in &text.bindings {
            let names = self.placed_texts(entries, "region");
            let gone = names.iter().any(|(name, _)| off.contains(name));
            if gone || self.flag(entries, "off") == Some(true) {
                continue;
            }
            let regions = self.named_regions(&names, &grids, profile);
            if let Some(binding) = self.binding(&text.top, entries, regions, profile) {
                profile.bindings.push(binding);
            }
        }
    }

    fn named_regions(
        &mut self,
        names: &[(String, Place)],
        grids: &[String],
        profile: &Profile,
    ) -> Vec<usize> {
        let mut regions = Vec::new();
        for (name, place) in names {
            match profile
                .regions
                .iter()
                .position(|region| region.name == *name)
            {
                Some(region) => regions.push(region),
                None => {
                    let known = profile.regions.iter().map(|region| region.name.as_str());
                    let help = match nearest(name, known) {
                        _ if grids.contains(name) => {
                            format!("cells of the grid are named `{name}-1`, `{name}-2`, ...")
                        }
                        Some(name) => format!("did you mean `{name}`?"),
                        None => format!("add a [[region]] with `name = \"{name}\"`"),
                    };
                    self.faults.help(
                        place,
                        format!("no region is named `{name}`"),
                        "not a region of this profile",
                        help,
                    );
                }
            }
        }
        regions
    }

    fn binding(
        &mut self,
        top: &Entries,
        entries: &Entries,
        regions: Vec<usize>,
        profile: &mut Profile,
    ) -> Option<Binding> {
        let word = self
            .choice(entries, "gesture", Table::Binding)
            .unwrap_or("press");
        let way = self
            .choice(entries, "mode", Table::Binding)
            .unwrap_or("direct");
        self.refuse_foreign(
            entries,
            Table::Binding,
            &[word, way],
            &format!("a {word} in mode {way}"),
        );
        let self_driven = SELF_DRIVEN.contains(&word);
        if self_driven
            && way != "direct"
            && let Some(value) = entries.values.get("mode")
        {
            self.faults.push(
                &value.place,
                format!("a {word} drives its outputs itself: it has no mode"),
                "take this out",
            );
        }
        let targets = match word {
            "tap-hold" => self.targets(entries, "tap", profile),
            _ => self.targets(entries, "output", profile),
        };
        let needed = match word {
            "tap-hold" => Some("tap"),
            "dpad" | "stick" | "trigger" | "pointer" => None,
            _ if way == "macro" => None,
            _ => Some("output"),
        };
        if let Some(key) = needed
            && !entries.values.contains_key(key)
        {
            self.faults.help(
                &entries.place,
                format!("the binding has no `{key}`"),
                "this binding",
                format!("write `{key} = \"key:space\"` in it"),
            );
        }
        if matches!(word, "dpad" | "stick") && !entries.values.contains_key("region") {
            self.faults.push(
                &entries.place,
                format!("a {word} needs a `region`: its middle is the region's"),
                "this binding",
            );
        }
        let gesture = self.gesture(word, top, entries, &regions, profile);
        let mode = self.mode(way, top, entries, profile);
        let layer = self
            .text(entries, "layer")
            .and_then(|(name, _)| profile.layers.iter().position(|layer| *layer == name));
        let sticky = self.flag(top, "sticky_keys").unwrap_or(false);
        let modifiers = !targets.is_empty()
            && targets
                .iter()
                .all(|target| is_modifier(*target, &profile.outputs));
        Some(Binding {
            regions,
            layer,
            gesture: gesture?,
            mode: match mode? {
                Mode::Direct if sticky && modifiers && !self_driven => Mode::Sticky,
                mode => mode,
            },
            targets,
        })
    }

    fn targets(&mut self, entries: &Entries, key: &str, profile: &mut Profile) -> Vec<Target> {
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

    /// A time of the binding, else of the profile, else the default.
    pub(super) fn own_ms(
        &mut self,
        top: &Entries,
        entries: &Entries,
        key: &str,
        default_ms: f64,
    ) -> Nanos {
        self.time(entries, key, Table::Binding)
            .or_else(|| self.time(top, key, Table::User))
            .unwrap_or_else(|| nanos_from_ms(default_ms))
    }

    fn own_number(&mut self, top: &Entries, entries: &Entries, key: &str, default: f64) -> f64 {
        self.number(entries, key, Table::Binding)
            .or_else(|| self.number(top, key, Table::User))
            .unwrap_or(default)
    }

    fn gesture(
        &mut self,
        word: &str,
        top: &Entries,
        entries: &Entries,
        regions: &[usize],
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
                if regions.len() < 2 {
                    let place = entries
                        .values
                        .get("region")
                        .map_or(&entries.place, |value| &value.place);
                    self.faults.help(
                        place,
                        "a chord has two regions or more",
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

    fn mode(
        &mut self,
        word: &str,
        top: &Entries,
        entries: &Entries,
        profile: &mut Profile,
    ) -> Option<Mode> {
        Some(match word {
            "classified" => {
                let frames = |count: f64| nanos_from_ms(count * 1000.0 / NES_FRAMES_PER_S);
                Mode::Classified(Latch {
                    short_ns: frames(self.own_number(top, entries, "short_frames", 5.0)),
                    long_ns: frames(self.own_number(top, entries, "long_frames", 32.0)),
                    long_after_ns: self.own_ms(top, entries, "long_ms", 200.0),
                })
            }
            "latch" => Mode::Latch(self.own_ms(top, entries, "length_ms", 100.0)),
            "tap" => Mode::Latch(self.own_ms(top, entries, "tap_ms", 34.0)),
            "toggle" => Mode::Toggle,
            "turbo" => {
                let hz = self
                    .number(entries, "turbo_hz", Table::Binding)
                    .unwrap_or(8.0);
                let period_ns = nanos_from_ms(1000.0 / hz);
                Mode::Turbo {
                    first_ns: period_ns,
                    period_ns,
                }
            }
            "repeat" => {
                let first_ns = self.own_ms(top, entries, "repeat_delay_ms", 500.0);
                let period_ns = self.own_ms(top, entries, "repeat_ms", 100.0);
                if first_ns == 0 || period_ns == 0 {
                    let key = if period_ns == 0 {
                        "repeat_ms"
                    } else {
                        "repeat_delay_ms"
                    };
                    let value = entries.values.get(key).or_else(|| top.values.get(key));
                    if let Some(value) = value {
                        self.faults.push(
                            &value.place,
                            format!("`{key}` is above 0 in mode repeat"),
                            "here",
                        );
                    }
                }
                Mode::Turbo {
                    first_ns: first_ns.max(1),
                    period_ns: period_ns.max(1),
                }
            }
            "sticky" => Mode::Sticky,
            "macro" => Mode::Macro(self.macro_steps(top, entries, profile)?),
            _ => Mode::Direct,
        })
    }
}

fn is_modifier(target: Target, outputs: &[Output]) -> bool {
    matches!(target, Target::Output(index) if matches!(outputs[index], Output::Key(key) if key.is_modifier()))
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
