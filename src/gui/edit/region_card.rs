//! The regions of the profile; place, size and output of the selected one.

use egui::Ui;

use super::{EditView, GameContext};
use crate::gui::theme;
use crate::gui::timing_settings::clicked_steps;
use crate::profile::{Profile, Region, Shape};
use crate::types::Output;

/// Steps of the buttons beside a place or size, percent of the pad.
const PERCENT_STEP: f64 = 1.0;
/// Place and size of a new region, fractions of the pad.
const NEW_REGION: [f64; 4] = [0.4, 0.4, 0.2, 0.2];

impl EditView {
    pub(super) fn draw_region(&mut self, ui: &mut Ui, game: GameContext<'_>) {
        theme::title(ui, "Region");
        let Some(profile) = self.profile().cloned() else {
            ui.label("Fix the file first.");
            return;
        };
        self.draw_region_list(ui, &profile, game);
        self.draw_bind_button(ui);
        let selected = self.selected.as_deref();
        match profile.regions.iter().find(|r| Some(&*r.name) == selected) {
            Some(region) => {
                self.draw_grid_hint(ui, &region.name);
                self.draw_numbers(ui, region, game);
                self.draw_output(ui, &region.name, game);
            }
            None => {
                ui.weak(
                    "Select a region here or on the pad. Drag it to move it, an edge to resize it.",
                );
            }
        }
    }

    fn draw_region_list(&mut self, ui: &mut Ui, profile: &Profile, game: GameContext<'_>) {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            for region in &profile.regions {
                let is_selected = self.selected.as_deref() == Some(&region.name);
                if ui.selectable_label(is_selected, &region.name).clicked() {
                    self.select_region(&region.name);
                }
            }
            let new = ui.button("+ New");
            if new.on_hover_text("a new region in the middle").clicked() {
                let name = unused_name(profile);
                self.change(game, |document| document.add_region(&name, NEW_REGION));
                self.select_region(&name);
            }
        });
    }

    /// Place and size in percent of the pad.
    fn draw_numbers(&mut self, ui: &mut Ui, region: &Region, game: GameContext<'_>) {
        let name = &region.name;
        ui.horizontal_wrapped(|ui| {
            for (key, number) in numbers(&region.shape) {
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
                let by = PERCENT_STEP * clicked_steps(ui, &format!("{key} of {name}"));
                percent = (percent + by).clamp(0.0, 100.0);
                if (response.changed() || by != 0.0) && !self.ask_if_in_grid(name) {
                    self.change(game, |document| {
                        document.set_region(name, &[(key, percent / 100.0)])
                    });
                }
                let is_released = ui.input(|input| input.pointer.any_released());
                if is_released || response.lost_focus() {
                    self.end_change();
                }
            }
        });
    }

    /// The output that a press of the region drives, as text, with its error below.
    fn draw_output(&mut self, ui: &mut Ui, region: &str, game: GameContext<'_>) {
        let response = ui.horizontal_wrapped(|ui| {
            let label = ui.label("presses");
            let field = egui::TextEdit::singleline(&mut self.output_text)
                .desired_width(100.0)
                .hint_text("key:space");
            let field = ui.add(field).labelled_by(label.id);
            self.draw_choose_button(ui);
            field
        });
        theme::keep_focus_on_enter(ui, &response.inner);
        if response.inner.changed() {
            match self.output_text.trim().parse::<Output>() {
                Ok(output) => {
                    self.output_error = None;
                    let output = output.to_string();
                    self.bind(game, region, &output);
                    self.end_change();
                }
                Err(error) => {
                    let guess = error.suggestion.as_ref();
                    let guess = guess.map_or(String::new(), |s| format!(": did you mean `{s}`?"));
                    self.output_error = Some(format!("{error}{guess}"));
                }
            }
        }
        if let Some(error) = &self.output_error {
            let text = egui::RichText::new(format!("✖ {error}")).color(theme::palette_of(ui).bad);
            ui.add(egui::Label::new(text).wrap());
        }
    }
}

/// The numbers of a shape that can be edited, under their keys in the file.
fn numbers(shape: &Shape) -> Vec<(&'static str, f64)> {
    match *shape {
        Shape::Rect { x, y, w, h } | Shape::Ellipse { x, y, w, h } => {
            vec![("x", x), ("y", y), ("w", w), ("h", h)]
        }
        Shape::Circle { x, y, r } => vec![("x", x), ("y", y), ("r", r)],
        Shape::Polygon(_) => Vec::new(),
    }
}

fn unused_name(profile: &Profile) -> String {
    (1..)
        .map(|number| format!("region-{number}"))
        .find(|name| profile.regions.iter().all(|region| region.name != *name))
        .unwrap_or_default()
}
