//! The bindings of the selected region: gesture, mode, layer, outputs, and every key that the chosen gesture and mode take. The
//! fields follow from the keys of profiles, so a new key appears here too.

use egui::Ui;
use toml_edit::Value;

use super::diagrams::{gesture_diagram, mode_diagram, split_notes};
use super::document::number_value;
use super::document_bindings::{texts, texts_value};
use super::{EditView, GameContext};
use crate::gui::choice;
use crate::gui::theme;
use crate::gui::timing_settings::clicked_steps;
use crate::profile::{Fallback, Key, KeyKind, Table, keys};

/// Keys that every binding shows, in this order; those of its gesture and its mode follow.
const ALWAYS: [&str; 5] = ["gesture", "output", "mode", "layer", "region"];
/// The output of a new binding.
const NEW_OUTPUT: &str = "key:space";
/// Smallest and largest letters of a diagram, points.
const LETTERS: (f32, f32) = (8.0, 10.5);
/// Width of the names before the fields, points.
const NAME_WIDTH: f32 = 96.0;
/// A click of the buttons beside a number changes it by so many steps of a drag.
const COARSE_STEP: f64 = 5.0;

impl EditView {
    /// Draws the bindings of the selected region.
    pub(super) fn draw_bindings(&mut self, ui: &mut Ui, game: GameContext<'_>) {
        let Some(region) = self.selected.clone() else {
            return;
        };
        theme::title(ui, &format!("Bindings of {region}"));
        let Some(opened) = &self.opened else { return };
        let numbers = opened.document.bindings_of(&region);
        if numbers.is_empty() {
            ui.weak("None in this file; its base may have some.");
        }
        for (nth, number) in numbers.into_iter().enumerate() {
            ui.push_id(("binding", nth), |ui| {
                self.draw_binding(ui, number, game);
            });
        }
        if ui.button("+ Binding").clicked() {
            self.change(game, |document| document.add_binding(&region, NEW_OUTPUT));
        }
    }

    fn draw_binding(&mut self, ui: &mut Ui, number: usize, game: GameContext<'_>) {
        let word = |key: &str| self.binding_word(number, key);
        let (gesture, mode) = (word("gesture"), word("mode"));
        let output = self.binding_texts(number, "output").join(", ");
        let heading = match gesture.as_str() {
            "press" => format!("press → {output}"),
            gesture => format!("{gesture} → {output}"),
        };
        let body = egui::CollapsingHeader::new(heading)
            .id_salt(number)
            .show(ui, |ui| {
                let always = ALWAYS.into_iter().filter_map(binding_key);
                let own = keys().iter().filter(|key| {
                    let takes = |word: &String| key.only.contains(&word.as_str());
                    key.table == Table::Binding && (takes(&gesture) || takes(&mode))
                });
                for key in always.chain(own) {
                    self.draw_key(ui, number, key, game);
                }
                let all = binding_key("gesture").map_or(&[][..], words);
                draw_diagram(ui, &gesture_diagram(&gesture, all));
                if mode != "direct" {
                    draw_diagram(ui, &mode_diagram(&mode));
                }
                theme::small_button(ui, "Remove this binding").clicked()
            });
        if body.body_returned == Some(true) {
            self.change(game, |document| document.remove_binding(number));
        }
    }

    /// A field for a key of a binding.
    fn draw_key(&mut self, ui: &mut Ui, number: usize, key: &'static Key, game: GameContext<'_>) {
        let row = ui.horizontal(|ui| {
            let size = egui::vec2(NAME_WIDTH, ui.spacing().interact_size.y);
            let left = egui::Layout::left_to_right(egui::Align::Center);
            let label = ui.allocate_ui_with_layout(size, left, |ui| {
                ui.set_min_size(size);
                ui.label(key.name).on_hover_text(key.about)
            });
            self.draw_value(ui, &label.inner, number, key)
        });
        if let Some(new) = row.inner {
            self.change(game, |document| {
                document.set_binding_value(number, key.name, new)
            });
        }
    }

    /// The value of a key; returns the new value when it was changed, none inside removes the key.
    fn draw_value(
        &self,
        ui: &mut Ui,
        label: &egui::Response,
        number: usize,
        key: &'static Key,
    ) -> Option<Option<Value>> {
        let value = self
            .opened
            .as_ref()?
            .document
            .binding_value(number, key.name);
        match key.kind {
            KeyKind::Word(words) => {
                let current = self.binding_word(number, key.name);
                let entries = words
                    .iter()
                    .map(|word| ((*word).to_owned(), (*word).to_owned()));
                let combo = egui::ComboBox::from_id_salt(key.name).selected_text(&current);
                let chosen = choice::list(ui, combo, Some(label), &current, entries.collect())?;
                let is_default = words.first() == Some(&chosen.as_str());
                Some((!is_default).then(|| Value::from(chosen)))
            }
            KeyKind::Number(least, most, unit) => {
                let range = least..=most;
                draw_number(ui, label, key, value, range, &format!(" {unit}"))
            }
            KeyKind::Count(least, most) => {
                let range = f64::from(least)..=f64::from(most);
                draw_number(ui, label, key, value, range, "")
            }
            KeyKind::Flag => {
                let default = key.default == Fallback::Flag(true);
                let mut flag = value.and_then(Value::as_bool).unwrap_or(default);
                let changed = ui.checkbox(&mut flag, "").labelled_by(label.id).changed();
                changed.then(|| (flag != default).then(|| Value::from(flag)))
            }
            KeyKind::Text | KeyKind::Texts | KeyKind::Points => {
                let names = value.map(texts).unwrap_or_default();
                let names = draw_names(ui, label, key.name, &names, &key.default.to_string())?;
                Some((!names.is_empty()).then(|| texts_value(&names)))
            }
        }
    }

