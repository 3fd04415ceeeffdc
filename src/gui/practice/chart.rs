//! Press length and jump height: bars of the last jumps, and dots on the curves of the level's physics.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, pos2, vec2};

use super::game::Practice;
use super::jumps::Jump;
use super::level::TILE;
use super::physics::{STEPS_PER_S, jump_height};
use crate::gui::theme::Palette;

/// Ends of the axes: press length, ms, and jump height, tiles.
const MAX_MS: f32 = 600.0;
const MAX_TILES: f32 = 5.5;
/// Longest press of the curves, steps.
const CURVE_STEPS: u32 = 36;
/// Height of a row of bars, points.
pub(super) const ROW: f32 = 24.0;
/// Smallest width and height of the curves, points.
const MIN_PLOT: f32 = 40.0;

/// Bars of the last jumps, the newest on top: press length to the left, jump height to the right.
pub(super) fn draw_bars(painter: &Painter, room: Rect, practice: &Practice, palette: &Palette) {
    let font = FontId::proportional(13.0);
    let middle = room.center().x;
    let half = room.width() / 2.0 - 6.0;
    // Each bar leaves room for its text.
    let bar_width = half - 62.0_f32.min(0.5 * half);
    let rows = (room.height() / ROW).floor() as usize;
    for (row, jump) in practice.jumps().rev().take(rows).enumerate() {
        let top = room.top() + row as f32 * ROW;
        let fade = if row == 0 { 1.0 } else { 0.72 };
        let length = (jump.held_ms as f32 / MAX_MS).clamp(0.02, 1.0);
        let height = (height_tiles(jump) / MAX_TILES).clamp(0.02, 1.0);
        let bar = |left: f32, right: f32| {
            Rect::from_min_max(pos2(left, top + 3.0), pos2(right, top + ROW - 3.0))
        };
        let left = bar(middle - 6.0 - length * bar_width, middle - 6.0);
        let right = bar(middle + 6.0, middle + 6.0 + height * bar_width);
        painter.rect_filled(left, 3.0, palette.accent.gamma_multiply(fade));
        painter.rect_filled(right, 3.0, palette.good.gamma_multiply(fade));
        let ink = if row == 0 { palette.text } else { palette.weak };
        let label = |at, align, text| painter.text(at, align, text, font.clone(), ink);
        label(
            left.left_center() - vec2(6.0, 0.0),
            Align2::RIGHT_CENTER,
            format!("{:.0} ms", jump.held_ms),
        );
        label(
            right.right_center() + vec2(6.0, 0.0),
            Align2::LEFT_CENTER,
            format!("{:.1} tiles", height_tiles(jump)),
        );
    }
}

/// Jump height over press length: the curves of standing and running jumps, and the last jumps as dots.
pub(super) fn draw_curves(painter: &Painter, room: Rect, practice: &Practice, palette: &Palette) {
    let plot = Rect::from_min_max(room.min + vec2(20.0, 6.0), room.max - vec2(8.0, 20.0));
    if plot.width() < MIN_PLOT || plot.height() < MIN_PLOT {
        return;
    }
    let plot = Plot {
        painter,
        rect: plot,
        palette,
        font: FontId::proportional(11.5),
    };
    plot.draw_axes();
    plot.draw_curve("standing", false, palette.good);
    plot.draw_curve("running", true, palette.good.gamma_multiply(0.45));
    let mut jumps = practice.jumps();
    let last = jumps.next_back();
    for jump in jumps {
        let fill = palette.accent.gamma_multiply(0.45);
        plot.draw_jump(jump, 3.5, fill, Color32::TRANSPARENT);
    }
    if let Some(last) = last {
        plot.draw_jump(last, 6.0, palette.accent, palette.text);
    }
}

struct Plot<'a> {
    painter: &'a Painter,
    rect: Rect,
    palette: &'a Palette,
    font: FontId,
}

impl Plot<'_> {
    fn at(&self, ms: f32, tiles: f32) -> Pos2 {
        pos2(
            self.rect.left() + self.rect.width() * (ms / MAX_MS).clamp(0.0, 1.0),
            self.rect.bottom() - self.rect.height() * (tiles / MAX_TILES).clamp(0.0, 1.0),
        )
    }

    fn draw_text(&self, at: Pos2, align: Align2, text: impl ToString) {
        self.painter
            .text(at, align, text, self.font.clone(), self.palette.weak);
    }

    fn draw_axes(&self) {
        let line = Stroke::new(1.0, self.palette.line.gamma_multiply(0.7));
        for tiles in 0..=5 {
            let left = self.at(0.0, tiles as f32);
            self.painter.hline(self.rect.x_range(), left.y, line);
            self.draw_text(left - vec2(6.0, 0.0), Align2::RIGHT_CENTER, tiles);
        }
        for ms in [0.0, 200.0, 400.0, MAX_MS] {
            let align = if ms == MAX_MS {
                Align2::RIGHT_TOP
            } else {
                Align2::CENTER_TOP
            };
            let below = self.at(ms, 0.0) + vec2(0.0, 4.0);
            self.draw_text(below, align, format!("{ms:.0} ms"));
        }
    }

    fn draw_curve(&self, label: &str, running: bool, colour: Color32) {
        let points: Vec<Pos2> = (1..=CURVE_STEPS)
            .map(|steps| {
                let ms = 1000.0 * steps as f32 / STEPS_PER_S as f32;
                self.at(ms, (jump_height(steps, running) / TILE) as f32)
            })
            .collect();
        if let Some(end) = points.last() {
            self.draw_text(*end - vec2(2.0, 2.0), Align2::RIGHT_BOTTOM, label);
        }
        self.painter
            .add(Shape::line(points, Stroke::new(2.0, colour)));
    }

    fn draw_jump(&self, jump: &Jump, radius: f32, fill: Color32, edge: Color32) {
        let at = self.at(jump.held_ms as f32, height_tiles(jump));
        self.painter
            .circle(at, radius, fill, Stroke::new(1.5, edge));
    }
}

fn height_tiles(jump: &Jump) -> f32 {
    (jump.height_px / TILE) as f32
}
