//! A profile's text under edit: one value changes at a time, comments and order stay, every change can be undone.
//!
//! Invariant: [`Document::text`] is valid TOML that differs from the file only in the values that were set.

use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, Value, value};

/// Changes that can be undone.
const MAX_UNDO: usize = 200;
/// Fractions of the pad are written in thousandths.
const STEPS_PER_PAD: f64 = 1000.0;

/// Why a text cannot be edited.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EditError {
    /// Not valid TOML.
    #[error("not valid TOML: {0}")]
    Syntax(String),
    /// A key holds something else than a list of tables.
    #[error("`{0}` is not a list of tables: write [[{0}]] above each")]
    NotAList(&'static str),
}

/// A text under edit.
#[derive(Clone, Debug)]
pub struct Document {
    pub(super) document: DocumentMut,
    undo: Vec<String>,
    redo: Vec<String>,
    /// The change that goes on, such as a slider's drag: one step to undo.
    current_change: Option<String>,
}

impl Document {
    /// Parses a text.
    ///
    /// # Errors
    /// It is not valid TOML.
    pub fn parse(text: &str) -> Result<Self, EditError> {
        let document = text
            .parse::<DocumentMut>()
            .map_err(|error| EditError::Syntax(error.message().to_owned()))?;
        Ok(Self {
            document,
            undo: Vec::new(),
            redo: Vec::new(),
            current_change: None,
        })
    }

    /// The edited text.
    #[must_use]
    pub fn text(&self) -> String {
        self.document.to_string()
    }

    /// Sets numbers of a region: `x`, `y`, `w`, `h` or `r`. A region that the base profile defines is added here.
    ///
    /// # Errors
    /// `region` is not a list of tables.
    pub fn set_region(&mut self, region: &str, numbers: &[(&str, f64)]) -> Result<(), EditError> {
        self.record_undo(&format!("region {region}"));
        let table = self.region_table(region)?;
        for (key, number) in numbers {
            set_number(table, key, rounded(*number));
        }
        Ok(())
    }

    /// Sets a number at the top level, such as `min_hold_ms`.
    pub fn set_number(&mut self, key: &str, number: f64) {
        self.record_undo(key);
        let top_level = self.document.as_table_mut();
        if top_level.contains_key(key) {
            set_number(top_level, key, number);
        } else {
            // Inserted below the last top-level key, before the first table.
            top_level.insert(key, number_item(number));
        }
    }

    /// Sets a switch at the top level, such as `sticky_keys`.
    pub fn set_flag(&mut self, key: &str, flag: bool) {
        self.record_undo(key);
        set_value(self.document.as_table_mut(), key, Value::from(flag));
    }

    /// Gives the profile another name, which no undo takes back.
    pub fn rename(&mut self, name: &str) {
        self.current_change = None;
        let set = |document: &mut DocumentMut| {
            set_value(document.as_table_mut(), "name", Value::from(name));
        };
        set(&mut self.document);
        for text in self.undo.iter_mut().chain(&mut self.redo) {
            if let Ok(mut document) = text.parse() {
                set(&mut document);
                *text = document.to_string();
            }
        }
    }

    /// Adds a rectangular region.
    ///
    /// # Errors
    /// `region` is not a list of tables.
    pub fn add_region(&mut self, name: &str, [x, y, w, h]: [f64; 4]) -> Result<(), EditError> {
        self.record_undo(&format!("add {name}"));
        let mut table = Table::new();
        table.insert("name", value(name));
        table.insert("shape", value("rect"));
        for (key, number) in [("x", x), ("y", y), ("w", w), ("h", h)] {
            table.insert(key, number_item(rounded(number)));
        }
        self.array_of_tables("region")?.push(table);
        Ok(())
    }

    /// Ends a change made of many steps, such as a drag: the next change is undone separately.
    pub fn end_change(&mut self) {
        self.current_change = None;
    }

    /// Whether a change can be undone.
    #[must_use]
    pub fn can_undo(&self) -> bool {
        !self.undo.is_empty()
    }

    /// Whether an undone change can be redone.
    #[must_use]
    pub fn can_redo(&self) -> bool {
        !self.redo.is_empty()
    }

    /// Undoes the last change.
    pub fn undo(&mut self) {
        if let Some(text) = self.undo.pop() {
            self.redo.push(self.text());
            self.restore(&text);
        }
    }

    /// Redoes the change undone last.
    pub fn redo(&mut self) {
        if let Some(text) = self.redo.pop() {
            self.undo.push(self.text());
            self.restore(&text);
        }
    }

    fn restore(&mut self, text: &str) {
        self.current_change = None;
        if let Ok(document) = text.parse() {
            self.document = document;
        }
    }

    /// Remembers the text before a change, unless the same change goes on.
    pub(super) fn record_undo(&mut self, change: &str) {
        if self.current_change.as_deref() == Some(change) {
            return;
        }
        self.current_change = Some(change.to_owned());
        self.undo.push(self.text());
        if self.undo.len() > MAX_UNDO {
            self.undo.remove(0);
        }
        self.redo.clear();
    }

