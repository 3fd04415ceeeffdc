//! The whole recording as a bar: drag or use the arrow keys to move in it; parts with touches are coloured.

use egui::{Key, Pos2, Rect, Response, Sense, Stroke, Ui, Vec2};

use super::player::{PARTS, Player};
use crate::gui::theme;

/// Draws the bar and handles its input.
pub(super) fn ui(ui: &mut Ui, player: &mut Player) {
    let size = Vec2::new(ui.available_width(), 26.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let position = player.frame as f64;
    response.widget_info(|| egui::WidgetInfo::slider(true, position, "Position in the recording"));
    let line = rect.shrink2(Vec2::new(8.0, 9.0));
    if let Some(at) = response.interact_pointer_pos() {
        let share = f64::from((at.x - line.left()) / line.width()).clamp(0.0, 1.0);
        player.seek((share * player.last() as f64).round() as usize);
    }
    player.has_bar_focus = response.has_focus();
    if player.has_bar_focus {
        handle_arrows(ui, &response, player);
    }
    let palette = theme::palette_of(ui);
    let painter = ui.painter();
    painter.rect_filled(line, 3.0, palette.line);
    let part = line.width() / PARTS as f32;
    for (index, _) in player.touched.iter().enumerate().filter(|(_, on)| **on) {
        let corner = Pos2::new(line.left() + part * index as f32, line.top());
        let part = Rect::from_min_size(corner, Vec2::new(part + 0.5, line.height()));
        painter.rect_filled(part, 0.0, palette.accent.gamma_multiply(0.6));
    }
    let frames = player.last().max(1) as f32;
    let x_of = |frame: usize| line.left() + line.width() * frame as f32 / frames;
    for mark in player.marks.into_iter().flatten() {
        painter.vline(x_of(mark), rect.y_range(), Stroke::new(2.0, palette.text));
    }
    let edge = if response.has_focus() { 3.0 } else { 1.5 };
    let knob = Pos2::new(x_of(player.frame), line.center().y);
    painter.circle(knob, 8.0, palette.accent, Stroke::new(edge, palette.text));
}

fn handle_arrows(ui: &Ui, response: &Response, player: &mut Player) {
    let (page, end) = (player.last().div_ceil(10) as isize, isize::MAX);
    let steps = [
        (Key::ArrowLeft, -1),
        (Key::ArrowRight, 1),
        (Key::PageDown, -page),
        (Key::PageUp, page),
        (Key::Home, -end),
        (Key::End, end),
    ];
    for (key, by) in steps {
        if ui.input(|input| input.key_pressed(key)) {
            player.step(by);
        }
    }
    let filter = egui::EventFilter {
        horizontal_arrows: true,
        ..Default::default()
    };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
}
