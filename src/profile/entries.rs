//! The values of a text, each with the place where it was written.

use std::collections::BTreeMap;
use std::ops::Range;

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

/// The keys of one table.
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

impl Entries {
    pub(super) fn get(&self, key: &str) -> Option<&Value> {
        self.values.get(key)
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.values.contains_key(key)
    }

    /// The place of a key's value, else of the whole table.
    pub(super) fn place_of(&self, key: &str) -> &Place {
        self.get(key).map_or(&self.place, |value| &value.place)
    }
}