    pub(super) fn array_of_tables(
        &mut self,
        list: &'static str,
    ) -> Result<&mut ArrayOfTables, EditError> {
        self.document
            .entry(list)
            .or_insert(Item::ArrayOfTables(ArrayOfTables::new()))
            .as_array_of_tables_mut()
            .ok_or(EditError::NotAList(list))
    }

    /// The table of a region; added if the text has none.
    fn region_table(&mut self, region: &str) -> Result<&mut Table, EditError> {
        const LIST: &str = "region";
        let tables = self.array_of_tables(LIST)?;
        let has_name = |table: &Table| table.get("name").and_then(Item::as_str) == Some(region);
        let index = tables.iter().position(has_name).unwrap_or(tables.len());
        if index == tables.len() {
            let mut table = Table::new();
            table.insert("name", value(region));
            tables.push(table);
        }
        tables.get_mut(index).ok_or(EditError::NotAList(LIST))
    }
}

/// In the steps in which fractions of the pad are written.
pub(super) fn rounded(fraction: f64) -> f64 {
    (fraction * STEPS_PER_PAD).round() / STEPS_PER_PAD
}

/// A number without a decimal point if it is whole.
pub(super) fn number_item(number: f64) -> Item {
    value(number_value(number, false))
}

pub(super) fn number_value(number: f64, as_float: bool) -> Value {
    const WHOLE: f64 = 1e15;
    if number.fract() == 0.0 && number.abs() < WHOLE && !as_float {
        Value::from(number as i64)
    } else {
        Value::from(number)
    }
}

/// Sets a number; one written with a decimal point keeps it.
fn set_number(table: &mut Table, key: &str, number: f64) {
    let old = table.get(key);
    let is_float = old.is_some_and(Item::is_float);
    let old = old.and_then(|item| {
        let integer = || item.as_integer().map(|integer| integer as f64);
        item.as_float().or_else(integer)
    });
    if old != Some(number) {
        set_value(table, key, number_value(number, is_float));
    }
}

/// Sets a value and keeps the spaces and the comment around it.
pub(super) fn set_value(table: &mut Table, key: &str, mut new: Value) {
    if let Some(old) = table.get(key).and_then(Item::as_value) {
        *new.decor_mut() = old.decor().clone();
    }
    table[key] = Item::Value(new);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{Profile, SHIPPED_PROFILES, shipped_profile};

    fn mario() -> Document {
        Document::parse(shipped_profile("super-mario").expect("shipped").toml).expect("valid")
    }

    /// The lines that differ, old and new.
    fn changed(before: &str, after: &str) -> Vec<(String, String)> {
        assert_eq!(before.lines().count(), after.lines().count());
        before
            .lines()
            .zip(after.lines())
            .filter(|(a, b)| a != b)
            .map(|(a, b)| (a.to_owned(), b.to_owned()))
            .collect()
    }

    #[test]
    fn moving_a_region_changes_only_its_numbers() {
        let mut document = mario();
        let before = document.text();
        document
            .set_region("jump", &[("x", 0.6), ("y", 0.20), ("w", 0.38)])
            .expect("a region");
        assert_eq!(
            changed(&before, &document.text()),
            [("x = 0.62".to_owned(), "x = 0.6".to_owned())]
        );
    }

    #[test]
    fn comments_after_values_stay() {
        let text = "# head\nmin_hold_ms = 34   # two frames\n\n[[region]]\nname = \"r\" # mine\nx = 0.5 # left\n";
        let mut document = Document::parse(text).expect("TOML");
        document.set_number("min_hold_ms", 50.0);
        document.set_region("r", &[("x", 0.25)]).expect("a region");
        assert_eq!(
            document.text(),
            text.replace("34 ", "50 ").replace("0.5 #", "0.25 #")
        );
    }

    #[test]
    fn a_new_key_is_added_at_the_top_level() {
        for shipped in SHIPPED_PROFILES {
            let mut document = Document::parse(shipped.toml).expect("TOML");
            document.set_number("bounce_keys_ms", 80.0);
            let text = document.text();
            let profile = Profile::from_toml(shipped.name, &text).expect("still valid");
            assert_eq!(profile.settings.bounce_keys_ns, 80_000_000, "{text}");
        }
    }

    #[test]
    fn undo_and_redo_treat_a_drag_as_one_step() {
        let mut document = mario();
        let first = document.text();
        for step in 0..10 {
            let x = 0.5 + f64::from(step) * 0.01;
            document.set_region("jump", &[("x", x)]).expect("a region");
        }
        document.end_change();
        let dragged = document.text();
        document.set_number("min_hold_ms", 60.0);
        document.undo();
        assert_eq!(document.text(), dragged);
        document.undo();
        assert_eq!(document.text(), first);
        assert!(!document.can_undo());
        document.redo();
        assert_eq!(document.text(), dragged);
        document.set_number("min_hold_ms", 70.0);
        assert!(!document.can_redo(), "a new change clears redo");
    }

    #[test]
    fn invalid_toml_and_a_wrong_list_are_errors() {
        assert!(matches!(Document::parse("a = "), Err(EditError::Syntax(_))));
        let mut document = Document::parse("region = 3\n").expect("TOML");
        let error = document
            .set_region("r", &[("x", 0.1)])
            .expect_err("no list");
        assert!(error.to_string().contains("[[region]]"), "{error}");
    }
}
