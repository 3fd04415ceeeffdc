//! The top of a profile: its name, its base, and what selects it.

use crate::profile::entries::{Data, Entries, Place, Text, Value};
use crate::profile::keys::{Key, KeyKind, Table, define_keys};
use crate::profile::reader::Reader;
use crate::profile::{Origin, Source};

define_keys! {
    SCHEMA: Key = Key::new("schema", Table::Profile, KeyKind::Count(1, 1), "version of the format");
    pub(in crate::profile) METHOD: Key = Key::new("method", Table::Profile, KeyKind::Word(&["tikhonov", "noser", "smooth", "l1"]), "reconstruction method").or("the pad's");
}
pub(in crate::profile) const KEYS: &[Key] = &[
    SCHEMA,
    Key::new("name", Table::Profile, KeyKind::Text, "the profile's name"),
    Key::new(
        "about",
        Table::Profile,
        KeyKind::Text,
        "one sentence for lists",
    ),
    Key::new(
        "extends",
        Table::Profile,
        KeyKind::Text,
        "a shipped profile or a file whose keys hold where this text has none",
    ),
    METHOD,
];
define_keys! {
    pub(in crate::profile) PROCESS: Key = Key::new("process", Table::Match, KeyKind::Texts, "names of processes: while one runs, `play --match` plays this profile");
}

impl Reader {
    /// The name of the profile, and whether the format is known.
    pub(super) fn name(&mut self, top: &Entries) -> String {
        if !top.has("schema") {
            self.errors.help(
                &top.place,
                "the profile has no `schema`",
                "in this text",
                "write `schema = 1` at its top",
            );
        }
        let _ = self.count(top, &SCHEMA);
        let name = self.text(top, "name");
        if name.is_none() {
            self.errors.help(
                &top.place,
                "the profile has no `name`",
                "in this text",
                "write `name = \"mine\"` at its top",
            );
        }
        name.map_or(String::new(), |(name, _)| name)
    }

    /// Reports a profile without any binding.
    pub(super) fn refuse_empty(&mut self, text: &Text) {
        if text.bindings.is_empty() {
            self.errors.help(
                &text.top.place,
                "the profile has no bindings: no touch would do anything",
                "in this text",
                "add a [[region]] and a [[binding]]; `gelpad profile show --toml` prints a profile to copy",
            );
        }
    }
}

/// Where each value at the top, each region and each binding was last written.
pub(super) fn origins(text: &Text, sources: &[Source]) -> Vec<Origin> {
    let from = |place: &Place| sources[place.layer].name.clone();
    let tops = text.top.values.iter().map(|(key, value)| Origin {
        key: key.clone(),
        value: written(value),
        from: from(&value.place),
    });
    let table = |kind: &str, entries: &Entries| {
        let names = ["name", "region", "from"];
        let name = names.iter().find_map(|key| entries.get(key));
        Origin {
            key: format!("{kind} {}", name.map_or(String::new(), written)),
            value: String::new(),
            from: from(&entries.place),
        }
    };
    tops.chain(text.regions.iter().map(|entries| table("region", entries)))
        .chain(
            text.bindings
                .iter()
                .map(|entries| table("binding", entries)),
        )
        .collect()
}

fn written(value: &Value) -> String {
    match &value.data {
        Data::Number(number) => number.to_string(),
        Data::Text(text) => text.clone(),
        Data::Flag(flag) => flag.to_string(),
        Data::List(list) => list.iter().map(written).collect::<Vec<_>>().join(", "),
        Data::Other => String::new(),
    }
}
