//! A keyboard, a gamepad and a mouse to click: chooses the output of a region without a keyboard at hand.

use egui::{Button, Context, Id, Modal, Ui, Vec2};

use super::{EditView, GameContext};
use crate::gui::regions::output_label;
use crate::gui::theme;
use crate::types::{self, MouseButton, Output};

/// Keys in the rows of a keyboard, by their names in profiles.
const ROWS: [&str; 7] = [
    "escape f1 f2 f3 f4 f5 f6 f7 f8 f9 f10 f11 f12",
    "grave 1 2 3 4 5 6 7 8 9 0 minus equal backspace",
    "tab q w e r t y u i o p left-bracket right-bracket",
    "caps-lock a s d f g h j k l semicolon apostrophe enter",
    "left-shift z x c v b n m comma period slash right-shift",
    "left-ctrl left-alt space right-alt right-ctrl insert delete home end",
    "left up down right page-up page-down",
];
/// Size of a key, points. Keys with longer names are wider.
const KEY: Vec2 = Vec2::new(34.0, 30.0);

/// A title and the outputs below it.
type Group = (&'static str, Vec<Output>);

fn groups() -> Vec<Group> {
    let buttons = types::Button::ALL.iter().copied().map(Output::Button);
    let mouse = MouseButton::ALL.iter().copied().map(Output::Mouse);
    vec![("Gamepad", buttons.collect()), ("Mouse", mouse.collect())]
}

/// The keys of a row; names that this version does not know are left out.
fn keys(row: &str) -> impl Iterator<Item = Output> + '_ {
    row.split(' ')
        .filter_map(|name| name.parse().ok().map(Output::Key))
}

impl EditView {
    /// The button that opens the chooser.
    pub(super) fn draw_choose_button(&mut self, ui: &mut Ui) {
        let button = ui.button("Choose …");
        if button
            .on_hover_text("A keyboard, a gamepad and a mouse to click")
            .clicked()
        {
            self.chooses_output = true;
        }
    }

    /// Draws the chooser while it is open, and binds the selected region to what is clicked.
    pub(super) fn draw_chooser(&mut self, ctx: &Context, game: GameContext<'_>) {
        let Some(region) = self.selected.clone().filter(|_| self.chooses_output) else {
            self.chooses_output = false;
            return;
        };
        let mut chosen = None;
        let modal = Modal::new(Id::unique("output chooser")).show(ctx, |ui| {
            let room = ctx.content_rect().size() - Vec2::splat(80.0);
            ui.set_width(room.x.min(620.0));
            ui.heading(format!("What does `{region}` press?"));
            egui::ScrollArea::vertical()
                .min_scrolled_height((room.y - 90.0).max(120.0))
                .max_height((room.y - 90.0).max(120.0))
                .auto_shrink([false, true])
                .show(ui, |ui| {
                    ui.spacing_mut().item_spacing = Vec2::splat(4.0);
                    for row in ROWS {
                        ui.horizontal_wrapped(|ui| keycaps(ui, keys(row), &mut chosen));
                    }
                    for (title, outputs) in groups() {
                        theme::title(ui, title);
                        ui.horizontal_wrapped(|ui| {
                            keycaps(ui, outputs.into_iter(), &mut chosen);
                        });
                    }
                });
            ui.add_space(6.0);
            if ui.button("Cancel").clicked() {
                ui.close();
            }
        });
        if let Some(output) = chosen {
            self.bind(game, &region, &output.to_string());
            self.end_change();
            self.select_region(&region);
        }
        if chosen.is_some() || modal.should_close() {
            self.chooses_output = false;
        }
    }
}

fn keycaps(ui: &mut Ui, outputs: impl Iterator<Item = Output>, chosen: &mut Option<Output>) {
    for output in outputs {
        let key = ui.add(Button::new(output_label(output)).min_size(KEY));
        let words = output.to_string().replace(':', " ");
        key.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, words.clone()));
        if key.on_hover_text(output.to_string()).clicked() {
            *chosen = Some(output);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_of_the_rows_has_a_name_in_profiles() {
        for name in ROWS.iter().flat_map(|row| row.split(' ')) {
            assert!(name.parse::<types::Key>().is_ok(), "{name}");
        }
    }
}
