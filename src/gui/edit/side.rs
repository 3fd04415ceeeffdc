//! The side panel: the file with save and undo, mistakes in its text, the selected region and its bindings, timing, games.

use egui::{Button, Key, Modifiers, Ui};

use super::{EditView, GameContext};
use crate::gui::play::{UiAction, file_name};
use crate::gui::theme;

/// What a button or a key of the file card asks for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum FileCommand {
    Save,
    Undo,
    Redo,
}

impl EditView {
    pub(super) fn draw_side(&mut self, ui: &mut Ui, game: GameContext<'_>) -> Option<UiAction> {
        let wish = card(ui, |ui| self.draw_file(ui, game));
        if self.opened.is_none() {
            return wish;
        }
        // A part of its own: the ids of what is below do not depend on the number of mistakes.
        ui.scope(|ui| self.draw_mistakes(ui));
        card(ui, |ui| self.draw_region(ui, game));
        if self.selected.is_some() {
            card(ui, |ui| self.draw_bindings(ui, game));
        }
        card(ui, |ui| self.draw_timing(ui, game));
        card(ui, |ui| self.draw_match(ui, game));
        wish
    }

    fn draw_file(&mut self, ui: &mut Ui, game: GameContext<'_>) -> Option<UiAction> {
        let palette = theme::palette_of(ui);
        if let Some(why) = &self.failed {
            ui.colored_label(palette.bad, format!("✖ {why}"));
        }
        let Some(opened) = &self.opened else {
            if self.failed.is_none() {
                ui.label(format!("Opening {} …", self.argument));
            }
            return None;
        };
        let name = egui::RichText::new(file_name(&opened.argument)).size(18.0);
        ui.add(egui::Label::new(name).truncate())
            .on_hover_text(&opened.argument);
        // Always one line: the first change moves nothing.
        let (state, colour) = match (opened.is_unsaved(), &self.saved_as) {
            (true, _) => ("● not saved".to_owned(), palette.warn),
            (false, Some(file)) => (format!("✔ saved: {file}"), palette.good),
            (false, None) => ("no changes".to_owned(), palette.weak),
        };
        let text = egui::RichText::new(&state).color(colour);
        ui.add(egui::Label::new(text).truncate())
            .on_hover_text(state);
        if opened.is_shipped() {
            ui.weak("A shipped profile: saving makes your own copy.");
        }
        let manages = self.draw_own_profile_buttons(ui, game);
        if manages.is_some() {
            return manages;
        }
        let others: Vec<String> = self.drafts.arguments().map(file_name).collect();
        if !others.is_empty() {
            let text = format!("Also not saved: {}", others.join(", "));
            ui.add(egui::Label::new(egui::RichText::new(text).color(palette.warn)).wrap());
        }
        let command = self
            .draw_file_buttons(ui)
            .or_else(|| self.file_shortcut(ui));
        self.draw_text_button(ui);
        if let Some(notice) = &self.notice {
            ui.add(egui::Label::new(egui::RichText::new(notice).color(palette.warn)).wrap());
        }
        match command? {
            FileCommand::Save => return self.save(ui.ctx(), game),
            FileCommand::Undo => self.change(game, |document| {
                document.undo();
                Ok(())
            }),
            FileCommand::Redo => self.change(game, |document| {
                document.redo();
                Ok(())
            }),
        }
        if let Some(selected) = self.selected.clone() {
            self.select_region(&selected);
        }
        None
    }

    fn can_save(&self) -> bool {
        self.is_unsaved() && self.profile().is_some()
    }

    fn draw_file_buttons(&self, ui: &mut Ui) -> Option<FileCommand> {
        let opened = self.opened.as_ref()?;
        let save = if opened.is_shipped() {
            "Save my copy"
        } else {
            "Save"
        };
        let (can_undo, can_redo) = (opened.document.can_undo(), opened.document.can_redo());
        let mut command = None;
        ui.horizontal_wrapped(|ui| {
            for (label, enabled, keys, pressed) in [
                (save, self.can_save(), "Ctrl+S", FileCommand::Save),
                ("⟲ Undo", can_undo, "Ctrl+Z", FileCommand::Undo),
                ("⟳ Redo", can_redo, "Ctrl+Shift+Z", FileCommand::Redo),
            ] {
                let button = ui.add_enabled(enabled, Button::new(label));
                if button.on_hover_text(keys).clicked() {
                    command = Some(pressed);
                }
            }
        });
        command
    }

    fn file_shortcut(&self, ui: &Ui) -> Option<FileCommand> {
        let pressed = |modifiers, key| ui.input_mut(|i| i.consume_key(modifiers, key));
        if pressed(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z) {
            Some(FileCommand::Redo)
        } else if pressed(Modifiers::COMMAND, Key::Z) {
            Some(FileCommand::Undo)
        } else if self.can_save() && pressed(Modifiers::COMMAND, Key::S) {
            Some(FileCommand::Save)
        } else {
            None
        }
    }

    /// All mistakes in the text, with their lines.
    fn draw_mistakes(&self, ui: &mut Ui) {
        let Some(Err(errors)) = self.opened.as_ref().map(|opened| opened.checked.as_ref()) else {
            return;
        };
        let palette = theme::palette_of(ui);
        for fault in &errors.diagnostics {
            let (line, _) = errors.line_column(fault.span.start);
            ui.colored_label(palette.bad, format!("✖ line {line}: {}", fault.message));
            if let Some(help) = &fault.help {
                ui.weak(help);
            }
        }
    }
}

/// Draws into a card as wide as the panel.
fn card<R>(ui: &mut Ui, contents: impl FnOnce(&mut Ui) -> R) -> R {
    theme::card(ui)
        .show(ui, |ui| {
            ui.set_width(ui.available_width());
            contents(ui)
        })
        .inner
}
