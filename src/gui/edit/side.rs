//! The side of the editor: save and undo, the chosen region, thresholds beside what the player does right now.

use egui::{Key, Modifiers, Ui};

use super::{EditView, Learning};
use crate::gui::desk::Desk;
use crate::gui::play::{Wish, file_name};
use crate::gui::playing::Playing;
use crate::gui::theme;
use crate::profile::{Settings, Shape};
use crate::types::{Faulty, Output, ms_from_nanos};

/// A threshold with a slider.
struct Threshold {
    key: &'static str,
    words: &'static str,
    largest: f64,
    unit: &'static str,
    /// What holds now.
    of: fn(&Settings) -> f64,
    /// What the player does right now, in the same unit.
    live: fn(&Playing) -> Option<f64>,
}

const THRESHOLDS: [Threshold; 7] = [
    Threshold {
        key: "min_hold_ms",
        words: "Shortest press",
        largest: 200.0,
        unit: " ms",
        of: |s| ms_from_nanos(s.min_hold_ns),
        live: last_press_ms,
    },
    Threshold {
        key: "min_gap_ms",
        words: "Shortest release",
        largest: 200.0,
        unit: " ms",
        of: |s| ms_from_nanos(s.min_gap_ns),
        live: last_gap_ms,
    },
    Threshold {
        key: "slow_keys_ms",
        words: "Counts after",
        largest: 1000.0,
        unit: " ms",
        of: |s| ms_from_nanos(s.slow_keys_ns),
        live: touch_age_ms,
    },
    Threshold {
        key: "bounce_keys_ms",
        words: "Re-press ignored for",
        largest: 500.0,
        unit: " ms",
        of: |s| ms_from_nanos(s.bounce_keys_ns),
        live: last_gap_ms,
    },
    Threshold {
        key: "dwell_ms",
        words: "Stays in one place for",
        largest: 2000.0,
        unit: " ms",
        of: |s| ms_from_nanos(s.dwell_ns),
        live: touch_age_ms,
    },
    Threshold {
        key: "tremor_mm",
        words: "Tremor smaller than",
        largest: 20.0,
        unit: " mm",
        of: |s| s.tremor_mm,
        live: moved_mm,
    },
    Threshold {
        key: "tremor_ms",
        words: "Back again within",
        largest: 300.0,
        unit: " ms",
        of: |s| ms_from_nanos(s.tremor_ns),
        live: last_gap_ms,
    },
];

impl EditView {
    pub(super) fn side(&mut self, ui: &mut Ui, playing: &Playing, desk: &dyn Desk) -> Option<Wish> {
        let mut wish = None;
        theme::card(ui).show(ui, |ui| {
            ui.set_width(ui.available_width());
            wish = self.head(ui, playing, desk);
        });
        self.faults(ui);
        theme::card(ui).show(ui, |ui| {
            ui.set_width(ui.available_width());
            self.region(ui, playing, desk);
        });
        theme::card(ui).show(ui, |ui| {
            ui.set_width(ui.available_width());
            theme::title(ui, "thresholds, beside what you do now");
            self.thresholds(ui, playing, desk);
        });
        wish
    }

    /// The file and what can be done with it.
    fn head(&mut self, ui: &mut Ui, playing: &Playing, desk: &dyn Desk) -> Option<Wish> {
        let palette = theme::of(ui);
        if let Some(why) = &self.failed {
            ui.colored_label(palette.bad, format!("✖ {why}"));
        }
        let unsaved = self.is_unsaved();
        let Some(opened) = &mut self.opened else {
            ui.label("No profile is open.");
            return None;
        };
        let name = file_name(&opened.argument);
        ui.horizontal(|ui| {
            ui.label(egui::RichText::new(name).size(18.0));
            if unsaved {
                ui.colored_label(palette.warn, "● not saved");
            }
        });
        let shipped = !super::is_file(&opened.argument);
        if shipped {
            ui.weak("A shipped profile: saving makes a copy of your own.");
        }
        let (can_undo, can_redo) = (opened.document.can_undo(), opened.document.can_redo());
        let sound = opened.checked.is_ok();
        let mut save = false;
        let mut step = None;
        ui.horizontal_wrapped(|ui| {
            let words = if shipped { "Save my copy" } else { "Save" };
            save = ui
                .add_enabled(unsaved && sound, egui::Button::new(words))
                .on_hover_text("Ctrl+S")
                .clicked();
            let undo = ui.add_enabled(can_undo, egui::Button::new("⟲ Undo"));
            if undo.on_hover_text("Ctrl+Z").clicked() {
                step = Some(false);
            }
            let redo = ui.add_enabled(can_redo, egui::Button::new("⟳ Redo"));
            if redo.on_hover_text("Ctrl+Shift+Z").clicked() {
                step = Some(true);
            }
        });
        let key = |ui: &Ui, modifiers, key| ui.input_mut(|i| i.consume_key(modifiers, key));
        if key(ui, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z) {
            step = Some(true);
        } else if key(ui, Modifiers::COMMAND, Key::Z) {
            step = Some(false);
        }
        save |= unsaved && sound && key(ui, Modifiers::COMMAND, Key::S);
        if let Some(again) = step {
            self.change(&playing.choice, desk, |document| {
                if again {
                    document.redo();
                } else {
                    document.undo();
                }
                Ok(())
            });
            if let Some(chosen) = self.chosen.clone() {
                self.choose(&chosen);
            }
        }
        if let Some(notice) = &self.notice {
            ui.add(egui::Label::new(egui::RichText::new(notice).color(palette.warn)).wrap());
        }
        if save {
            return self.save(&playing.choice, desk);
        }
        None
    }

