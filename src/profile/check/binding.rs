//! Bindings: where they are played, and what they drive.

use std::collections::{BTreeMap, BTreeSet};

use super::modes;
use crate::profile::entries::{Entries, Place, Text};
use crate::profile::gestures::{self, BindingReader, Listed};
use crate::profile::keys::{FlagKey, Key, KeyKind, Table, WordKey, flag, word};
use crate::profile::reader::Reader;
use crate::profile::{Binding, Mode, Region, Target};
use crate::types::{Output, nearest};

const GESTURE: WordKey<Listed> = word(
    "gesture",
    Table::Binding,
    gestures::WORDS,
    gestures::LISTED,
    "what the touch must do",
);
const MODE: WordKey<modes::Listed> = word(
    "mode",
    Table::Binding,
    modes::WORDS,
    modes::LISTED,
    "how the output is driven",
);
const OFF: FlagKey = flag(
    "off",
    Table::Binding,
    false,
    "removes a binding of the base",
);
const fn key(name: &'static str, kind: KeyKind, about: &'static str) -> Key {
    Key::new(name, Table::Binding, kind, about)
}
pub(in crate::profile) const KEYS: &[Key] = &[
    key("region", KeyKind::Texts, "the region, or several").or("the pad"),
    key(
        "from",
        KeyKind::Texts,
        "part of a gamepad or switch (pad:a, pad:left-trigger, stick:left, ...), or several: beside the region, or instead of one",
    ),
    key("layer", KeyKind::Text, "works only while this layer is on").or("always"),
    GESTURE.key,
    MODE.key,
    key(
        "output",
        KeyKind::Texts,
        "key:NAME, pad:NAME, mouse:NAME, layer:NAME, gelpad:pause; or several",
    ),
    OFF.key,
];

/// The keys of gestures and modes, each once, with the words of those that take it.
pub(in crate::profile) fn shared_keys() -> Vec<(Key, Vec<&'static str>)> {
    let gestures = gestures::LISTED.iter().map(|one| (one.word, one.keys));
    let modes = modes::LISTED.iter().map(|one| (one.word, one.keys));
    let mut shared: Vec<(Key, Vec<&'static str>)> = Vec::new();
    for (word, keys) in gestures.chain(modes) {
        for key in keys {
            match shared.iter_mut().find(|(known, _)| known.name == key.name) {
                Some((_, only)) => only.push(word),
                None => shared.push((*key, vec![word])),
            }
        }
    }
    shared
}

/// Most bindings of a profile.
const MOST_BINDINGS: usize = 10_000;
/// With more regions, the nearest name of an unknown one is not searched.
const MOST_COMPARED: usize = 500;

/// What bindings may name as a region.
struct RegionNames<'a> {
    /// Index of each region.
    regions: BTreeMap<&'a str, usize>,
    /// Taken out by `off`.
    off: BTreeSet<String>,
    /// Grids, of which only the cells have names.
    grids: BTreeSet<String>,
}

impl Reader {
    /// All bindings, and where each was written.
    pub(super) fn bindings(
        &mut self,
        text: &Text,
        regions: &[Region],
    ) -> (Vec<Binding>, Vec<Place>) {
        let mut layers = BTreeSet::new();
        for entries in &text.bindings {
            if let Some((name, _)) = self.text(entries, "layer")
                && layers.insert(name.clone())
            {
                self.layers.push(name);
            }
        }
        if let Some(extra) = text.bindings.get(MOST_BINDINGS) {
            self.errors.help(
                &extra.place,
                format!("more than {MOST_BINDINGS} bindings"),
                "one too many",
                "remove some",
            );
            return (Vec::new(), Vec::new());
        }
        let known = self.region_names(&text.regions, regions);
        let keys = shared_keys();
        let (mut bindings, mut places) = (Vec::new(), Vec::new());
        for entries in &text.bindings {
            let names = self.texts(entries, "region");
            let is_off = names.iter().any(|(name, _)| known.off.contains(name));
            if is_off || self.flag(entries, &OFF) {
                continue;
            }
            let own = self.named_regions(&names, &known);
            if let Some(binding) = self.binding(&text.top, entries, own, &keys) {
                bindings.push(binding);
                places.push(entries.place.clone());
            }
        }
        (bindings, places)
    }

