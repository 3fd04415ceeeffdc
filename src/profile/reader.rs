//! Reads values out of entries: of the kind and in the range of their key, with variables put in. A wrong value is
//! reported and stands for its default, so that all mistakes are found in one pass.

use std::collections::BTreeMap;
use std::str::FromStr;

use super::diagnostics::Diagnostics;
use super::entries::{Data, Entries, Place, Text, Value};
use super::keys::{CountKey, FlagKey, Key, KeyKind, NumberKey, WordKey};
use crate::types::{GamepadPart, Nanos, Output, nanos_from_ms, nearest};

/// Collects mistakes, and the outputs, layers and gamepad parts that bindings name, each once.
pub(super) struct Reader {
    pub errors: Diagnostics,
    pub outputs: Vec<Output>,
    pub layers: Vec<String>,
    pub parts: Vec<GamepadPart>,
}

/// The place of an item in a list, to which it is added if it is new.
pub(super) fn index_of<T: PartialEq>(list: &mut Vec<T>, item: T) -> usize {
    let known = list.iter().position(|other| *other == item);
    known.unwrap_or_else(|| {
        list.push(item);
        list.len() - 1
    })
}

impl Reader {
    pub(super) fn new(layers: usize) -> Self {
        Self {
            errors: Diagnostics::new(layers),
            outputs: Vec::new(),
            layers: Vec::new(),
            parts: Vec::new(),
        }
    }

    /// Replaces each text that begins with `$` by the variable. Mistakes in its value are reported at the variable, once,
    /// however many places use it.
    pub(super) fn substitute(&mut self, vars: &BTreeMap<String, Value>, text: &mut Text) {
        for value in vars.values() {
            if matches!(value.data, Data::List(_) | Data::Other) {
                self.errors.push(
                    &value.place,
                    "a variable must be a number, a text, true or false",
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
                self.substitute_value(vars, value);
            }
        }
    }

    fn substitute_value(&mut self, vars: &BTreeMap<String, Value>, value: &mut Value) {
        match &mut value.data {
            Data::List(list) => {
                for value in list {
                    self.substitute_value(vars, value);
                }
            }
            Data::Text(text) => {
                let Some(name) = text.strip_prefix('$') else {
                    return;
                };
                if let Some(var) = vars.get(name) {
                    *value = var.clone();
                    return;
                }
                let help = match nearest(name, vars.keys().map(String::as_str)) {
                    Some(name) => format!("did you mean `${name}`?"),
                    None => format!("add `{name} = ...` under [vars]"),
                };
                let message = format!("unknown variable `${name}`");
                self.errors.help(&value.place, message, "not defined", help);
                value.data = Data::Other;
            }
            Data::Number(_) | Data::Flag(_) | Data::Other => {}
        }
    }

    /// A number in the range of its key.
    pub(super) fn number(&mut self, entries: &Entries, key: &Key) -> Option<f64> {
        let value = entries.get(key.name)?;
        let Data::Number(number) = value.data else {
            self.wrong_kind(value, key.name, "a number without quotes");
            return None;
        };
        if let KeyKind::Number(least, most, unit) = key.kind
            && !(least..=most).contains(&number)
        {
            let range = format!("{least} to {most} {unit}");
            self.out_of_range(value, key, number, range.trim());
            return None;
        }
        Some(number)
    }

    pub(super) fn number_or_default(&mut self, entries: &Entries, key: &NumberKey) -> f64 {
        self.number(entries, &key.key).unwrap_or(key.default)
    }

    pub(super) fn ms_or_default(&mut self, entries: &Entries, key: &NumberKey) -> Nanos {
        nanos_from_ms(self.number_or_default(entries, key))
    }

    /// A whole number in the range of its key.
    pub(super) fn count(&mut self, entries: &Entries, key: &Key) -> Option<u32> {
        let value = entries.get(key.name)?;
        let Data::Number(number) = value.data else {
            self.wrong_kind(value, key.name, "a whole number without quotes");
            return None;
        };
        if let KeyKind::Count(least, most) = key.kind {
            let is_whole = libm::trunc(number) == number;
            if is_whole && (f64::from(least)..=f64::from(most)).contains(&number) {
                return Some(number as u32);
            }
            let range = if least == most {
                least.to_string()
            } else {
                format!("a whole number from {least} to {most}")
            };
            self.out_of_range(value, key, number, &range);
        }
        None
    }

    pub(super) fn count_or_default(&mut self, entries: &Entries, key: &CountKey) -> u32 {
        self.count(entries, &key.key).unwrap_or(key.default)
    }

    fn out_of_range(&mut self, value: &Value, key: &Key, number: f64, range: &str) {
        self.errors.help(
            &value.place,
            format!(
                "`{}` = {number} is out of range: it must be {range}",
                key.name
            ),
            "out of range",
            format!("`{}`: {}", key.name, key.about),
        );
    }

    /// One of the words of a key.
    pub(super) fn word(&mut self, entries: &Entries, key: &Key) -> Option<&'static str> {
        let value = entries.get(key.name)?;
        let KeyKind::Word(words) = key.kind else {
            return None;
        };
        let name = key.name;
        let Data::Text(text) = &value.data else {
            let wanted = format!("a word in quotes: {}", words.join(", "));
            self.wrong_kind(value, name, &wanted);
            return None;
        };
        let found = words.iter().copied().find(|word| word == text);
        if found.is_none() {
            let help = match nearest(text, words.iter().copied()) {
                Some(word) => format!("did you mean `{word}`? `{name}`: {}", key.about),
                None => format!("`{name}` is one of {}", words.join(", ")),
            };
            let message = format!("unknown {name} `{text}`");
            self.errors.help(&value.place, message, "unknown", help);
        }
        found
    }

