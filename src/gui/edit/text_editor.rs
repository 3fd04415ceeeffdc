//! The text of the profile in the window: every key can be written, and a file that is no TOML can be corrected.
//!
//! Invariant: a text that is valid TOML is the document; one that is not is kept here until it is corrected, and nothing is saved.

use egui::{Rect, TextEdit, Ui};

use super::document::Document;
use super::file::OpenProfile;
use super::text_draft::{TextDraft, syntax_error};
use super::{EditView, GameContext};
use crate::gui::theme;

/// Height of a line of the text and of its number: the font is the same.
const FONT: f32 = 13.0;

impl EditView {
    /// The button that shows the text, or the pad again.
    pub(super) fn draw_text_button(&mut self, ui: &mut Ui) {
        let label = match self.text_editor {
            Some(_) => "Show the pad",
            None => "Edit as text",
        };
        let can_hide = self.opened.is_some();
        if ui.add_enabled(can_hide, egui::Button::new(label)).clicked() {
            self.text_editor = match self.text_editor.take() {
                Some(_) => None,
                None => self.text().as_deref().map(TextDraft::new),
            };
        }
    }

    /// Draws the text in place of the pad.
    pub(super) fn draw_text(&mut self, ui: &mut Ui, room: Rect, game: GameContext<'_>) {
        let document = self.text();
        let marked = self.lines_with_mistakes();
        let Some(editor) = &mut self.text_editor else {
            return;
        };
        if let Some(document) = document
            && !editor.has_focus
            && editor.error.is_none()
        {
            // Undo, other fields and other programs change it too.
            editor.text = document;
        }
        let mut changed = false;
        ui.scope_builder(egui::UiBuilder::new().max_rect(room), |ui| {
            if let Some((line, message)) = &editor.error {
                let text = format!("✖ line {line}: {message}");
                let text = egui::RichText::new(text).color(theme::palette_of(ui).bad);
                ui.add(egui::Label::new(text).wrap());
            }
            changed = draw_lines(ui, editor, &marked);
        });
        if changed {
            self.take_text(game);
        }
    }

    /// Lines with mistakes, counted from 1.
    fn lines_with_mistakes(&self) -> Vec<usize> {
        let broken = self.text_editor.as_ref().and_then(TextDraft::broken_line);
        let checked = self.opened.as_ref().map(|opened| &opened.checked);
        let errors = checked.and_then(|checked| checked.as_ref().err());
        let lines = errors.into_iter().flat_map(|errors| {
            let faults = errors.diagnostics.iter();
            faults.map(|fault| errors.line_column(fault.span.start).0)
        });
        lines.chain(broken).collect()
    }

    /// Makes the text the document, if it is TOML.
    fn take_text(&mut self, game: GameContext<'_>) {
        let Some(editor) = &mut self.text_editor else {
            return;
        };
        editor.error = syntax_error(&editor.text);
        if editor.error.is_some() {
            return;
        }
        let text = editor.text.clone();
        if self.opened.is_some() {
            return self.change(game, |document| document.set_text(&text));
        }
        if let Ok(document) = Document::parse(&text) {
            self.opened = Some(OpenProfile::corrected(&self.argument, document, game));
            self.failed = None;
        }
    }
}

/// Line numbers, marks and the text; returns whether it was changed.
fn draw_lines(ui: &mut Ui, editor: &mut TextDraft, marked: &[usize]) -> bool {
    let palette = theme::palette_of(ui);
    let font = egui::FontId::monospace(FONT);
    let scroll = egui::ScrollArea::both()
        .id_salt("profile text")
        .auto_shrink(false);
    let shown = scroll.show(ui, |ui| {
        let row = ui.horizontal_top(|ui| {
            let mut numbers = egui::text::LayoutJob::default();
            for line in 1..=editor.text.split('\n').count() {
                let (mark, colour) = match marked.contains(&line) {
                    true => ("✖", palette.bad),
                    false => (" ", palette.weak),
                };
                let format = egui::TextFormat::simple(font.clone(), colour);
                numbers.append(&format!("{mark}{line:>4}\n"), 0.0, format);
            }
            ui.add_space(2.0);
            ui.vertical(|ui| {
                // The margin of a field of text.
                ui.add_space(2.0);
                ui.label(numbers);
            });
            // Lines are not wrapped: their numbers stand beside them.
            let mut layout = |ui: &Ui, text: &dyn egui::TextBuffer, _: f32| {
                let text = text.as_str().to_owned();
                let colour = theme::palette_of(ui).text;
                let job = egui::text::LayoutJob::simple(text, font.clone(), colour, f32::INFINITY);
                ui.painter().layout_job(job)
            };
            let field = TextEdit::multiline(&mut editor.text)
                .code_editor()
                .desired_width(f32::INFINITY)
                .layouter(&mut layout);
            let field = ui.add(field);
            field.widget_info(|| {
                egui::WidgetInfo::labeled(egui::Role::TextInput, true, "Text of the profile")
            });
            editor.has_focus = field.has_focus();
            field.changed()
        });
        row.inner
    });
    shown.inner
}
