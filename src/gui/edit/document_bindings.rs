//! Bindings, `[match]` and the whole text of a profile under edit.

use toml_edit::{Array, Item, Table, Value, value};

use super::document::{Document, EditError, set_value};
use crate::profile::{Binding, Gesture, Profile};

/// What a binding of one region is known by: a binding of a profile overrides the one of its base that is equal in all of these.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BindingKey {
    region: String,
    gesture: &'static str,
    /// That of a swipe.
    direction: Option<&'static str>,
    layer: Option<String>,
}

impl BindingKey {
    /// The key of a press that works always.
    #[must_use]
    pub fn press(region: &str) -> Self {
        Self {
            region: region.to_owned(),
            gesture: PRESS,
            direction: None,
            layer: None,
        }
    }

    /// The key of a binding of a profile.
    #[must_use]
    pub fn of_binding(profile: &Profile, region: &str, binding: &Binding) -> Self {
        Self {
            region: region.to_owned(),
            gesture: binding.gesture.word(),
            direction: match &binding.gesture {
                Gesture::Swipe(swipe) => Some(swipe.direction.word()),
                _ => None,
            },
            layer: binding
                .layer
                .and_then(|layer| profile.layers.get(layer).cloned()),
        }
    }

    /// Whether a table is this binding and does not remove one.
    fn fits(&self, table: &Table) -> bool {
        let text = |key: &str| table.get(key).and_then(Item::as_str);
        let regions = table.get("region").and_then(Item::as_value).map(texts);
        let is_off = table.get("off").and_then(Item::as_bool) == Some(true);
        !is_off
            && regions.is_some_and(|regions| regions == [self.region.as_str()])
            && text("gesture").unwrap_or(PRESS) == self.gesture
            && text("direction") == self.direction
            && text("layer") == self.layer.as_deref()
    }

    /// A binding of this key.
    fn table(&self, output: &str) -> Table {
        let mut table = Table::new();
        table.insert("region", value(self.region.as_str()));
        if self.gesture != PRESS {
            table.insert("gesture", value(self.gesture));
        }
        if let Some(direction) = self.direction {
            table.insert("direction", value(direction));
        }
        if let Some(layer) = &self.layer {
            table.insert("layer", value(layer.as_str()));
        }
        table.insert("output", value(output));
        table
    }
}

/// The gesture of a binding that names none.
const PRESS: &str = "press";

impl Document {
    /// Gives a binding another output. One that the text lacks is added: it overrides that of the base, or is new.
    ///
    /// # Errors
    /// `binding` is not a list of tables.
    pub fn bind(&mut self, key: &BindingKey, output: &str) -> Result<(), EditError> {
        self.record_undo(&format!("bind {}", key.region));
        let bindings = self.array_of_tables("binding")?;
        let existing = bindings.iter().position(|table| key.fits(table));
        match existing.and_then(|index| bindings.get_mut(index)) {
            Some(table) => set_value(table, "output", Value::from(output)),
            None => bindings.push(key.table(output)),
        }
        Ok(())
    }

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
    fn a_binding_is_changed_or_added() {
        let mut document = mario();
        let before = document.text();
        let press = BindingKey::press("jump");
        document.bind(&press, "key:space").expect("bound");
        let changed = before.replacen("output = \"$a\"", "output = \"key:space\"", 1);
        assert_eq!(document.text(), changed, "only its output");
        document
            .add_region("fire", [0.1, 0.1, 0.2, 0.2])
            .expect("added");
        let press = BindingKey::press("fire");
        document.bind(&press, "key:x").expect("bound");
        let profile = Profile::from_toml("p", &document.text()).expect("valid");
        let fire = profile.regions.iter().position(|r| r.name == "fire");
        let fire = fire.expect("a region");
        assert!(profile.bindings.iter().any(|b| b.regions == [fire]));
    }

    #[test]
    fn the_binding_of_the_same_gesture_direction_and_layer_gets_the_output() {
        let tables = [
            "region = \"a\"\noutput = \"key:a\"\nlayer = \"l\"\n",
            "region = \"a\"\ngesture = \"hold\"\noff = true\n",
            "region = [\"a\", \"b\"]\ngesture = \"hold\"\noutput = \"key:a\"\n",
            "region = [\"a\"]\ngesture = \"hold\"\noutput = \"key:a\"\n",
            "region = \"a\"\ngesture = \"swipe\"\ndirection = \"up\"\noutput = \"key:a\"\n",
            "region = \"a\"\ngesture = \"swipe\"\ndirection = \"left\"\noutput = \"key:a\"\n",
            "region = [\"a\"]\noutput = \"key:a\"\n",
        ];
        let text_of = |tables: &[String]| -> String {
            let tables = tables.iter().map(|table| format!("[[binding]]\n{table}"));
            tables.collect()
        };
        let tables = tables.map(str::to_owned);
        let press = BindingKey::press("a");
        let hold = BindingKey {
            gesture: "hold",
            ..press.clone()
        };
        let left = BindingKey {
            gesture: "swipe",
            direction: Some("left"),
            ..press.clone()
        };
        let of_layer = BindingKey {
            layer: Some("l".to_owned()),
            ..press.clone()
        };
        for (key, changed) in [(&press, 6), (&hold, 3), (&left, 5), (&of_layer, 0)] {
            let mut document = Document::parse(&text_of(&tables)).expect("TOML");
            document.bind(key, "key:k").expect("bound");
            let mut wanted = tables.clone();
            wanted[changed] = wanted[changed].replace("key:a", "key:k");
            assert_eq!(document.text(), text_of(&wanted), "{key:?}");
        }
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
