//! Values out of entries: of the kind and in the range that `keys.rs` gives, variables put in.

use std::collections::BTreeMap;
use std::str::FromStr;

use super::Check;
use crate::profile::keys::{self, Kind, Table};
use crate::profile::text::{Data, Entries, Place, Text, Value};
use crate::types::{Nanos, nanos_from_ms, nearest};

impl Check {
    /// Puts variables in wherever a text begins with `$`.
    pub(super) fn substitute(&mut self, vars: &BTreeMap<String, Value>, text: &mut Text) {
        for value in vars.values() {
            if matches!(value.data, Data::List(_) | Data::Other) {
                self.faults.push(
                    &value.place,
                    "a variable is a number, a text, true or false",
                    "none of these",
                );
            }
        }
        let tables = std::iter::once(&mut text.top)
            .chain(&mut text.matches)
            .chain(&mut text.regions)
            .chain(&mut text.bindings);
        for entries in tables {
            for value in entries.values.values_mut() {
                self.put_in(vars, value);
            }
        }
    }

    fn put_in(&mut self, vars: &BTreeMap<String, Value>, value: &mut Value) {
        match &mut value.data {
            Data::List(list) => {
                for value in list {
                    self.put_in(vars, value);
                }
            }
            Data::Text(text) => {
                let Some(name) = text.strip_prefix('$') else {
                    return;
                };
                if let Some(var) = vars.get(name) {
                    value.data = var.data.clone();
                    return;
                }
                let help = match nearest(name, vars.keys().map(String::as_str)) {
                    Some(name) => format!("did you mean `${name}`?"),
                    None => format!("write `{name} = ...` under [vars]"),
                };
                self.faults.help(
                    &value.place,
                    format!("no variable is named `{name}`"),
                    "not known",
                    help,
                );
                value.data = Data::Other;
            }
            Data::Number(_) | Data::Flag(_) | Data::Other => {}
        }
    }

    /// A number in the range of its key.
    pub(super) fn number(&mut self, entries: &Entries, name: &str, table: Table) -> Option<f64> {
        let value = entries.values.get(name)?;
        let Data::Number(number) = value.data else {
            self.wrong(value, name, "a number, without quotes");
            return None;
        };
        let key = keys::find(table, name)?;
        if let Kind::Number(least, most, unit) = key.kind
            && !(least..=most).contains(&number)
        {
            let unit = if unit.is_empty() {
                String::new()
            } else {
                format!(" {unit}")
            };
            self.faults.help(
                &value.place,
                format!("`{name}` = {number}{unit} is out of its range: {least} to {most}{unit}"),
                "here",
                format!("`{name}`: {}", key.about),
            );
            return None;
        }
        Some(number)
    }

    /// A time in the range of its key.
    pub(super) fn time(&mut self, entries: &Entries, name: &str, table: Table) -> Option<Nanos> {
        self.number(entries, name, table).map(nanos_from_ms)
    }

    /// A whole number in the range of its key.
    pub(super) fn count(&mut self, entries: &Entries, name: &str, table: Table) -> Option<u32> {
        let value = entries.values.get(name)?;
        let Data::Number(number) = value.data else {
            self.wrong(value, name, "a whole number, without quotes");
            return None;
        };
        let key = keys::find(table, name)?;
        if let Kind::Count(least, most) = key.kind {
            if libm::trunc(number) == number
                && (f64::from(least)..=f64::from(most)).contains(&number)
            {
                return Some(number as u32);
            }
            let range = if least == most {
                format!("{least}")
            } else {
                format!("a whole number, {least} to {most}")
            };
            self.faults.help(
                &value.place,
                format!("`{name}` = {number} is not known: it is {range}"),
                "here",
                format!("`{name}`: {}", key.about),
            );
        }
        None
    }

    /// One of the words of a key.
    pub(super) fn choice(
        &mut self,
        entries: &Entries,
        name: &str,
        table: Table,
    ) -> Option<&'static str> {
        let value = entries.values.get(name)?;
        let key = keys::find(table, name)?;
        let Kind::Word(words) = key.kind else {
            return None;
        };
        let Data::Text(text) = &value.data else {
            self.wrong(
                value,
                name,
                &format!("a word in quotes: {}", words.join(", ")),
            );
            return None;
        };
        let found = words.iter().copied().find(|word| word == text);
        if found.is_none() {
            let help = match nearest(text, words.iter().copied()) {
                Some(word) => format!("did you mean `{word}`? `{name}`: {}", key.about),
                None => format!("`{name}` is one of {}", words.join(", ")),
            };
            self.faults.help(
                &value.place,
                format!("`{text}` is no {name}"),
                "not known",
                help,
            );
        }
        found
    }

    /// One of the words of a key, as what it stands for.
    pub(super) fn word<T: FromStr>(
        &mut self,
        entries: &Entries,
        name: &str,
        table: Table,
    ) -> Option<T> {
        self.choice(entries, name, table)
            .and_then(|word| word.parse().ok())
    }

    pub(super) fn flag(&mut self, entries: &Entries, name: &str) -> Option<bool> {
        let value = entries.values.get(name)?;
        match value.data {
            Data::Flag(flag) => Some(flag),
            _ => {
                self.wrong(value, name, "true or false, without quotes");
                None
            }
        }
    }

    /// A text and where it stands.
    pub(super) fn text(&mut self, entries: &Entries, name: &str) -> Option<(String, Place)> {
        let value = entries.values.get(name)?;
        match &value.data {
            Data::Text(text) => Some((text.clone(), value.place.clone())),
            _ => {
                self.wrong(value, name, "a text in quotes");
                None
            }
        }
    }

    /// Texts and where they stand; a single one stands for a list of one.
    pub(super) fn placed_texts(&mut self, entries: &Entries, name: &str) -> Vec<(String, Place)> {
        let Some(value) = entries.values.get(name) else {
            return Vec::new();
        };
        let list = match &value.data {
            Data::List(list) => list.as_slice(),
            _ => std::slice::from_ref(value),
        };
        let mut texts = Vec::new();
        for value in list {
            match &value.data {
                Data::Text(text) => texts.push((text.clone(), value.place.clone())),
                _ => self.wrong(value, name, "a text in quotes, or a list of them"),
            }
        }
        texts
    }

    pub(super) fn texts(&mut self, entries: &Entries, name: &str) -> Vec<String> {
        let texts = self.placed_texts(entries, name);
        texts.into_iter().map(|(text, _)| text).collect()
    }

    /// Says what a value should be; what substitution refused has been said.
    fn wrong(&mut self, value: &Value, name: &str, wanted: &str) {
        let is = match &value.data {
            Data::Number(_) => "a number",
            Data::Text(_) => "a text",
            Data::Flag(_) => "true or false",
            Data::List(_) => "a list",
            Data::Other if self.faults.is_told(&value.place) => return,
            Data::Other => "neither",
        };
        self.faults.push(
            &value.place,
            format!("`{name}` is {wanted}, and this is {is}"),
            "here",
        );
    }
}

impl super::Faults {
    /// Whether something was said about this very place.
    fn is_told(&self, place: &Place) -> bool {
        self.0[place.layer]
            .iter()
            .any(|fault| fault.span == place.span)
    }
}