    /// What is wrong with the text, but for what is told at its field.
    fn faults(&self, ui: &mut Ui) {
        let Some(Err(faulty)) = self.opened.as_ref().map(|opened| opened.checked.as_ref()) else {
            return;
        };
        let palette = theme::of(ui);
        for fault in &faulty.faults {
            let (line, _) = faulty.line_column(fault.span.start);
            ui.colored_label(palette.bad, format!("✖ line {line}: {}", fault.message));
            if let Some(help) = &fault.help {
                ui.weak(help);
            }
        }
    }

    /// The chosen region: its numbers, and what it presses.
    fn region(&mut self, ui: &mut Ui, playing: &Playing, desk: &dyn Desk) {
        theme::title(ui, "region");
        let Some(profile) = self.profile().cloned() else {
            ui.label("Mend the text first.");
            return;
        };
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            for region in &profile.regions {
                let chosen = self.chosen.as_deref() == Some(&region.name);
                if ui.selectable_label(chosen, &region.name).clicked() {
                    self.choose(&region.name);
                }
            }
            if ui
                .button("+ New")
                .on_hover_text("a new region in the middle")
                .clicked()
            {
                let name = fresh_name(profile.regions.iter().map(|r| r.name.as_str()));
                self.change(&playing.choice, desk, |document| {
                    document.add_region(&name, [0.4, 0.4, 0.2, 0.2])
                });
                self.choose(&name);
            }
        });
        self.learn_button(ui);
        let Some(region) = profile
            .regions
            .iter()
            .find(|region| Some(&region.name) == self.chosen.as_ref())
        else {
            ui.weak("Choose a region here or on the pad; drag it, or an edge of it.");
            return;
        };
        let name = region.name.clone();
        let numbers: Vec<(&'static str, f64)> = match region.shape {
            Shape::Rect { x, y, w, h } | Shape::Ellipse { x, y, w, h } => {
                vec![("x", x), ("y", y), ("w", w), ("h", h)]
            }
            Shape::Circle { x, y, r } => vec![("x", x), ("y", y), ("r", r)],
            Shape::Polygon(_) => Vec::new(),
        };
        ui.horizontal_wrapped(|ui| {
            for (key, number) in numbers {
                let mut percent = number * 100.0;
                let field = egui::DragValue::new(&mut percent)
                    .range(0.0..=100.0)
                    .speed(0.25)
                    .max_decimals(1)
                    .prefix(format!("{key} "))
                    .suffix(" %");
                let response = ui.add(field);
                response.widget_info(|| {
                    let mut info = egui::WidgetInfo::drag_value(true, percent);
                    info.label = Some(format!("{key} of {name}, percent of the pad"));
                    info
                });
                if response.changed() {
                    self.change(&playing.choice, desk, |document| {
                        document.set_region(&name, &[(key, percent / 100.0)])
                    });
                }
                if response.drag_stopped() || response.lost_focus() {
                    self.settle();
                }
            }
        });
        self.output(ui, &name, playing, desk);
    }

    fn settle(&mut self) {
        if let Some(opened) = &mut self.opened {
            opened.document.settle();
        }
    }

    /// What the region presses, as text; what is wrong with it is told here.
    fn output(&mut self, ui: &mut Ui, region: &str, playing: &Playing, desk: &dyn Desk) {
        let palette = theme::of(ui);
        let response = ui.horizontal(|ui| {
            let label = ui.label("presses");
            let field = egui::TextEdit::singleline(&mut self.output_text)
                .desired_width(130.0)
                .hint_text("key:space");
            ui.add(field).labelled_by(label.id)
        });
        if response.inner.changed() {
            match self.output_text.trim().parse::<Output>() {
                Ok(output) => {
                    self.output_error = None;
                    let output = output.to_string();
                    self.change(&playing.choice, desk, |document| {
                        document.bind(region, &output)
                    });
                    self.settle();
                }
                Err(error) => {
                    let guess = error.suggestion.as_ref();
                    let guess = guess.map_or(String::new(), |s| format!(": did you mean `{s}`?"));
                    self.output_error = Some(format!("{error}{guess}"));
                }
            }
        }
        if let Some(error) = &self.output_error {
            let words = egui::RichText::new(format!("✖ {error}")).color(palette.bad);
            ui.add(egui::Label::new(words).wrap());
        }
    }

    fn learn_button(&mut self, ui: &mut Ui) {
        let palette = theme::of(ui);
        let words = match &self.learning {
            Learning::No => "Bind: press here, then the key".to_owned(),
            Learning::Region => "… press the pad where it shall be".to_owned(),
            Learning::Key(region) => format!("… now press the key for `{region}`"),
        };
        let waits = self.learning != Learning::No;
        let text = egui::RichText::new(words).color(if waits {
            palette.on_accent
        } else {
            palette.text
        });
        let mut button = egui::Button::new(text);
        if waits {
            button = button.fill(palette.accent);
        }
        if ui.add(button).clicked() {
            self.learning = if waits {
                Learning::No
            } else {
                Learning::Region
            };
        }
    }

    fn thresholds(&mut self, ui: &mut Ui, playing: &Playing, desk: &dyn Desk) {
        let palette = theme::of(ui);
        let Some(settings) = self.profile().map(|profile| profile.settings.clone()) else {
            return;
        };
        for threshold in &THRESHOLDS {
            let now = (threshold.of)(&settings);
            let mut wanted = now;
            ui.horizontal(|ui| {
                ui.label(threshold.words);
                if let Some(live) = (threshold.live)(playing) {
                    let side = if live >= now { "above" } else { "below" };
                    let words = format!("you: {live:.0}{}, {side}", threshold.unit);
                    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                        ui.label(egui::RichText::new(words).small().color(palette.weak));
                    });
                }
            });
            ui.spacing_mut().slider_width = (ui.available_width() - 84.0).max(60.0);
            let slider = egui::Slider::new(&mut wanted, 0.0..=threshold.largest)
                .suffix(threshold.unit)
                .max_decimals(1)
                .step_by(if threshold.unit == " mm" { 0.5 } else { 1.0 });
            let response = ui.add(slider);
            response.widget_info(|| egui::WidgetInfo::slider(true, wanted, threshold.words));
            if (wanted - now).abs() > 1e-9 {
                self.change(&playing.choice, desk, |document| {
                    document.set_number(threshold.key, wanted);
                    Ok(())
                });
            }
            if response.drag_stopped() {
                self.settle();
            }
            if let Some(error) = self.fault_of(threshold.key) {
                ui.colored_label(palette.bad, format!("✖ {error}"));
            }
        }
    }

    /// What is wrong at a key's own line.
    fn fault_of(&self, key: &str) -> Option<String> {
        let opened = self.opened.as_ref()?;
        let faulty = opened.checked.as_ref().err()?;
        at_key(faulty, key)
    }
}

