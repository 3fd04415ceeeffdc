//! Reads one text into entries that keep their places. Reports what TOML forbids, unknown keys, and values where tables
//! should be; the checks read the values.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::entries::{Data, Entries, Place, Text, Value};
use super::key_list::{find_key, keys_of};
use super::keys::{SYNONYMS, Table};
use crate::types::{Diagnostic, nearest};

/// Deepest nesting of lists that is read: points are two deep.
const MAX_DEPTH: usize = 3;

/// Reads a profile ([`Table::Profile`]) or user settings ([`Table::User`]).
pub(super) fn read(toml: &str, layer: usize, kind: Table) -> (Text, Vec<Diagnostic>) {
    let (document, broken) = DeTable::parse_recoverable(toml);
    let mut parser = Parser {
        layer,
        errors: broken
            .iter()
            .map(|error| {
                let span = error.span().unwrap_or(0..0);
                Diagnostic::new(span, error.message().trim().replace('\n', ", "), "here")
            })
            .collect(),
    };
    // Recovery from broken lines would report them twice.
    let text = parser.document(document.get_ref(), kind);
    if !broken.is_empty() {
        parser.errors.truncate(broken.len());
    }
    (text, parser.errors)
}

struct Parser {
    layer: usize,
    errors: Vec<Diagnostic>,
}

impl Parser {
    fn document(&mut self, document: &DeTable<'_>, kind: Table) -> Text {
        let mut text = Text {
            top: self.empty(0..0),
            vars: BTreeMap::new(),
            matches: None,
            regions: Vec::new(),
            bindings: Vec::new(),
        };
        for (key, value) in document {
            match (key.get_ref().as_ref(), kind) {
                ("vars", _) => text.vars = self.vars(value),
                ("match", Table::Profile) => {
                    text.matches = self.table(value, Table::Match, "match")
                }
                ("region", Table::Profile) => {
                    text.regions = self.tables(value, Table::Region, "region")
                }
                ("binding", Table::Profile) => {
                    text.bindings = self.tables(value, Table::Binding, "binding")
                }
                (name, _) => {
                    if text.top.values.is_empty() {
                        text.top.place.span = key.span();
                    }
                    if let Some(value) = self.entry(key, value, kind) {
                        text.top.values.insert(name.to_owned(), value);
                    }
                }
            }
        }
        text
    }

    fn empty(&self, span: Range<usize>) -> Entries {
        Entries {
            place: self.place(span),
            values: BTreeMap::new(),
        }
    }

    fn place(&self, span: Range<usize>) -> Place {
        Place {
            layer: self.layer,
            span,
        }
    }

    fn vars(&mut self, value: &Spanned<DeValue<'_>>) -> BTreeMap<String, Value> {
        let DeValue::Table(table) = value.get_ref() else {
            self.errors.push(Diagnostic::new(
                value.span(),
                "`vars` must be a table",
                "write [vars] above its lines",
            ));
            return BTreeMap::new();
        };
        table
            .iter()
            .map(|(key, value)| (key.get_ref().clone().into_owned(), self.value(value, 0)))
            .collect()
    }

    fn table(&mut self, value: &Spanned<DeValue<'_>>, kind: Table, name: &str) -> Option<Entries> {
        let DeValue::Table(table) = value.get_ref() else {
            self.errors.push(Diagnostic::new(
                value.span(),
                format!("`{name}` must be a table"),
                format!("write [{name}] above its lines"),
            ));
            return None;
        };
        let mut entries = self.empty(value.span());
        for (key, value) in table {
            if let Some(value) = self.entry(key, value, kind) {
                entries
                    .values
                    .insert(key.get_ref().clone().into_owned(), value);
            }
        }
        Some(entries)
    }

    fn tables(&mut self, value: &Spanned<DeValue<'_>>, kind: Table, name: &str) -> Vec<Entries> {
        let DeValue::Array(array) = value.get_ref() else {
            self.errors.push(
                Diagnostic::new(
                    value.span(),
                    format!("`{name}` must be a list of tables"),
                    "a single one",
                )
                .help(format!("write [[{name}]] with two brackets above each")),
            );
            return Vec::new();
        };
        array
            .iter()
            .filter_map(|value| self.table(value, kind, name))
            .collect()
    }

    /// A value under a key that must be known.
    fn entry(
        &mut self,
        key: &Spanned<Cow<'_, str>>,
        value: &Spanned<DeValue<'_>>,
        kind: Table,
    ) -> Option<Value> {
        let name = key.get_ref().as_ref();
        if find_key(kind, name).is_some() {
            return Some(self.value(value, 0));
        }
        let tables: &[&str] = match kind {
            Table::Profile => &["vars", "match", "region", "binding"],
            _ => &[],
        };
        let names: Vec<&str> = keys_of(kind).map(|key| key.name).collect();
        let synonym = SYNONYMS
            .iter()
            .find(|(word, meant)| *word == name && names.contains(meant))
            .map(|(_, meant)| (*meant).to_owned());
        let known = names.iter().chain(tables).copied();
        let help = match synonym.or_else(|| nearest(name, known)) {
            Some(meant) => {
                let about = find_key(kind, &meant);
                let about = about.map_or(String::new(), |key| format!(" ({})", key.about));
                format!("did you mean `{meant}`?{about}")
            }
            None => format!("known keys: {}", names.join(", ")),
        };
        let message = format!("unknown key `{name}` {}", in_table(kind));
        let error = Diagnostic::new(key.span(), message, "unknown");
        self.errors.push(error.help(help));
        None
    }

    fn value(&self, value: &Spanned<DeValue<'_>>, depth: usize) -> Value {
        let data = match value.get_ref() {
            DeValue::String(text) => Data::Text(text.clone().into_owned()),
            DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix())
                .map_or(Data::Other, |integer| Data::Number(integer as f64)),
            DeValue::Float(float) => float.as_str().parse().map_or(Data::Other, Data::Number),
            DeValue::Boolean(flag) => Data::Flag(*flag),
            DeValue::Array(list) if depth < MAX_DEPTH => Data::List(
                list.iter()
                    .map(|value| self.value(value, depth + 1))
                    .collect(),
            ),
            DeValue::Array(_) | DeValue::Datetime(_) | DeValue::Table(_) => Data::Other,
        };
        Value {
            place: self.place(value.span()),
            data,
        }
    }
}

fn in_table(table: Table) -> &'static str {
    match table {
        Table::Profile | Table::Setting => "at the top of a profile",
        Table::User => "in user settings",
        Table::Region => "in a region",
        Table::Binding => "in a binding",
        Table::Match => "in [match]",
    }
}
