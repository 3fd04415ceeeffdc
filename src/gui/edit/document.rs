//! A profile's text as it is edited: one value changes at a time, comments and order stay; every change can be undone.
//!
//! Invariant: [`Document::text`] is always TOML that was read back; what differs from the file is the values that were set.

use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, Value, value};

/// Changes that can be undone.
const MOST_UNDO: usize = 200;
/// Shares of the pad are written to a thousandth.
const DECIMALS: f64 = 1000.0;

/// Why a text cannot be edited.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EditError {
    /// It is no TOML.
    #[error("the text is no TOML: {0}")]
    Broken(String),
    /// There is nothing of that name that could be changed.
    #[error("{0}")]
    Missing(String),
}

/// A text under edit.
#[derive(Clone, Debug)]
pub struct Document {
    document: DocumentMut,
    undo: Vec<String>,
    redo: Vec<String>,
    /// What is being changed again and again, as a slider does: one step to undo.
    going: Option<String>,
}

impl Document {
    /// Reads a text.
    ///
    /// # Errors
    /// It is no TOML.
    pub fn read(text: &str) -> Result<Self, EditError> {
        let document = text
            .parse::<DocumentMut>()
            .map_err(|error| EditError::Broken(error.message().to_owned()))?;
        Ok(Self {
            document,
            undo: Vec::new(),
            redo: Vec::new(),
            going: None,
        })
    }

    /// The text as it is now.
    #[must_use]
    pub fn text(&self) -> String {
        self.document.to_string()
    }

    /// Sets a number of a region: its `x`, `y`, `w`, `h` or `r`. A region of the base is added here under its name.
    ///
    /// # Errors
    /// Its `region` is no list of tables.
    pub fn set_region(&mut self, region: &str, numbers: &[(&str, f64)]) -> Result<(), EditError> {
        self.begin(&format!("region {region}"));
        let table = self.named("region", "name", region)?;
        for (key, number) in numbers {
            put(table, key, (number * DECIMALS).round() / DECIMALS);
        }
        Ok(())
    }

    /// Sets a key at the top: a threshold.
    pub fn set_number(&mut self, key: &str, number: f64) {
        self.begin(key);
        let at_top = self.document.as_table_mut();
        if at_top.contains_key(key) {
            put(at_top, key, number);
            return;
        }
        // A new key of the top stands before the first table, beneath the last key that is there.
        at_top.insert(key, number_item(number));
    }

    /// Takes a key at the top away: its default holds again.
    pub fn clear(&mut self, key: &str) {
        self.begin(&format!("clear {key}"));
        self.document.remove(key);
    }

    /// Lets a region press an output. The region's own press is changed; where it has none one is added.
    ///
    /// # Errors
    /// Its `binding` is no list of tables.
    pub fn bind(&mut self, region: &str, output: &str) -> Result<(), EditError> {
        self.begin(&format!("bind {region}"));
        let bindings = self.tables("binding")?;
        let is_press = |table: &Table| {
            let word = |key: &str| table.get(key).and_then(Item::as_str);
            word("region") == Some(region) && matches!(word("gesture"), None | Some("press"))
        };
        let known = bindings.iter().position(is_press);
        match known.and_then(|index| bindings.get_mut(index)) {
            Some(table) => set_keeping(table, "output", Value::from(output)),
            None => {
                let mut table = Table::new();
                table.insert("region", value(region));
                table.insert("output", value(output));
                bindings.push(table);
            }
        }
        Ok(())
    }

    /// Adds a region.
    ///
    /// # Errors
    /// Its `region` is no list of tables.
    pub fn add_region(&mut self, name: &str, [x, y, w, h]: [f64; 4]) -> Result<(), EditError> {
        self.begin(&format!("add {name}"));
        let mut table = Table::new();
        table.insert("name", value(name));
        table.insert("shape", value("rect"));
        for (key, number) in [("x", x), ("y", y), ("w", w), ("h", h)] {
            table.insert(key, number_item((number * DECIMALS).round() / DECIMALS));
        }
        self.tables("region")?.push(table);
        Ok(())
    }

    /// Ends a change that was made of many, such as a drag.
    pub fn settle(&mut self) {
        self.going = None;
    }

    /// Whether there is something to undo.
    #[must_use]
    pub fn can_undo(&self) -> bool {
        !self.undo.is_empty()
    }

    /// Whether there is something to do again.
    #[must_use]
    pub fn can_redo(&self) -> bool {
        !self.redo.is_empty()
    }

    /// Takes the last change back.
    pub fn undo(&mut self) {
        if let Some(text) = self.undo.pop() {
            self.redo.push(self.text());
            self.restore(&text);
        }
    }

    /// Makes the change again that was taken back.
    pub fn redo(&mut self) {
        if let Some(text) = self.redo.pop() {
            self.undo.push(self.text());
            self.restore(&text);
        }
    }

    fn restore(&mut self, text: &str) {
        self.going = None;
        if let Ok(document) = text.parse() {
            self.document = document;
        }
    }

