//! The list of the last presses, newest first, each with a bar of its length.

use egui::{Align2, Color32, FontId, Pos2, Rect, Sense, Stroke, Ui, Vec2};

use crate::gui::history::Press;
use crate::gui::playing::Playing;
use crate::gui::regions::output_label;
use crate::gui::theme::{self, Palette};
use crate::types::ms_from_nanos;

/// A press of this length fills its bar, ms.
const FULL_BAR_MS: f64 = 600.0;
/// Number of presses listed.
const LISTED: usize = 7;

/// Draws the list.
pub(super) fn ui(ui: &mut Ui, playing: &Playing) {
    let palette = theme::palette_of(ui);
    let history = &playing.history;
    for press in history.presses.iter().rev().take(LISTED) {
        let length_ms = ms_from_nanos(press.length_ns(history.now_ns));
        row(ui, &palette, press, length_ms);
    }
    if history.presses.is_empty() {
        ui.weak("Every press appears here.");
    }
}

fn row(ui: &mut Ui, palette: &Palette, press: &Press, length_ms: f64) {
    let (rect, _) = ui.allocate_exact_size(Vec2::new(ui.available_width(), 18.0), Sense::hover());
    let painter = ui.painter_at(rect);
    let text = |x: f32, align: Align2, text: String, colour: Color32| {
        let at = Pos2::new(x, rect.center().y);
        painter.text(at, align, text, FontId::monospace(12.0), colour)
    };
    let name = output_label(press.output);
    text(rect.left(), Align2::LEFT_CENTER, name, palette.text);
    let length = format!("{length_ms:.0} ms");
    let right = rect.left() + 118.0;
    let left = text(right, Align2::RIGHT_CENTER, length, palette.weak).right() + 8.0;
    let share = (length_ms / FULL_BAR_MS).clamp(0.01, 1.0) as f32;
    let bar = Rect::from_min_max(
        Pos2::new(left, rect.top() + 4.0),
        Pos2::new(left + (rect.right() - left) * share, rect.bottom() - 4.0),
    );
    if press.until_ns.is_some() {
        painter.rect_filled(bar, 3.0, palette.accent.gamma_multiply(0.75));
    } else {
        let line = Stroke::new(1.5, palette.text);
        painter.rect(bar, 3.0, palette.accent, line, egui::StrokeKind::Inside);
    }
}
