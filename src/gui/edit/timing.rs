//! Timing and tremor settings of the edited profile as sliders.

use egui::Ui;

use super::{EditView, GameContext};
use crate::gui::theme;
use crate::gui::timing_settings::{HintPlace, SETTINGS, draw_slider};

impl EditView {
    pub(super) fn draw_timing(&mut self, ui: &mut Ui, game: GameContext<'_>) {
        theme::title(ui, "Timing, beside what you do now");
        let Some(settings) = self.profile().map(|profile| profile.settings.clone()) else {
            return;
        };
        for setting in &SETTINGS {
            let value = (setting.value)(&settings);
            let live = (setting.live)(game.playing);
            let (wanted, is_final) = draw_slider(ui, setting, value, live, HintPlace::Hover);
            if (wanted - value).abs() > 1e-9 {
                self.change(game, |document| {
                    document.set_number(setting.key, wanted);
                    Ok(())
                });
            }
            if is_final {
                self.end_change();
            }
            if let Some(error) = self.mistake_in_line_of(setting.key) {
                ui.colored_label(theme::palette_of(ui).bad, format!("✖ {error}"));
            }
        }
    }

    /// The mistake in the line of a key.
    fn mistake_in_line_of(&self, key: &str) -> Option<String> {
        let errors = self.opened.as_ref()?.checked.as_ref().err()?;
        errors.diagnostics.iter().find_map(|fault| {
            let (line, _) = errors.line_column(fault.span.start);
            let text = errors.text.lines().nth(line.checked_sub(1)?)?;
            let written = text.split('=').next()?.trim();
            (written == key).then(|| fault.message.clone())
        })
    }
}