    /// Remembers the text before a change, unless the same change goes on.
    fn begin(&mut self, what: &str) {
        if self.going.as_deref() == Some(what) {
            return;
        }
        self.going = Some(what.to_owned());
        self.undo.push(self.text());
        if self.undo.len() > MOST_UNDO {
            self.undo.remove(0);
        }
        self.redo.clear();
    }

    fn tables(&mut self, list: &str) -> Result<&mut ArrayOfTables, EditError> {
        self.document
            .entry(list)
            .or_insert(Item::ArrayOfTables(ArrayOfTables::new()))
            .as_array_of_tables_mut()
            .ok_or_else(|| {
                EditError::Missing(format!("`{list}` is no list: write [[{list}]] above each"))
            })
    }

    /// The table of a list whose key has a value; added if there is none.
    fn named(&mut self, list: &str, key: &str, name: &str) -> Result<&mut Table, EditError> {
        let tables = self.tables(list)?;
        let known = tables
            .iter()
            .position(|table| table.get(key).and_then(Item::as_str) == Some(name));
        let index = match known {
            Some(index) => index,
            None => {
                let mut table = Table::new();
                table.insert(key, value(name));
                tables.push(table);
                tables.len() - 1
            }
        };
        tables
            .get_mut(index)
            .ok_or_else(|| EditError::Missing(format!("no {list} is named `{name}`")))
    }
}

/// A number as people write it: whole ones without a point.
fn number_item(number: f64) -> Item {
    value(number_value(number, false))
}

fn number_value(number: f64, as_float: bool) -> Value {
    const WHOLE: f64 = 1e15;
    if number.fract() == 0.0 && number.abs() < WHOLE && !as_float {
        Value::from(number as i64)
    } else {
        Value::from(number)
    }
}

/// Sets a number and keeps the spaces and the comment around it, and whether it had a point.
fn put(table: &mut Table, key: &str, number: f64) {
    let had_point = table.get(key).is_some_and(Item::is_float);
    if table.get(key).is_some_and(|item| {
        item.as_float()
            .or_else(|| item.as_integer().map(|i| i as f64))
            == Some(number)
    }) {
        return;
    }
    set_keeping(table, key, number_value(number, had_point));
}

fn set_keeping(table: &mut Table, key: &str, mut new: Value) {
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
        Document::read(shipped_profile("super-mario").expect("shipped").toml).expect("sound")
    }

    /// Lines of two texts that differ, old and new.
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
    fn moving_a_region_changes_its_numbers_alone() {
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
    fn a_comment_behind_a_value_stays_behind_it() {
        let text = "# head\nmin_hold_ms = 34   # two frames\n\n[[region]]\nname = \"r\" # mine\nx = 0.5 # left\n";
        let mut document = Document::read(text).expect("TOML");
        document.set_number("min_hold_ms", 50.0);
        document.set_region("r", &[("x", 0.25)]).expect("a region");
        assert_eq!(
            document.text(),
            text.replace("34 ", "50 ").replace("0.5 #", "0.25 #")
        );
    }

    #[test]
    fn a_key_that_was_not_there_goes_to_the_top_and_the_text_stays_sound() {
        for shipped in SHIPPED_PROFILES {
            let mut document = Document::read(shipped.toml).expect("TOML");
            document.set_number("bounce_keys_ms", 80.0);
            let text = document.text();
            let profile = Profile::from_toml(shipped.name, &text).expect("still sound");
            assert_eq!(profile.settings.bounce_keys_ns, 80_000_000, "{text}");
        }
    }

    #[test]
    fn a_region_is_bound_anew_and_one_without_a_binding_gets_one() {
        let mut document = mario();
        let before = document.text();
        document.bind("jump", "key:space").expect("bound");
        assert_eq!(
            changed(&before, &document.text()),
            [(
                "output = \"$a\"".to_owned(),
                "output = \"key:space\"".to_owned()
            )]
        );
        document
            .add_region("fire", [0.1, 0.1, 0.2, 0.2])
            .expect("added");
        document.bind("fire", "key:x").expect("bound");
        let profile = Profile::from_toml("p", &document.text()).expect("sound");
        let fire = profile.regions.iter().position(|r| r.name == "fire");
        let fire = fire.expect("a region");
        assert!(profile.bindings.iter().any(|b| b.regions == [fire]));
    }

    #[test]
    fn everything_is_undone_and_done_again_and_a_drag_is_one_step() {
        let mut document = mario();
        let first = document.text();
        for step in 0..10 {
            let x = 0.5 + f64::from(step) * 0.01;
            document.set_region("jump", &[("x", x)]).expect("a region");
        }
        document.settle();
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
        assert!(!document.can_redo(), "another way was taken");
    }

    #[test]
    fn what_is_no_toml_is_told_and_what_is_no_list_too() {
        assert!(matches!(Document::read("a = "), Err(EditError::Broken(_))));
        let mut document = Document::read("region = 3\n").expect("TOML");
        let error = document
            .set_region("r", &[("x", 0.1)])
            .expect_err("no list");
        assert!(error.to_string().contains("[[region]]"), "{error}");
    }
}
