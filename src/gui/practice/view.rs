//! The practice view: the level, and a panel with the press length and height of the last jumps.

use egui::{Align2, FontId, Rect, Sense, Ui, UiBuilder, Vec2, pos2, vec2};

use super::controls::GameAction;
use super::game::{Practice, RunStage};
use super::level::TILE;
use super::{chart, scene};
use crate::gui::theme::{self, Palette};

/// Width of the panel beside the level, and the window width from which it is beside, points.
const PANEL: f32 = 270.0;
const WIDE: f32 = 640.0;
/// Height of the panel below the level, share of the height.
const BELOW: f32 = 0.4;
/// Smallest height of the list of jumps beside the pad, points.
const MIN_JUMPS: f32 = 120.0;
/// Space between level and panel, points.
const GAP: f32 = 10.0;
/// Heights of the status line and of the panel's title, points.
const LINE: f32 = 34.0;
const TITLE: f32 = 24.0;

/// Draws something of the caller beside the level, such as the pad.
pub type DrawBeside<'a> = &'a mut dyn FnMut(&mut Ui, Rect);

/// Draws the practice level and advances its time.
#[derive(Clone, Debug, Default)]
pub struct PracticeView {
    /// Time of the last repaint, s.
    drawn_s: Option<f64>,
    /// Whether the game is paused: time stands still.
    pub paused: bool,
}

impl PracticeView {
    /// Draws the level and plays it for the time since the last repaint.
    pub fn ui(&mut self, ui: &mut Ui, practice: &mut Practice, beside: Option<DrawBeside<'_>>) {
        let now_s = ui.input(|input| input.time);
        let before_s = self.drawn_s.replace(now_s).unwrap_or(now_s);
        if !self.paused {
            practice.advance(now_s - before_s);
            if practice.is_moving() {
                ui.ctx().request_repaint();
            }
        }
        let palette = theme::palette_of(ui);
        let room = ui.available_rect_before_wrap();
        ui.advance_cursor_after_rect(room);
        let line = Rect::from_min_size(room.min, vec2(room.width(), LINE));
        draw_status(ui, line, practice, &palette);
        let below = Rect::from_min_max(pos2(room.left(), line.bottom() + 4.0), room.max);
        let (level, panel) = if room.width() >= WIDE {
            let split = below.right() - PANEL;
            (
                Rect::from_min_max(below.min, pos2(split - GAP, below.bottom())),
                Rect::from_min_max(pos2(split, below.top()), below.max),
            )
        } else {
            let split = below.bottom() - BELOW * below.height();
            (
                Rect::from_min_max(below.min, pos2(below.right(), split - GAP)),
                Rect::from_min_max(pos2(below.left(), split), below.max),
            )
        };
        draw_scene(ui, level, practice);
        let Some(beside) = beside else {
            draw_jumps(ui, panel, practice, &palette);
            return;
        };
        let side = panel.width().min(panel.height() - MIN_JUMPS).max(60.0);
        let (list, other) = if room.width() >= WIDE {
            panel.split_top_bottom_at_y(panel.bottom() - side)
        } else {
            panel.split_left_right_at_x(panel.right() - panel.height().min(0.5 * panel.width()))
        };
        draw_jumps(
            ui,
            list.with_max_y(list.bottom().min(other.bottom())),
            practice,
            &palette,
        );
        beside(ui, other.shrink(6.0));
    }
}

/// Time, coins, best time, falls, auto-walk and restart.
fn draw_status(ui: &mut Ui, room: Rect, practice: &mut Practice, palette: &Palette) {
    let mut line = ui.new_child(
        UiBuilder::new()
            .id_salt("practice-status")
            .max_rect(room)
            .layout(egui::Layout::left_to_right(egui::Align::Center)),
    );
    let big = |text: String| egui::RichText::new(text).size(20.0).strong();
    line.label(big(format!("{:.1} s", practice.time_s())).color(palette.text));
    let taken = practice.coins_taken.iter().filter(|taken| **taken).count();
    line.label(
        egui::RichText::new(format!("{taken} of {} coins", practice.coins_taken.len()))
            .color(palette.text),
    );
    if let Some(best) = practice.best_s() {
        line.label(egui::RichText::new(format!("best {best:.1} s")).color(palette.good));
    }
    if practice.falls > 0 {
        let falls = practice.falls;
        let word = if falls == 1 { "fall" } else { "falls" };
        line.label(egui::RichText::new(format!("{falls} {word}")).color(palette.weak));
    }
    line.with_layout(egui::Layout::right_to_left(egui::Align::Center), |line| {
        if line.button("Restart").clicked() {
            practice.restart();
        }
        let mut auto_walk = practice.auto_walk();
        line.checkbox(&mut auto_walk, "Auto-walk").on_hover_text(
            "Walks to the right on its own: you only press jump, with one finger or one switch.",
        );
        practice.set_auto_walk(auto_walk);
    });
}

