//! Bindings: their regions, and how their outputs are driven.

use super::Check;
use crate::profile::keys::Table;
use crate::profile::text::{Entries, Place, Text};
use crate::profile::{Binding, Latch, Mode, Profile, Target};
use crate::types::{Nanos, Output, nanos_from_ms, nearest};

/// Frames a second of the NES (NTSC).
const NES_FRAMES_PER_S: f64 = 60.0988;
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
                self.binding_places.push(entries.place.clone());
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
        let placed = ["region", "from"].map(|key| entries.values.contains_key(key));
        if matches!(word, "dpad" | "stick") && placed == [false, false] {
            self.faults.push(
                &entries.place,
                format!(
                    "a {word} needs a `region`: its middle is the region's (or `from` a stick)"
                ),
                "this binding",
            );
        }
        let parts = self.parts(entries, word, profile);
        let gesture = self.gesture(word, top, entries, regions.len() + parts.len(), profile);
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
            parts,
            layer,
            gesture: gesture?,
            mode: match mode? {
                Mode::Direct if sticky && modifiers && !self_driven => Mode::Sticky,
                mode => mode,
            },
            targets,
        })
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

    pub(super) fn own_number(
        &mut self,
        top: &Entries,
        entries: &Entries,
        key: &str,
        default: f64,
    ) -> f64 {
        self.number(entries, key, Table::Binding)
            .or_else(|| self.number(top, key, Table::User))
            .unwrap_or(default)
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
                    when_decided: self.choice(top, "classify", Table::User) == Some("decided"),
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
