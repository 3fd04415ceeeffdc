//! Bindings, `[match]` and the whole text of a profile under edit.

use toml_edit::{Array, Item, Table, Value, value};

use super::document::{Document, EditError, set_value};

impl Document {
    /// Replaces the text. Steps of typing are one change until something else changes.
    ///
    /// # Errors
    /// It is not valid TOML; the text before stays.
    pub fn set_text(&mut self, text: &str) -> Result<(), EditError> {
        let parsed = Self::parse(text)?;
        self.record_undo("text");
        self.document = parsed.document;
        Ok(())
    }

    /// Numbers of the bindings that a region takes part in, in the order of the text.
    #[must_use]
    pub fn bindings_of(&self, region: &str) -> Vec<usize> {
        let tables = self.document.get("binding");
        let tables = tables.and_then(Item::as_array_of_tables);
        let numbered = tables
            .into_iter()
            .flat_map(|tables| tables.iter())
            .enumerate();
        let takes_part = |table: &Table| {
            let regions = table.get("region").and_then(Item::as_value);
            regions.is_some_and(|regions| texts(regions).iter().any(|name| name == region))
        };
        numbered
            .filter(|(_, table)| takes_part(table))
            .map(|(number, _)| number)
            .collect()
    }

    /// The value of a key of a binding.
    #[must_use]
    pub fn binding_value(&self, number: usize, key: &str) -> Option<&Value> {
        let tables = self.document.get("binding")?.as_array_of_tables()?;
        tables.get(number)?.get(key)?.as_value()
    }

    /// Sets a key of a binding, or removes it.
    ///
    /// # Errors
    /// `binding` is not a list of tables.
    pub fn set_binding_value(
        &mut self,
        number: usize,
        key: &str,
        new: Option<Value>,
    ) -> Result<(), EditError> {
        self.record_undo(&format!("{key} of binding {number}"));
        if let Some(table) = self.array_of_tables("binding")?.get_mut(number) {
            set_or_remove(table, key, new);
        }
        Ok(())
    }

    /// Adds a binding of a region that presses an output.
    ///
    /// # Errors
    /// `binding` is not a list of tables.
    pub fn add_binding(&mut self, region: &str, output: &str) -> Result<(), EditError> {
        self.record_undo(&format!("add a binding of {region}"));
        let mut table = Table::new();
        table.insert("region", value(region));
        table.insert("output", value(output));
        self.array_of_tables("binding")?.push(table);
        self.end_change();
        Ok(())
    }

    /// Removes a binding.
    ///
    /// # Errors
    /// `binding` is not a list of tables.
    pub fn remove_binding(&mut self, number: usize) -> Result<(), EditError> {
        self.record_undo("remove a binding");
        let tables = self.array_of_tables("binding")?;
        if number < tables.len() {
            tables.remove(number);
        }
        self.end_change();
        Ok(())
    }

    /// Names of the programs that select this profile.
    #[must_use]
    pub fn processes(&self) -> Vec<String> {
        let names = self
            .document
            .get("match")
            .and_then(|item| item.get("process"));
        names
            .and_then(Item::as_value)
            .map(texts)
            .unwrap_or_default()
    }

    /// Sets the programs that select this profile; without any, `[match]` goes.
    pub fn set_processes(&mut self, names: &[String]) {
        self.record_undo("match");
        let top_level = self.document.as_table_mut();
        if names.is_empty() {
            top_level.remove("match");
            return;
        }
        let table = top_level
            .entry("match")
            .or_insert(Item::Table(Table::new()));
        if let Some(table) = table.as_table_mut() {
            set_or_remove(table, "process", Some(texts_value(names)));
        }
    }
}

/// A text, or the texts of a list.
pub(super) fn texts(of: &Value) -> Vec<String> {
    match of {
        Value::String(text) => vec![text.value().clone()],
        Value::Array(list) => {
            let texts = list.iter().filter_map(Value::as_str);
            texts.map(str::to_owned).collect()
        }
        _ => Vec::new(),
    }
}

/// One text, or a list of several.
pub(super) fn texts_value(names: &[String]) -> Value {
    match names {
        [name] => Value::from(name.as_str()),
        names => Value::Array(names.iter().map(String::as_str).collect::<Array>()),
    }
}

/// Sets a value, or removes the key.
fn set_or_remove(table: &mut Table, key: &str, new: Option<Value>) {
    match new {
        Some(new) => set_value(table, key, new),
        None => drop(table.remove(key)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{Profile, shipped_profile};

    fn mario() -> Document {
        Document::parse(shipped_profile("super-mario").expect("shipped").toml).expect("valid")
    }

    #[test]
    fn a_binding_gets_a_gesture_and_a_mode_and_comments_stay() {
        let mut document = mario();
        let before = document.text();
        document.add_binding("jump", "key:x").expect("added");
        let number = *document.bindings_of("jump").last().expect("a binding");
        for (key, word) in [("gesture", "double-tap"), ("mode", "turbo")] {
            let set = document.set_binding_value(number, key, Some(Value::from(word)));
            set.expect("set");
        }
        let text = document.text();
        assert!(text.starts_with(before.trim_end()), "only added: {text}");
        let profile = Profile::from_toml("p", &text).expect("valid");
        let last = profile.bindings.last().expect("a binding");
        assert!(format!("{last:?}").contains("DoubleTap"), "{last:?}");
        assert!(format!("{last:?}").contains("Turbo"), "{last:?}");
        document.remove_binding(number).expect("removed");
        assert_eq!(document.text().trim_end(), before.trim_end());
    }

    #[test]
    fn a_chord_is_found_by_each_of_its_regions() {
        let text = "[[binding]]\nregion = [\"a\", \"b\"]\ngesture = \"chord\"\n[[binding]]\nregion = \"b\"\n";
        let document = Document::parse(text).expect("TOML");
        assert_eq!(document.bindings_of("a"), [0]);
        assert_eq!(document.bindings_of("b"), [0, 1]);
    }

    #[test]
    fn programs_are_set_and_removed() {
        let mut document = mario();
        let before = document.processes();
        document.set_processes(&["mygame".to_owned(), "other".to_owned()]);
        let profile = Profile::from_toml("p", &document.text()).expect("valid");
        assert_eq!(profile.processes, ["mygame", "other"]);
        document.set_processes(&[]);
        assert!(document.processes().is_empty());
        document.undo();
        document.undo();
        assert_eq!(document.processes(), before);
    }

    #[test]
    fn a_text_that_is_no_toml_changes_nothing() {
        let mut document = mario();
        let before = document.text();
        document
            .set_text("[[region]\nname = ")
            .expect_err("no TOML");
        assert_eq!(document.text(), before);
        document.set_text("name = \"p\"\n").expect("TOML");
        document.undo();
        assert_eq!(document.text(), before);
    }
}