    /// A word of a binding, or the default.
    fn binding_word(&self, number: usize, key: &str) -> String {
        let written = self.binding_texts(number, key).into_iter().next();
        let default = binding_key(key).map_or(&[][..], words).first();
        written.unwrap_or_else(|| default.copied().unwrap_or_default().to_owned())
    }

    fn binding_texts(&self, number: usize, key: &str) -> Vec<String> {
        let opened = self.opened.as_ref();
        let value = opened.and_then(|opened| opened.document.binding_value(number, key));
        value.map(texts).unwrap_or_default()
    }

    /// The programs that select this profile.
    pub(super) fn draw_match(&mut self, ui: &mut Ui, game: GameContext<'_>) {
        theme::title(ui, "Games");
        let Some(opened) = &self.opened else { return };
        let names = opened.document.processes();
        let row = ui.horizontal(|ui| {
            let label = ui.label("Programs");
            draw_names(ui, &label, "programs", &names, "mygame, mygame.exe")
        });
        ui.weak("While one of them runs, the profile “by the running game” is this one.");
        if let Some(names) = row.inner {
            self.change(game, |document| {
                document.set_processes(&names);
                Ok(())
            });
        }
    }
}

/// A field of names between commas; returns the names when they were changed. What is typed stays as it is while it means the same
/// names: a comma at the end too. The id of the field does not depend on what is drawn above it, so that it keeps the focus.
fn draw_names(
    ui: &mut Ui,
    label: &egui::Response,
    salt: &str,
    names: &[String],
    hint: &str,
) -> Option<Vec<String>> {
    let id = ui.make_persistent_id(("names", salt));
    let typed: Option<String> = ui.data(|data| data.get_temp(id));
    let typed = typed.filter(|typed| split_names(typed) == names);
    let mut text = typed.unwrap_or_else(|| names.join(", "));
    let field = egui::TextEdit::singleline(&mut text)
        .id(id)
        .desired_width(ui.available_width() - 8.0)
        .hint_text(hint);
    let field = ui.add(field).labelled_by(label.id);
    theme::keep_focus_on_enter(ui, &field);
    let names = field.changed().then(|| split_names(&text));
    let has_focus = field.has_focus();
    ui.data_mut(|data| match has_focus {
        true => drop(data.insert_temp(id, text)),
        false => data.remove::<String>(id),
    });
    names
}

/// Names between commas.
fn split_names(text: &str) -> Vec<String> {
    let names = text.split(',').map(str::trim);
    names
        .filter(|name| !name.is_empty())
        .map(str::to_owned)
        .collect()
}

fn binding_key(name: &str) -> Option<&'static Key> {
    let mut keys = keys().iter();
    keys.find(|key| key.table == Table::Binding && key.name == name)
}

fn words(key: &Key) -> &'static [&'static str] {
    match key.kind {
        KeyKind::Word(words) => words,
        _ => &[],
    }
}

/// A number, and a button that removes it: the default holds then.
fn draw_number(
    ui: &mut Ui,
    label: &egui::Response,
    key: &Key,
    value: Option<&Value>,
    range: std::ops::RangeInclusive<f64>,
    unit: &str,
) -> Option<Option<Value>> {
    let written = value.and_then(|value| {
        let whole = || value.as_integer().map(|whole| whole as f64);
        value.as_float().or_else(whole)
    });
    let default = match key.default {
        Fallback::Number(default) => default,
        _ => 0.0,
    };
    let mut number = written.unwrap_or(default);
    let speed = ((range.end() - range.start()) / 500.0).clamp(0.01, 2.0);
    let step = speed * COARSE_STEP;
    let field = egui::DragValue::new(&mut number)
        .range(range.clone())
        .speed(speed)
        .max_decimals(2)
        .suffix(unit);
    let mut changed = ui.add(field).labelled_by(label.id).changed();
    let steps = clicked_steps(ui, key.name);
    if steps != 0.0 {
        let rounded = ((number / step).round() + steps) * step;
        number = rounded.clamp(*range.start(), *range.end());
        changed = true;
    }
    if written.is_none() {
        ui.weak("default");
    } else if theme::small_button(ui, "⟲")
        .on_hover_text("Default")
        .clicked()
    {
        return Some(None);
    }
    let is_float = value.is_some_and(Value::is_float);
    changed.then(|| Some(number_value(number, is_float)))
}

/// A diagram in letters of one width, small enough for the panel, with its notes below.
fn draw_diagram(ui: &mut Ui, diagram: &str) {
    if diagram.is_empty() {
        return;
    }
    let (drawing, notes) = split_notes(diagram);
    let letters = drawing.lines().map(|line| line.chars().count()).max();
    let font = |size| egui::FontId::monospace(size);
    let letter = ui
        .ctx()
        .fonts_mut(|fonts| fonts.glyph_width(&font(LETTERS.1), '_'));
    let width = letter * letters.unwrap_or(1) as f32;
    // A little less: widths are rounded to whole pixels.
    let fitting = LETTERS.1 * 0.97 * ui.available_width() / width.max(1.0);
    let size = fitting.clamp(LETTERS.0, LETTERS.1);
    egui::ScrollArea::horizontal()
        .id_salt(diagram)
        .show(ui, |ui| {
            let text = egui::RichText::new(drawing).font(font(size));
            ui.add(egui::Label::new(text).extend());
        });
    if !notes.is_empty() {
        let notes = egui::RichText::new(notes).small().weak();
        ui.add(egui::Label::new(notes).wrap());
    }
}
