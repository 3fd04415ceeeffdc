//! The last five seconds as a strip: touches above, what they pressed below, one lane an output.

use egui::{Align2, FontId, Pos2, Rect, Stroke, Ui};

use crate::gui::playing::Playing;
use crate::gui::regions::short;
use crate::gui::story::STORY_NS;
use crate::gui::theme;
use crate::types::{Nanos, Output, ms_from_nanos};

/// Room for the names of the lanes, points.
const NAMES: f32 = 52.0;
/// A lane is at most so high, points.
const HIGHEST_LANE: f32 = 16.0;
/// Outputs that get a lane.
const MOST_LANES: usize = 8;

/// Draws the strip.
pub fn draw(ui: &mut Ui, room: Rect, playing: &Playing) {
    let palette = theme::of(ui);
    let painter = ui.painter_at(room);
    painter.rect_filled(room, f32::from(theme::ROUND), palette.card);
    let body = Rect::from_min_max(
        room.min + egui::vec2(NAMES, 6.0),
        room.max - egui::vec2(10.0, 18.0),
    );
    if body.height() < 16.0 || body.width() < 40.0 {
        return;
    }
    let now_ns = playing.story.now_ns;
    let x_of = |t_ns: Nanos| {
        let age = now_ns.saturating_sub(t_ns).min(STORY_NS) as f32 / STORY_NS as f32;
        body.right() - age * body.width()
    };
    let font = FontId::proportional(11.0);
    for second in 0..=5u32 {
        let x = body.right() - body.width() * second as f32 / 5.0;
        let line = Stroke::new(1.0, palette.line.gamma_multiply(0.6));
        painter.vline(x, body.y_range(), line);
        let (words, align) = if second == 0 {
            ("now".to_owned(), Align2::RIGHT_TOP)
        } else {
            (format!("-{second} s"), Align2::CENTER_TOP)
        };
        painter.text(
            Pos2::new(x, body.bottom() + 2.0),
            align,
            words,
            font.clone(),
            palette.weak,
        );
    }
    let lanes = lanes(playing);
    let touch_share = if lanes.is_empty() { 1.0 } else { 0.42 };
    let above = Rect::from_min_max(
        body.min,
        Pos2::new(body.right(), body.top() + body.height() * touch_share),
    );
    let name = |y: f32, words: &str, strong: bool| {
        let colour = if strong { palette.text } else { palette.weak };
        let at = Pos2::new(room.left() + 10.0, y);
        painter.text(at, Align2::LEFT_CENTER, words, font.clone(), colour);
    };
    name(above.center().y, "touches", false);
    let oldest_ns = now_ns.saturating_sub(STORY_NS);
    for (row, stroke) in playing.story.strokes.iter().enumerate() {
        // Force as the height of a ribbon, the place from left to right as its place in the lane.
        let colour = theme::touch(stroke.id);
        let colour = if ui.visuals().dark_mode {
            colour
        } else {
            colour.lerp_to_gamma(egui::Color32::BLACK, 0.35)
        };
        let y = above.top() + above.height() * (0.2 + 0.6 * (row % 4) as f32 / 4.0);
        let mut last: Option<(f32, f32)> = None;
        for moment in stroke.moments.iter().filter(|m| m.t_ns >= oldest_ns) {
            let (x, force) = (x_of(moment.t_ns), moment.force);
            if let Some((from, _)) = last {
                if x - from < 1.0 {
                    continue;
                }
                let line = Stroke::new(1.5 + 7.0 * force, colour);
                painter.line_segment([Pos2::new(from, y), Pos2::new(x, y)], line);
            }
            last = Some((x, force));
        }
    }
    let lane = ((body.bottom() - above.bottom()) / lanes.len().max(1) as f32).min(HIGHEST_LANE);
    for (row, output) in lanes.iter().enumerate() {
        let y = above.bottom() + lane * (row as f32 + 0.5);
        let held = playing.view.held.contains(output);
        name(y, &short(*output), held);
        painter.hline(
            body.x_range(),
            y,
            Stroke::new(1.0, palette.line.gamma_multiply(0.4)),
        );
        for press in &playing.story.presses {
            if press.output != *output || press.until_ns.is_some_and(|t| t < oldest_ns) {
                continue;
            }
            let bar = Rect::from_min_max(
                Pos2::new(x_of(press.from_ns), y - lane * 0.38),
                Pos2::new(
                    x_of(press.until_ns.unwrap_or(now_ns)).max(x_of(press.from_ns) + 1.5),
                    y + lane * 0.38,
                ),
            );
            painter.rect_filled(bar, 2.0, palette.accent);
            let ms = format!("{:.0} ms", ms_from_nanos(press.length_ns(now_ns)));
            if lane > 10.0 && bar.width() > 34.0 {
                let at = bar.center();
                painter.text(
                    at,
                    Align2::CENTER_CENTER,
                    ms,
                    FontId::proportional(10.0),
                    palette.on_accent,
                );
            }
        }
    }
}

/// Outputs that get a lane: those that were pressed, in the order of the profile.
fn lanes(playing: &Playing) -> Vec<Output> {
    let oldest_ns = playing.story.now_ns.saturating_sub(STORY_NS);
    let outputs = playing.view.profile.outputs.iter().copied();
    outputs
        .filter(|output| {
            playing.story.presses.iter().any(|press| {
                press.output == *output && press.until_ns.is_none_or(|until| until >= oldest_ns)
            })
        })
        .take(MOST_LANES)
        .collect()
}