/// The level, with a message over it while no run goes on.
fn draw_scene(ui: &mut Ui, room: Rect, practice: &Practice) {
    let response = ui.interact(room, ui.scope_id().with("practice-level"), Sense::hover());
    let message = message(practice);
    response.widget_info(|| {
        egui::WidgetInfo::labeled(
            egui::Role::Label,
            true,
            format!("Practice level: {message}"),
        )
    });
    let painter = ui.painter_at(room);
    let dark = ui.visuals().dark_mode;
    scene::draw_level(&painter, room, practice, dark);
    if practice.stage() != RunStage::Running {
        let font = FontId::proportional((room.height() / 18.0).clamp(15.0, 26.0));
        let colours = scene::colours(dark);
        let text = painter.layout(message, font, colours.ink, room.width() - 80.0);
        let size = text.size() + Vec2::new(32.0, 20.0);
        let card = Rect::from_center_size(
            pos2(room.center().x, room.top() + 0.24 * room.height()),
            size,
        );
        let ground = if dark {
            egui::Color32::from_black_alpha(140)
        } else {
            egui::Color32::from_white_alpha(190)
        };
        painter.rect_filled(card, 10.0, ground);
        painter.galley(card.min + vec2(16.0, 10.0), text, colours.ink);
    }
}

/// The state of the run and what to do next.
fn message(practice: &Practice) -> String {
    let label = |action| practice.controls.label(action);
    match practice.stage() {
        RunStage::Done { best } => {
            let time = practice.time_s();
            let result = if best { "your best" } else { "done" };
            format!("{time:.1} s: {result}. Jump to play again.")
        }
        RunStage::Running => format!("{:.1} s", practice.time_s()),
        RunStage::Ready => match (label(GameAction::Right), label(GameAction::Jump)) {
            (_, Some(jump)) if practice.auto_walk() => {
                format!("Press “{jump}” on the pad: the longer you press, the higher the jump.")
            }
            (Some(right), Some(jump)) => format!(
                "Press “{right}” on the pad to walk, “{jump}” to jump: the longer you press, the higher."
            ),
            _ => "This profile has no keys for walking right and jumping: choose another one, such as super-mario."
                .to_owned(),
        },
    }
}

/// The panel of the last jumps.
fn draw_jumps(ui: &mut Ui, room: Rect, practice: &Practice, palette: &Palette) {
    let painter = ui.painter_at(room);
    painter.rect_filled(room, 8.0, palette.card);
    let inner = room.shrink(12.0);
    let last = practice.jumps().next_back();
    let summary = last.map_or_else(
        || "no jump yet".to_owned(),
        |jump| {
            format!(
                "last jump: pressed {:.0} ms, {:.1} tiles high",
                jump.held_ms,
                jump.height_px / TILE
            )
        },
    );
    let response = ui.interact(room, ui.scope_id().with("practice-jumps"), Sense::hover());
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::Role::Label, true, format!("Jumps: {summary}"))
    });
    let wide = inner.width() > 2.0 * PANEL;
    let (list, plot) = if wide {
        inner.split_left_right_at_fraction(0.5)
    } else {
        let rows = ((inner.height() * 0.5 - TITLE) / chart::ROW)
            .floor()
            .max(1.0);
        inner.split_top_bottom_at_y(inner.top() + TITLE + rows * chart::ROW)
    };
    let middle = list.center().x;
    for (x, align, text) in [
        (middle - 6.0, Align2::RIGHT_TOP, "press"),
        (middle + 6.0, Align2::LEFT_TOP, "jump"),
    ] {
        painter.text(
            pos2(x, list.top()),
            align,
            text,
            FontId::proportional(12.5),
            palette.weak,
        );
    }
    let rows = Rect::from_min_max(list.min + vec2(0.0, TITLE), list.max);
    if last.is_none() {
        painter.text(
            rows.center_top() + vec2(0.0, 6.0),
            Align2::CENTER_TOP,
            "your jumps appear here",
            FontId::proportional(13.0),
            palette.weak,
        );
    }
    chart::draw_bars(&painter, rows, practice, palette);
    chart::draw_curves(&painter, plot.shrink2(vec2(0.0, 4.0)), practice, palette);
}
