//! Binds a region to a key: the player presses the region on the pad, then the key.

use egui::Ui;

use super::{EditView, GameContext, keyboard};
use crate::gui::theme;

/// Progress of binding a region to a key.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum BindStep {
    /// Not binding.
    #[default]
    No,
    /// Waits for a press on the pad.
    Region,
    /// Waits for the key for this region.
    Key(String),
}

impl EditView {
    /// Takes the press or the key that the binding waits for.
    pub(super) fn update_binding(&mut self, ui: &Ui, game: GameContext<'_>) {
        let waits = self.bind_step != BindStep::No;
        if waits && ui.input_mut(|i| i.consume_key(egui::Modifiers::NONE, egui::Key::Escape)) {
            self.bind_step = BindStep::No;
        }
        match self.bind_step.clone() {
            BindStep::No => {}
            BindStep::Region => {
                if let Some(name) = self.touched_region(game) {
                    self.select_region(&name);
                    self.bind_step = BindStep::Key(name);
                }
            }
            BindStep::Key(region) => {
                let Some(output) = pressed_key(ui).and_then(keyboard::output_for_key) else {
                    return;
                };
                self.bind_step = BindStep::No;
                let output = output.to_string();
                self.bind(game, &region, &output);
                self.select_region(&region);
            }
        }
    }

    /// Name of the region under the first touch.
    fn touched_region(&self, game: GameContext<'_>) -> Option<String> {
        let touch = game.playing.view.touches.first()?;
        let profile = self.profile()?;
        let pad_mm = game.playing.pad.outline.size_mm();
        let seen = profile
            .settings
            .as_player_sees(touch.contact.centre_mm, pad_mm);
        let index = profile.region_at(seen, profile.settings.size_as_player_sees_mm(pad_mm))?;
        Some(profile.regions[index].name.clone())
    }

    pub(super) fn draw_bind_button(&mut self, ui: &mut Ui) {
        let label = match &self.bind_step {
            BindStep::No => "Bind: press the pad, then a key".to_owned(),
            BindStep::Region => "… press the region on the pad (Esc cancels)".to_owned(),
            BindStep::Key(region) => format!("… now press the key for `{region}` (Esc cancels)"),
        };
        let waits = self.bind_step != BindStep::No;
        let clicked = if waits {
            theme::primary(ui, &label).clicked()
        } else {
            ui.button(label).clicked()
        };
        if clicked {
            self.bind_step = if waits {
                BindStep::No
            } else {
                BindStep::Region
            };
        }
    }
}

/// The key pressed since the last repaint. It is consumed: it must not act on the window too.
fn pressed_key(ui: &Ui) -> Option<egui::Key> {
    ui.input_mut(|input| {
        let key = input.events.iter().find_map(|event| match event {
            egui::Event::Key {
                key,
                pressed: true,
                repeat: false,
                ..
            } => Some(*key),
            _ => None,
        })?;
        input.consume_key(egui::Modifiers::NONE, key);
        Some(key)
    })
}
