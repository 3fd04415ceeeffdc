//! How long each press, how high each jump: side by side, and as dots on the curve that the level's physics draws.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, pos2, vec2};

use super::level::TILE;
use super::physics::{STEPS_PER_S, height};
use super::{Jump, Practice};
use crate::gui::theme::Palette;

/// The chart ends at this length of a press, ms, and at this height, tiles.
const LONGEST_MS: f32 = 600.0;
const HIGHEST: f32 = 5.5;
/// Steps up to which the curve is drawn.
const CURVE_STEPS: u32 = 36;
/// Height of a row of the list, points.
pub(super) const ROW: f32 = 24.0;

/// Bars of the last jumps, the newest on top: length of the press to the left, height of the jump to the right.
pub(super) fn bars(painter: &Painter, room: Rect, practice: &Practice, palette: &Palette) {
    let font = FontId::proportional(13.0);
    let middle = room.center().x;
    let half = room.width() / 2.0 - 6.0;
    let rows = (room.height() / ROW).floor() as usize;
    for (row, jump) in practice.jumps().rev().take(rows).enumerate() {
        let top = room.top() + row as f32 * ROW;
        let fade = if row == 0 { 1.0 } else { 0.72 };
        let press = (jump.held_ms as f32 / LONGEST_MS).clamp(0.02, 1.0);
        let high = (tiles(jump) / HIGHEST).clamp(0.02, 1.0);
        let bar = |left: f32, right: f32| {
            Rect::from_min_max(pos2(left, top + 3.0), pos2(right, top + ROW - 3.0))
        };
        // Words keep clear of the bars: each bar has the part of its half that words leave.
        let words = 62.0_f32.min(0.5 * half);
        let (left, right) = (
            bar(middle - 6.0 - press * (half - words), middle - 6.0),
            bar(middle + 6.0, middle + 6.0 + high * (half - words)),
        );
        painter.rect_filled(left, 3.0, palette.accent.gamma_multiply(fade));
        painter.rect_filled(right, 3.0, palette.good.gamma_multiply(fade));
        let ink = if row == 0 { palette.text } else { palette.weak };
        painter.text(
            left.left_center() - vec2(6.0, 0.0),
            Align2::RIGHT_CENTER,
            format!("{:.0} ms", jump.held_ms),
            font.clone(),
            ink,
        );
        painter.text(
            right.right_center() + vec2(6.0, 0.0),
            Align2::LEFT_CENTER,
            format!("{:.1} tiles", tiles(jump)),
            font.clone(),
            ink,
        );
    }
}

/// Height over length: the curves of a standing and of a running start, and the last jumps as dots.
pub(super) fn curve(painter: &Painter, room: Rect, practice: &Practice, palette: &Palette) {
    let font = FontId::proportional(11.5);
    let plot = Rect::from_min_max(room.min + vec2(20.0, 6.0), room.max - vec2(8.0, 20.0));
    if plot.width() < 40.0 || plot.height() < 40.0 {
        return;
    }
    let at = |ms: f32, tiles: f32| -> Pos2 {
        pos2(
            plot.left() + plot.width() * (ms / LONGEST_MS).clamp(0.0, 1.0),
            plot.bottom() - plot.height() * (tiles / HIGHEST).clamp(0.0, 1.0),
        )
    };
    let thin = Stroke::new(1.0, palette.line.gamma_multiply(0.7));
    for tiles in 0..=5 {
        let y = at(0.0, tiles as f32).y;
        painter.hline(plot.x_range(), y, thin);
        painter.text(
            pos2(plot.left() - 6.0, y),
            Align2::RIGHT_CENTER,
            tiles.to_string(),
            font.clone(),
            palette.weak,
        );
    }
    for ms in [0.0, 200.0, 400.0, 600.0] {
        let align = if ms == LONGEST_MS {
            Align2::RIGHT_TOP
        } else {
            Align2::CENTER_TOP
        };
        painter.text(
            at(ms, 0.0) + vec2(0.0, 4.0),
            align,
            format!("{ms:.0} ms"),
            font.clone(),
            palette.weak,
        );
    }
    for (running, colour) in [
        (false, palette.good),
        (true, palette.good.gamma_multiply(0.45)),
    ] {
        let points: Vec<Pos2> = (1..=CURVE_STEPS)
            .map(|steps| {
                let ms = 1000.0 * steps as f32 / STEPS_PER_S as f32;
                at(ms, (height(steps, running) / TILE) as f32)
            })
            .collect();
        if let Some(end) = points.last() {
            let word = if running { "running" } else { "standing" };
            painter.text(
                *end - vec2(2.0, 2.0),
                Align2::RIGHT_BOTTOM,
                word,
                font.clone(),
                palette.weak,
            );
        }
        painter.add(Shape::line(points, Stroke::new(2.0, colour)));
    }
    let count = practice.jumps().len();
    for (index, jump) in practice.jumps().enumerate() {
        let is_last = index + 1 == count;
        let place = at(jump.held_ms as f32, tiles(jump));
        let fill = if is_last {
            palette.accent
        } else {
            palette.accent.gamma_multiply(0.45)
        };
        let edge = if is_last {
            palette.text
        } else {
            Color32::TRANSPARENT
        };
        painter.circle(
            place,
            if is_last { 6.0 } else { 3.5 },
            fill,
            Stroke::new(1.5, edge),
        );
    }
}

fn tiles(jump: &Jump) -> f32 {
    (jump.height_px / TILE) as f32
}