    fn region_names<'a>(&mut self, tables: &[Entries], regions: &'a [Region]) -> RegionNames<'a> {
        let (mut off, mut grids) = (BTreeSet::new(), BTreeSet::new());
        for entries in tables {
            let Some((name, _)) = self.text(entries, "name") else {
                continue;
            };
            if self.flag(entries, &super::region::OFF) {
                off.insert(name);
            } else if entries.has("columns") {
                grids.insert(name);
            }
        }
        let places = regions.iter().enumerate();
        RegionNames {
            regions: places
                .map(|(index, region)| (region.name.as_str(), index))
                .collect(),
            off,
            grids,
        }
    }

    fn named_regions(&mut self, names: &[(String, Place)], known: &RegionNames<'_>) -> Vec<usize> {
        let mut found = Vec::new();
        for (name, place) in names {
            if let Some(index) = known.regions.get(name.as_str()) {
                found.push(*index);
                continue;
            }
            let compared = known.regions.keys().copied().take(MOST_COMPARED);
            let help = match nearest(name, compared) {
                _ if known.grids.contains(name) => {
                    format!("the cells of the grid are named `{name}-1`, `{name}-2`, ...")
                }
                Some(name) => format!("did you mean `{name}`?"),
                None => format!("add a [[region]] with `name = \"{name}\"`"),
            };
            let message = format!("no region is named `{name}`");
            self.errors.help(place, message, "unknown region", help);
        }
        found
    }

    fn binding(
        &mut self,
        top: &Entries,
        entries: &Entries,
        regions: Vec<usize>,
        keys: &[(Key, Vec<&'static str>)],
    ) -> Option<Binding> {
        let gesture = self.choice_or_default(entries, &GESTURE);
        let mode = self.choice_or_default(entries, &MODE);
        self.refuse_foreign(
            entries,
            keys.iter().map(|(key, only)| (key, only.as_slice())),
            &[gesture.word, mode.word],
            &format!("the gesture {} in mode {}", gesture.word, mode.word),
        );
        self.check_needs(entries, &gesture, &mode);
        let targets = self.targets(entries, gesture.output.unwrap_or("output"));
        let parts = self.parts(entries, &gesture);
        let sticky = self.flag(top, &super::settings::STICKY_KEYS);
        let mut binding = BindingReader {
            reader: self,
            top,
            entries,
            places: regions.len() + parts.len(),
        };
        let pattern = (gesture.read)(&mut binding);
        let driven = (mode.read)(&mut binding);
        let layer = self.text(entries, "layer");
        let layer = layer.and_then(|(name, _)| self.layers.iter().position(|layer| *layer == name));
        let sticks = sticky && gesture.takes_mode && are_modifiers(&targets, &self.outputs);
        Some(Binding {
            regions,
            parts,
            layer,
            gesture: pattern?,
            mode: match driven? {
                Mode::Direct if sticks => Mode::Sticky,
                mode => mode,
            },
            targets,
        })
    }

    /// Reports what the gesture and mode need and the binding does not have, and a mode that the gesture does not take.
    fn check_needs(&mut self, entries: &Entries, gesture: &Listed, mode: &modes::Listed) {
        if !gesture.takes_mode && mode.word != MODE.values[0].word && entries.has("mode") {
            let message = format!("the gesture {} does not take a mode", gesture.word);
            self.errors
                .push(entries.place_of("mode"), message, "remove this");
        }
        if let Some(key) = gesture.output
            && (mode.needs_output || !gesture.takes_mode)
            && !entries.has(key)
        {
            self.errors.help(
                &entries.place,
                format!("the binding has no `{key}`"),
                "this binding",
                format!("add `{key} = \"key:space\"`"),
            );
        }
        if gesture.needs_centre && !entries.has("region") && !entries.has("from") {
            self.errors.help(
                &entries.place,
                format!("a {} needs a `region`, whose centre it uses", gesture.word),
                "this binding",
                "add `region = \"NAME\"`, or `from = \"stick:left\"`",
            );
        }
    }
}

fn are_modifiers(targets: &[Target], outputs: &[Output]) -> bool {
    let is_modifier = |target: &Target| {
        matches!(target, Target::Output(index)
            if matches!(outputs[*index], Output::Key(key) if key.is_modifier()))
    };
    !targets.is_empty() && targets.iter().all(is_modifier)
}
