//! Merged texts to a profile: every value is of its kind and in its range, every name names something.

mod binding;
mod gesture;
mod macros;
mod part;
mod region;
mod settings;
mod target;
mod value;

use super::layers::{self, Layers, Source, Texts};
use super::text::{Data, Entries, Place, Value};
use super::{Checked, FindBase, Origin, Profile, warn};
use crate::types::{Fault, Faulty, Method};

pub(super) fn read(
    profile: Source,
    user: Option<Source>,
    find: FindBase<'_>,
) -> Result<Checked, Faulty> {
    let has_user = user.is_some();
    let Layers {
        sources,
        mut merged,
    } = layers::gather(profile, user, find)?;
    let mut check = Check::new(sources.len());
    let vars = std::mem::take(&mut merged.vars);
    check.substitute(&vars, &mut merged);
    let mut profile = check.profile(&merged, &sources);
    if let Some(faulty) = check.faults.worst(&sources) {
        return Err(faulty);
    }
    let mut warnings = check.warnings;
    warn::profile(&profile, &merged, &check.binding_places, &mut warnings);
    let warnings = warnings.each(&sources);
    let texts = sources.iter().map(|source| source.name.clone()).collect();
    let mut chain = sources;
    let user = if has_user { chain.pop() } else { None };
    profile.texts = Texts { chain, user };
    Ok(Checked {
        profile,
        warnings,
        texts,
    })
}

/// Faults by the text in which they stand.
#[derive(Debug)]
pub(super) struct Faults(Vec<Vec<Fault>>);

impl Faults {
    pub(super) fn push(&mut self, place: &Place, message: impl Into<String>, label: &str) {
        self.add(place.layer, Fault::new(place.span.clone(), message, label));
    }

    pub(super) fn help(
        &mut self,
        place: &Place,
        message: impl Into<String>,
        label: &str,
        help: impl Into<String>,
    ) {
        self.add(
            place.layer,
            Fault::new(place.span.clone(), message, label).help(help),
        );
    }

    pub(super) fn add(&mut self, layer: usize, fault: Fault) {
        // A value that two places use is wrong once.
        if !self.0[layer].contains(&fault) {
            self.0[layer].push(fault);
        }
    }

    /// Those of the topmost text that has any: it is the one that is being edited.
    fn worst(&mut self, sources: &[Source]) -> Option<Faulty> {
        let layer = self.0.iter().rposition(|faults| !faults.is_empty())?;
        let source = &sources[layer];
        Some(Faulty::new(
            &source.name,
            &source.toml,
            std::mem::take(&mut self.0[layer]),
        ))
    }

    fn each(self, sources: &[Source]) -> Vec<Faulty> {
        sources
            .iter()
            .zip(self.0)
            .filter(|(_, faults)| !faults.is_empty())
            .map(|(source, faults)| Faulty::new(&source.name, &source.toml, faults))
            .collect()
    }
}

/// Gathers faults; where a value is wrong it goes on with a stand-in.
pub(super) struct Check {
    faults: Faults,
    warnings: Faults,
    /// Where each binding of the profile was written.
    binding_places: Vec<Place>,
}

impl Check {
    fn new(layers: usize) -> Self {
        let none = || Faults(vec![Vec::new(); layers]);
        Self {
            faults: none(),
            warnings: none(),
            binding_places: Vec::new(),
        }
    }

    fn profile(&mut self, text: &super::text::Text, sources: &[Source]) -> Profile {
        let top = &text.top;
        if !top.values.contains_key("schema") {
            self.faults.help(
                &top.place,
                "the profile does not say its `schema`",
                "in this text",
                "write `schema = 1` at its top",
            );
        }
        let _ = self.count(top, "schema", super::Table::Profile);
        let name = match self.text(top, "name") {
            Some((name, _)) => name,
            None => {
                self.faults.help(
                    &top.place,
                    "the profile has no `name`",
                    "in this text",
                    "write `name = \"mine\"` at its top",
                );
                String::new()
            }
        };
        let settings = self.settings(top);
        let regions = self.regions(&text.regions);
        let mut profile = Profile {
            name,
            about: self
                .text(top, "about")
                .map_or(String::new(), |(about, _)| about),
            method: self.word::<Method>(top, "method", super::Table::Profile),
            settings,
            regions,
            parts: Vec::new(),
            outputs: Vec::new(),
            layers: self.layers(&text.bindings),
            bindings: Vec::new(),
            processes: text
                .matches
                .as_ref()
                .map_or(Vec::new(), |matches| self.texts(matches, "process")),
            origins: origins(text, sources),
            texts: Texts::default(),
        };
        self.bindings(text, &mut profile);
        if profile.bindings.is_empty() && text.bindings.is_empty() {
            self.faults.help(
                &top.place,
                "the profile binds nothing: no touch would do anything",
                "in this text",
                "add a [[region]] and a [[binding]]; `gelpad profile show --toml` prints one to copy",
            );
        }
        profile
    }
}

/// Where each value at the top, each region and each binding was last written.
fn origins(text: &super::text::Text, sources: &[Source]) -> Vec<Origin> {
    let from = |place: &Place| sources[place.layer].name.clone();
    let tops = text.top.values.iter().map(|(key, value)| Origin {
        key: key.clone(),
        value: written(value),
        from: from(&value.place),
    });
    let named = |kind: &str, entries: &Entries| {
        let name = entries
            .values
            .get("name")
            .or_else(|| entries.values.get("region"))
            .or_else(|| entries.values.get("from"));
        Origin {
            key: format!("{kind} {}", name.map_or(String::new(), written)),
            value: String::new(),
            from: from(&entries.place),
        }
    };
    tops.chain(text.regions.iter().map(|entries| named("region", entries)))
        .chain(
            text.bindings
                .iter()
                .map(|entries| named("binding", entries)),
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
