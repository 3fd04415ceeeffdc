//! One text, read into entries that remember their places. Finds what TOML forbids, keys that do not exist, and
//! tables where values should be; what the values mean is for the checks.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::keys::{self, SYNONYMS, Table};
use crate::types::{Fault, nearest};

/// Deepest list in a list that is looked at: points are two deep.
const DEEPEST: usize = 3;

/// Where a value stands: which text, which bytes.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub layer: usize,
    pub span: Range<usize>,
}

/// A value as written.
#[derive(Clone, Debug)]
pub(super) struct Value {
    pub place: Place,
    pub data: Data,
}

#[derive(Clone, Debug)]
pub(super) enum Data {
    Number(f64),
    Text(String),
    Flag(bool),
    List(Vec<Value>),
    /// A date, or a table where none belongs.
    Other,
}

/// The keys of one table of the text.
#[derive(Clone, Debug)]
pub(super) struct Entries {
    /// The table's head.
    pub place: Place,
    pub values: BTreeMap<String, Value>,
}

/// A whole text.
#[derive(Clone, Debug)]
pub(super) struct Text {
    pub top: Entries,
    pub vars: BTreeMap<String, Value>,
    pub matches: Option<Entries>,
    pub regions: Vec<Entries>,
    pub bindings: Vec<Entries>,
}

/// Reads a text that is a profile ([`Table::Profile`]) or about a person ([`Table::User`]).
pub(super) fn read(toml: &str, layer: usize, kind: Table) -> (Text, Vec<Fault>) {
    let (document, errors) = DeTable::parse_recoverable(toml);
    let mut reader = Reader {
        layer,
        faults: errors
            .iter()
            .map(|error| {
                let span = error.span().unwrap_or(0..0);
                Fault::new(span, error.message().trim().replace('\n', ", "), "here")
            })
            .collect(),
    };
    // What recovery made of broken lines would be told twice.
    let broken = !reader.faults.is_empty();
    let text = reader.document(document.get_ref(), kind);
    if broken {
        reader.faults.truncate(errors.len());
    }
    (text, reader.faults)
}

struct Reader {
    layer: usize,
    faults: Vec<Fault>,
}

impl Reader {
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
            self.faults.push(Fault::new(
                value.span(),
                "`vars` is a table",
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
            self.faults.push(Fault::new(
                value.span(),
                format!("`{name}` is a table"),
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
            self.faults.push(
                Fault::new(
                    value.span(),
                    format!("`{name}` is a list of tables"),
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
        if keys::find(kind, name).is_some() {
            return Some(self.value(value, 0));
        }
        let tables: &[&str] = match kind {
            Table::Profile => &["vars", "match", "region", "binding"],
            _ => &[],
        };
        let known = keys::of(kind)
            .map(|key| key.name)
            .chain(tables.iter().copied());
        let meant = SYNONYMS
            .iter()
            .find(|(said, term)| *said == name && keys::find(kind, term).is_some())
            .map(|(_, term)| (*term).to_owned())
            .or_else(|| nearest(name, known));
        let fault = Fault::new(
            key.span(),
            format!("no key is named `{name}` {}", of_table(kind)),
            "not known",
        );
        self.faults.push(match meant {
            Some(term) => {
                let about = keys::find(kind, &term)
                    .map_or(String::new(), |key| format!(" ({})", key.about));
                fault.help(format!("did you mean `{term}`?{about}"))
            }
            None => {
                let names: Vec<&str> = keys::of(kind).map(|key| key.name).collect();
                fault.help(format!("known are {}", names.join(", ")))
            }
        });
        None
    }

    fn value(&self, value: &Spanned<DeValue<'_>>, depth: usize) -> Value {
        let data = match value.get_ref() {
            DeValue::String(text) => Data::Text(text.clone().into_owned()),
            DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix())
                .map_or(Data::Other, |integer| Data::Number(integer as f64)),
            DeValue::Float(float) => float.as_str().parse().map_or(Data::Other, Data::Number),
            DeValue::Boolean(flag) => Data::Flag(*flag),
            DeValue::Array(list) if depth < DEEPEST => Data::List(
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

/// "in a region", for messages.
fn of_table(table: Table) -> &'static str {
    match table {
        Table::Profile | Table::Setting => "in a profile",
        Table::User => "about a person",
        Table::Region => "of a region",
        Table::Binding => "of a binding",
        Table::Match => "of [match]",
    }
}