    /// The value of a word, if the key is there.
    pub(super) fn choice<T: Copy>(&mut self, entries: &Entries, key: &WordKey<T>) -> Option<T> {
        let word = self.word(entries, &key.key)?;
        let KeyKind::Word(words) = key.key.kind else {
            return None;
        };
        let index = words.iter().position(|other| *other == word)?;
        key.values.get(index).copied()
    }

    pub(super) fn choice_or_default<T: Copy>(&mut self, entries: &Entries, key: &WordKey<T>) -> T {
        self.choice(entries, key).unwrap_or(key.values[0])
    }

    /// One of the words of a key, parsed.
    pub(super) fn parsed<T: FromStr>(&mut self, entries: &Entries, key: &Key) -> Option<T> {
        self.word(entries, key).and_then(|word| word.parse().ok())
    }

    pub(super) fn flag(&mut self, entries: &Entries, key: &FlagKey) -> bool {
        match entries.get(key.key.name) {
            Some(Value {
                data: Data::Flag(flag),
                ..
            }) => *flag,
            Some(value) => {
                self.wrong_kind(value, key.key.name, "true or false without quotes");
                key.default
            }
            None => key.default,
        }
    }

    /// A text and its place.
    pub(super) fn text(&mut self, entries: &Entries, name: &str) -> Option<(String, Place)> {
        let value = entries.get(name)?;
        match &value.data {
            Data::Text(text) => Some((text.clone(), value.place.clone())),
            _ => {
                self.wrong_kind(value, name, "a text in quotes");
                None
            }
        }
    }

    /// Texts and their places; a single text counts as a list of one.
    pub(super) fn texts(&mut self, entries: &Entries, name: &str) -> Vec<(String, Place)> {
        let Some(value) = entries.get(name) else {
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
                _ => self.wrong_kind(value, name, "a text in quotes, or a list of them"),
            }
        }
        texts
    }

    /// Reports a value of the wrong kind, unless its variable was reported already.
    fn wrong_kind(&mut self, value: &Value, name: &str, wanted: &str) {
        let is = match &value.data {
            Data::Number(_) => "a number",
            Data::Text(_) => "a text",
            Data::Flag(_) => "true or false",
            Data::List(_) => "a list",
            Data::Other if self.errors.contains(&value.place) => return,
            Data::Other => "something else",
        };
        self.errors.push(
            &value.place,
            format!("`{name}` must be {wanted}, but this is {is}"),
            "wrong kind of value",
        );
    }

    /// Reports each key that a shape, gesture or mode does not take: `words` name it, `what` describes it. Each key comes
    /// with the words that it applies to; none for all.
    pub(super) fn refuse_foreign<'a>(
        &mut self,
        entries: &Entries,
        keys: impl Iterator<Item = (&'a Key, &'a [&'static str])>,
        words: &[&str],
        what: &str,
    ) {
        for (key, only) in keys {
            let applies = only.is_empty() || words.iter().any(|word| only.contains(word));
            if let Some(value) = entries.get(key.name)
                && !applies
            {
                let name = key.name;
                self.errors.help(
                    &value.place,
                    format!("`{name}` does not apply to {what}"),
                    "remove this",
                    format!("`{name}` applies to {}: {}", only.join(", "), key.about),
                );
            }
        }
    }
}
