//! Merges texts: the bases that a profile extends, the profile, and user settings over all.
//!
//! A higher text overrides lower ones: top keys and variables by name, regions by name and key by key, bindings by
//! region, gesture, direction and layer, and key by key. Every value keeps the place where it was written.

use std::collections::{BTreeMap, VecDeque};

use super::entries::{Data, Entries, Text, Value};
use super::keys::Table;
use super::sources::{FindBase, Source};
use super::text;
use crate::types::{Diagnostic, SourceErrors};

/// Most profiles that extend each other below one.
pub const MAX_BASES: usize = 8;

/// All texts in one.
#[derive(Debug)]
pub(super) struct Layers {
    /// In the order base, profile, user: the layer of a place is an index into it.
    pub sources: Vec<Source>,
    pub merged: Text,
}

/// Reads and merges a profile, its bases and user settings.
pub(super) fn gather(
    profile: Source,
    user: Option<Source>,
    find: FindBase<'_>,
) -> Result<Layers, SourceErrors> {
    let mut chain = vec![profile];
    while let Some(base) = base_of(&chain, find)? {
        chain.push(base);
    }
    chain.reverse();
    let profiles = chain.len();
    chain.extend(user);
    let mut merged: Option<Text> = None;
    let mut errors = None;
    for (layer, source) in chain.iter().enumerate() {
        let kind = if layer < profiles {
            Table::Profile
        } else {
            Table::User
        };
        let (text, mistakes) = text::read(&source.toml, layer, kind);
        if !mistakes.is_empty() {
            // The topmost text is the one that is being edited.
            errors = Some(SourceErrors::new(&source.name, &source.toml, mistakes));
        }
        merged = Some(match merged {
            None => text,
            Some(base) => merge_texts(base, text),
        });
    }
    match (merged, errors) {
        (Some(merged), None) => Ok(Layers {
            sources: chain,
            merged,
        }),
        (_, Some(errors)) => Err(errors),
        (None, None) => unreachable!("the chain holds the profile"),
    }
}

/// The text that the last of a chain extends, if it extends one.
fn base_of(chain: &[Source], find: FindBase<'_>) -> Result<Option<Source>, SourceErrors> {
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
        let mistake = Diagnostic::new(extends.place.span.clone(), message, label).help(help);
        Err(SourceErrors::new(&last.name, &last.toml, vec![mistake]))
    };
    if chain.len() > MAX_BASES {
        return refuse(
            format!("more than {MAX_BASES} profiles extend each other"),
            "one too many",
            "extend a profile nearer to the first one",
        );
    }
    match find(name) {
        Ok(base) if chain.iter().any(|source| source.name == base.name) => refuse(
            format!("`{name}` extends itself, directly or through others"),
            "extends itself",
            "extend another profile, or none",
        ),
        Ok(base) => Ok(Some(base)),
        Err(message) => refuse(
            message,
            "not found",
            "write a shipped profile (`gelpad profile list` shows them) or the path of a file, such as ./base.toml",
        ),
    }
}

fn merge_texts(mut base: Text, upper: Text) -> Text {
    // Mistakes without a better place belong to the upper text.
    base.top.place = upper.top.place;
    base.top.values.extend(upper.top.values);
    base.vars.extend(upper.vars);
    if upper.matches.is_some() {
        base.matches = upper.matches;
    }
    merge_tables(&mut base.regions, upper.regions, region_key);
    merge_tables(&mut base.bindings, upper.bindings, binding_key);
    base
}

/// Tables with the same key override each other, the first the first, the second the second; others are added.
fn merge_tables(base: &mut Vec<Entries>, upper: Vec<Entries>, key: fn(&Entries) -> String) {
    let mut below: BTreeMap<String, VecDeque<usize>> = BTreeMap::new();
    for (index, entries) in base.iter().enumerate() {
        below.entry(key(entries)).or_default().push_back(index);
    }
    for entries in upper {
        let same = below.get_mut(&key(&entries)).and_then(VecDeque::pop_front);
        match same.and_then(|index| base.get_mut(index)) {
            Some(same) => {
                same.place = entries.place;
                same.values.extend(entries.values);
            }
            None => base.push(entries),
        }
    }
}

fn region_key(entries: &Entries) -> String {
    joined(entries.values.get("name"))
}

/// Region (or the parts that it is played from, without a region), gesture, direction and layer.
fn binding_key(entries: &Entries) -> String {
    let gesture = match joined(entries.values.get("gesture")) {
        none if none.is_empty() => "press".to_owned(),
        gesture => gesture,
    };
    let value = |key| joined(entries.values.get(key));
    let place = match value("region") {
        none if none.is_empty() => value("from"),
        region => region,
    };
    format!(
        "{place}/{gesture}/{}/{}",
        value("direction"),
        value("layer")
    )
}

fn joined(value: Option<&Value>) -> String {
    match value.map(|value| &value.data) {
        Some(Data::Text(text)) => text.clone(),
        Some(Data::List(list)) => {
            let mut all: Vec<String> = list.iter().map(|value| joined(Some(value))).collect();
            all.sort();
            all.join("+")
        }
        _ => String::new(),
    }
}
