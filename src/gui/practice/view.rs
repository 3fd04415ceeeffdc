//! The practice view: the level, and beside it how long each press was and how high each jump.

use egui::{Align2, FontId, Rect, Sense, Ui, UiBuilder, Vec2, pos2, vec2};

use super::{Deed, Practice, Stage, chart, scene};
use crate::gui::theme::{self, Palette};

/// The panel beside the level, points, where the room is wide enough for both.
const PANEL: f32 = 270.0;
const WIDE: f32 = 640.0;
/// The panel under it, as a share of the height.
const UNDER: f32 = 0.4;
/// What the list of jumps keeps beside the pad, points.
const LEAST_JUMPS: f32 = 120.0;
/// Room between both.
const GAP: f32 = 10.0;
/// Heights of the line above the level and of the title of a panel.
const LINE: f32 = 34.0;
const TITLE: f32 = 24.0;

/// Draws something of the caller's into a room beside the level.
pub type Beside<'a> = &'a mut dyn FnMut(&mut Ui, Rect);

/// Draws the practice level and lets its time run.
#[derive(Clone, Debug, Default)]
pub struct PracticeView {
    /// When it was drawn last, by egui's time, s.
    drawn_s: Option<f64>,
    /// Whether time stands still: the game is paused.
    pub paused: bool,
}

impl PracticeView {
    /// Draws the level into the room that is left, and plays it on by the time since it was drawn last.
    ///
    /// `beside` draws something of the caller's into a room of its own: the pad, say.
    pub fn ui(&mut self, ui: &mut Ui, practice: &mut Practice, beside: Option<Beside<'_>>) {
        let now_s = ui.input(|input| input.time);
        let before_s = self.drawn_s.replace(now_s).unwrap_or(now_s);
        if !self.paused {
            practice.advance(now_s - before_s);
            if practice.moves() {
                ui.ctx().request_repaint();
            }
        }
        let palette = theme::of(ui);
        let room = ui.available_rect_before_wrap();
        ui.advance_cursor_after_rect(room);
        let line = Rect::from_min_size(room.min, vec2(room.width(), LINE));
        status(ui, line, practice, &palette);
        let below = Rect::from_min_max(pos2(room.left(), line.bottom() + 4.0), room.max);
        let (level, panel) = if room.width() >= WIDE {
            let split = below.right() - PANEL;
            (
                Rect::from_min_max(below.min, pos2(split - GAP, below.bottom())),
                Rect::from_min_max(pos2(split, below.top()), below.max),
            )
        } else {
            let split = below.bottom() - UNDER * below.height();
            (
                Rect::from_min_max(below.min, pos2(below.right(), split - GAP)),
                Rect::from_min_max(pos2(below.left(), split), below.max),
            )
        };
        picture(ui, level, practice);
        let Some(beside) = beside else {
            jumps(ui, panel, practice, &palette);
            return;
        };
        let side = panel.width().min(panel.height() - LEAST_JUMPS).max(60.0);
        let (own, other) = if room.width() >= WIDE {
            panel.split_top_bottom_at_y(panel.bottom() - side)
        } else {
            panel.split_left_right_at_x(panel.right() - panel.height().min(0.5 * panel.width()))
        };
        jumps(
            ui,
            own.with_max_y(own.bottom().min(other.bottom())),
            practice,
            &palette,
        );
        beside(ui, other.shrink(6.0));
    }
}

/// Time, coins, best time, and the button that begins anew.
fn status(ui: &mut Ui, room: Rect, practice: &mut Practice, palette: &Palette) {
    let mut line = ui.new_child(
        UiBuilder::new()
            .id_salt("practice-status")
            .max_rect(room)
            .layout(egui::Layout::left_to_right(egui::Align::Center)),
    );
    let big = |text: String| egui::RichText::new(text).size(20.0).strong();
    line.label(big(format!("{:.1} s", practice.time_s())).color(palette.text));
    let taken = practice.taken().iter().filter(|taken| **taken).count();
    line.label(
        egui::RichText::new(format!("{taken} of {} coins", practice.taken().len()))
            .color(palette.text),
    );
    if let Some(best) = practice.best_s() {
        line.label(egui::RichText::new(format!("best {best:.1} s")).color(palette.good));
    }
    if practice.falls() > 0 {
        let falls = practice.falls();
        let word = if falls == 1 { "fall" } else { "falls" };
        line.label(egui::RichText::new(format!("{falls} {word}")).color(palette.weak));
    }
    line.with_layout(egui::Layout::right_to_left(egui::Align::Center), |line| {
        if line.button("Begin anew").clicked() {
            practice.restart();
        }
        let mut walks = practice.walks();
        line.checkbox(&mut walks, "Walk by itself")
            .on_hover_text("One finger or one switch plays: only jumps are pressed");
        practice.set_walks(walks);
    });
}

/// The level, with what there is to say upon it.
fn picture(ui: &mut Ui, room: Rect, practice: &Practice) {
    let response = ui.interact(room, ui.scope_id().with("practice-level"), Sense::hover());
    let said = said(practice);
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::Role::Label, true, format!("Practice level: {said}"))
    });
    let painter = ui.painter_at(room);
    let dark = ui.visuals().dark_mode;
    scene::draw(&painter, room, practice, dark);
    let hint = match practice.stage() {
        Stage::Running => None,
        _ => Some(said),
    };
    if let Some(hint) = hint {
        let font = FontId::proportional((room.height() / 18.0).clamp(15.0, 26.0));
        let colours = scene::colours(dark);
        let words = painter.layout(hint, font, colours.ink, room.width() - 80.0);
        let size = words.size() + Vec2::new(32.0, 20.0);
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
        painter.galley(card.min + vec2(16.0, 10.0), words, colours.ink);
    }
}

/// What there is to say.
fn said(practice: &Practice) -> String {
    let named = |deed| practice.controls().told(deed);
    match practice.stage() {
        Stage::Done { best } => {
            let time = practice.time_s();
            let praise = if best { "your best" } else { "done" };
            format!("{time:.1} s: {praise}. Jump to play again.")
        }
        Stage::Running => format!("{:.1} s", practice.time_s()),
        Stage::Ready => match (named(Deed::Right), named(Deed::Jump)) {
            (_, Some(jump)) if practice.walks() => {
                format!("Press “{jump}” on the pad: the longer you press, the higher the jump.")
            }
            (Some(right), Some(jump)) => format!(
                "Press “{right}” on the pad to walk, “{jump}” to jump: the longer you press, the higher."
            ),
            _ => "This profile has no keys that walk right and jump: choose another, such as super-mario."
                .to_owned(),
        },
    }
}

/// The panel of the jumps.
fn jumps(ui: &mut Ui, room: Rect, practice: &Practice, palette: &Palette) {
    let painter = ui.painter_at(room);
    painter.rect_filled(room, 8.0, palette.card);
    let inner = room.shrink(12.0);
    let last = practice.jumps().next_back();
    let words = last.map_or_else(
        || "no jump yet".to_owned(),
        |jump| {
            format!(
                "last jump: pressed {:.0} ms, {:.1} tiles high",
                jump.held_ms,
                jump.height_px / super::TILE
            )
        },
    );
    let response = ui.interact(room, ui.scope_id().with("practice-jumps"), Sense::hover());
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::Role::Label, true, format!("Jumps: {words}"))
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
            "each jump shows here",
            FontId::proportional(13.0),
            palette.weak,
        );
    }
    chart::bars(&painter, rows, practice, palette);
    chart::curve(&painter, plot.shrink2(vec2(0.0, 4.0)), practice, palette);
}
