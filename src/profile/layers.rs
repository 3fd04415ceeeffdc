//! Texts over texts: the bases that a profile extends, the profile, and a person's settings over all.
//!
//! What a higher text says holds: top keys and variables by name, regions by name and key by key, bindings by what they
//! bind and key by key. Every value keeps the place where it was written.

use std::collections::BTreeMap;

use super::FindBase;
use super::keys::Table;
use super::text::{self, Data, Entries, Text, Value};
use crate::types::{Fault, Faulty};

/// A profile stands on so many others at most.
pub const MOST_BASES: usize = 8;

/// The texts that a profile was read from: what makes it anew, wherever they are by then.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Texts {
    /// The bases that it extends, the lowest first, and last its own.
    pub chain: Vec<Source>,
    /// One person's settings over it.
    pub user: Option<Source>,
}

/// A text and the name that messages give it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The file's name, or what stands for it.
    pub name: String,
    /// The text.
    pub toml: String,
}

/// All texts in one.
#[derive(Debug)]
pub(super) struct Layers {
    /// In the order base, profile, user: a place's layer counts in it.
    pub sources: Vec<Source>,
    pub merged: Text,
}

/// Reads a profile, its bases and what lies over it, and merges them.
pub(super) fn gather(
    profile: Source,
    user: Option<Source>,
    find: FindBase<'_>,
) -> Result<Layers, Faulty> {
    let mut chain = vec![profile];
    while let Some(base) = base_of(&chain, find)? {
        chain.push(base);
    }
    chain.reverse();
    let profiles = chain.len();
    chain.extend(user);
    let mut merged: Option<Text> = None;
    let mut faulty = None;
    for (layer, source) in chain.iter().enumerate() {
        let kind = if layer < profiles {
            Table::Profile
        } else {
            Table::User
        };
        let (text, faults) = text::read(&source.toml, layer, kind);
        if !faults.is_empty() {
            // The topmost text is the one that is being edited.
            faulty = Some(Faulty::new(&source.name, &source.toml, faults));
        }
        merged = Some(match merged {
            None => text,
            Some(base) => over(base, text),
        });
    }
    match (merged, faulty) {
        (Some(merged), None) => Ok(Layers {
            sources: chain,
            merged,
        }),
        (_, Some(faulty)) => Err(faulty),
        (None, None) => unreachable!("the chain holds the profile"),
    }
}

/// The text that the last of a chain extends, if it extends one.
fn base_of(chain: &[Source], find: FindBase<'_>) -> Result<Option<Source>, Faulty> {
    let Some(last) = chain.last() else {
        return Ok(None);
    };
    let (text, _) = text::read(&last.toml, 0, Table::Profile);
    let Some(extends) = text.top.values.get("extends") else {
        return Ok(None);
    };
    let Data::Text(name) = &extends.data else {
        return Ok(None);
    };
    let refuse = |message: String, label: &str, help: &str| {
        let fault = Fault::new(extends.place.span.clone(), message, label).help(help);
        Err(Faulty::new(&last.name, &last.toml, vec![fault]))
    };
    if chain.len() > MOST_BASES {
        return refuse(
            format!("more than {MOST_BASES} profiles extend each other"),
            "one too many",
            "let it extend a profile further down",
        );
    }
    match find(name) {
        Ok(base) if chain.iter().any(|source| source.name == base.name) => refuse(
            format!("`{name}` extends itself, by way of others or at once"),
            "closes the circle",
            "let it extend another profile, or none",
        ),
        Ok(base) => Ok(Some(base)),
        Err(message) => refuse(
            message,
            "not found",
            "`gelpad profile list` tells the shipped names; a file is named by a path such as ./base.toml",
        ),
    }
}

fn over(mut base: Text, upper: Text) -> Text {
    // The place of the top table is that of the upper text: a fault without a better place belongs there.
    base.top.place = upper.top.place;
    base.top.values.extend(upper.top.values);
    base.vars.extend(upper.vars);
    if upper.matches.is_some() {
        base.matches = upper.matches;
    }
    merge(&mut base.regions, upper.regions, region_key);
    merge(&mut base.bindings, upper.bindings, binding_key);
    base
}

/// Entries with the same key replace each other's values, first with first, second with second; others are added.
fn merge(base: &mut Vec<Entries>, upper: Vec<Entries>, key: fn(&Entries) -> String) {
    let below = base.len();
    let mut met: BTreeMap<String, usize> = BTreeMap::new();
    for entries in upper {
        let own = key(&entries);
        let nth = met.entry(own.clone()).or_insert(0);
        let same = base[..below]
            .iter_mut()
            .filter(|entries| key(entries) == own)
            .nth(*nth);
        *nth += 1;
        match same {
            Some(same) => {
                same.place = entries.place;
                same.values.extend(entries.values);
            }
            None => base.push(entries),
        }
    }
}

fn region_key(entries: &Entries) -> String {
    words(entries.values.get("name"))
}

/// What a binding binds: region (or what it is played from, where it has none), gesture, direction and layer.
fn binding_key(entries: &Entries) -> String {
    let gesture = match words(entries.values.get("gesture")) {
        none if none.is_empty() => "press".to_owned(),
        gesture => gesture,
    };
    let word = |key| words(entries.values.get(key));
    let place = match word("region") {
        none if none.is_empty() => word("from"),
        region => region,
    };
    format!("{place}/{gesture}/{}/{}", word("direction"), word("layer"))
}

fn words(value: Option<&Value>) -> String {
    match value.map(|value| &value.data) {
        Some(Data::Text(text)) => text.clone(),
        Some(Data::List(list)) => {
            let mut all: Vec<String> = list.iter().map(|value| words(Some(value))).collect();
            all.sort();
            all.join("+")
        }
        _ => String::new(),
    }
}