fn at_key(faulty: &Faulty, key: &str) -> Option<String> {
    faulty.faults.iter().find_map(|fault| {
        let (line, _) = faulty.line_column(fault.span.start);
        let text = faulty.text.lines().nth(line.checked_sub(1)?)?;
        let written = text.split('=').next()?.trim();
        (written == key).then(|| fault.message.clone())
    })
}

fn fresh_name<'a>(known: impl Iterator<Item = &'a str> + Clone) -> String {
    (1..)
        .map(|number| format!("region-{number}"))
        .find(|name| known.clone().all(|other| other != name))
        .unwrap_or_default()
}

fn last_press_ms(playing: &Playing) -> Option<f64> {
    let press = playing.story.last_press()?;
    Some(ms_from_nanos(press.length_ns(playing.story.now_ns)))
}

/// From the last release of an output to its next press.
fn last_gap_ms(playing: &Playing) -> Option<f64> {
    let presses = &playing.story.presses;
    let last = presses.back()?;
    let before = presses
        .iter()
        .rev()
        .skip(1)
        .find(|press| press.output == last.output)?;
    Some(ms_from_nanos(last.from_ns.saturating_sub(before.until_ns?)))
}

fn touch_age_ms(playing: &Playing) -> Option<f64> {
    let touch = playing.view.touches.last()?;
    Some(ms_from_nanos(
        playing.view.t_ns.saturating_sub(touch.since_ns),
    ))
}

/// How far the newest touch is from where it went down.
fn moved_mm(playing: &Playing) -> Option<f64> {
    let stroke = playing.story.strokes.back()?;
    let (first, last) = (stroke.moments.front()?, stroke.moments.back()?);
    let [dx, dy] = [0, 1].map(|i| last.place_mm[i] - first.place_mm[i]);
    Some(dx.hypot(dy))
}
