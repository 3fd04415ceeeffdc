//! The last five seconds as a strip chart: touches above, and below them one lane per output with its presses.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, Ui};

use crate::gui::history::{HISTORY_NS, Press, Stroke as TouchStroke};
use crate::gui::playing::Playing;
use crate::gui::regions::output_label;
use crate::gui::theme::{self, Palette};
use crate::types::{Nanos, Output, ms_from_nanos};

/// Width of the lane names, points.
const NAME_WIDTH: f32 = 52.0;
/// Largest height of a lane, points.
const MAX_LANE_HEIGHT: f32 = 16.0;
/// Largest number of lanes.
const MAX_LANES: usize = 8;
/// Share of the height for touches, if there are lanes below.
const TOUCH_SHARE: f32 = 0.42;

/// Draws the strip.
pub fn draw(ui: &mut Ui, room: Rect, playing: &Playing) {
    let palette = theme::palette_of(ui);
    let painter = ui.painter_at(room);
    painter.rect_filled(room, f32::from(theme::ROUND), palette.card);
    let body = Rect::from_min_max(
        room.min + egui::vec2(NAME_WIDTH, 6.0),
        room.max - egui::vec2(10.0, 18.0),
    );
    if body.height() < 16.0 || body.width() < 40.0 {
        return;
    }
    let chart = Chart {
        painter,
        palette,
        body,
        left: room.left() + 10.0,
        now_ns: playing.history.now_ns,
    };
    chart.seconds();
    let outputs = pressed_outputs(playing);
    let share = if outputs.is_empty() { 1.0 } else { TOUCH_SHARE };
    let touch_height = body.height() * share;
    chart.name(body.top() + touch_height / 2.0, "touches", false);
    for (index, stroke) in playing.history.strokes.iter().enumerate() {
        let y = body.top() + touch_height * (0.2 + 0.6 * (index % 4) as f32 / 4.0);
        chart.touch(y, stroke, ui.visuals().dark_mode);
    }
    let room = body.height() - touch_height;
    let height = (room / outputs.len().max(1) as f32).min(MAX_LANE_HEIGHT);
    for (index, output) in outputs.iter().enumerate() {
        let y = body.top() + touch_height + height * (index as f32 + 0.5);
        chart.name(
            y,
            &output_label(*output),
            playing.view.held.contains(output),
        );
        let line = Stroke::new(1.0, chart.palette.line.gamma_multiply(0.4));
        chart.painter.hline(body.x_range(), y, line);
        let presses = playing.history.presses.iter();
        for press in presses.filter(|press| press.output == *output) {
            chart.press(y, height, press);
        }
    }
}

struct Chart {
    painter: Painter,
    palette: Palette,
    /// The area of the chart without names.
    body: Rect,
    /// Left edge of the names.
    left: f32,
    now_ns: Nanos,
}

impl Chart {
    fn oldest_ns(&self) -> Nanos {
        self.now_ns.saturating_sub(HISTORY_NS)
    }

    fn x_of(&self, t_ns: Nanos) -> f32 {
        let age_ns = self.now_ns.saturating_sub(t_ns).min(HISTORY_NS);
        self.body.right() - age_ns as f32 / HISTORY_NS as f32 * self.body.width()
    }

    fn text(&self, at: Pos2, align: Align2, text: &str, size: f32, colour: Color32) {
        let font = FontId::proportional(size);
        self.painter.text(at, align, text, font, colour);
    }

    fn name(&self, y: f32, name: &str, strong: bool) {
        let colour = if strong {
            self.palette.text
        } else {
            self.palette.weak
        };
        let at = Pos2::new(self.left, y);
        self.text(at, Align2::LEFT_CENTER, name, 11.0, colour);
    }

    /// A vertical line per second, with its age.
    fn seconds(&self) {
        let line = Stroke::new(1.0, self.palette.line.gamma_multiply(0.6));
        for second in 0..=5u32 {
            let x = self.body.right() - self.body.width() * second as f32 / 5.0;
            self.painter.vline(x, self.body.y_range(), line);
            let (label, align) = if second == 0 {
                ("now".to_owned(), Align2::RIGHT_TOP)
            } else {
                (format!("-{second} s"), Align2::CENTER_TOP)
            };
            let at = Pos2::new(x, self.body.bottom() + 2.0);
            self.text(at, align, &label, 11.0, self.palette.weak);
        }
    }

    /// A touch as a ribbon, as thick as its force.
    fn touch(&self, y: f32, stroke: &TouchStroke, dark: bool) {
        let mut colour = theme::touch(stroke.id);
        if !dark {
            colour = colour.lerp_to_gamma(Color32::BLACK, 0.35);
        }
        let mut last_x: Option<f32> = None;
        let recent = |t_ns: Nanos| t_ns >= self.oldest_ns();
        for moment in stroke.moments.iter().filter(|m| recent(m.t_ns)) {
            let x = self.x_of(moment.t_ns);
            if let Some(from) = last_x {
                if x - from < 1.0 {
                    continue;
                }
                let line = Stroke::new(1.5 + 7.0 * moment.force, colour);
                let ends = [Pos2::new(from, y), Pos2::new(x, y)];
                self.painter.line_segment(ends, line);
            }
            last_x = Some(x);
        }
    }

    /// A press as a bar with its length.
    fn press(&self, y: f32, lane_height: f32, press: &Press) {
        if press.until_ns.is_some_and(|t_ns| t_ns < self.oldest_ns()) {
            return;
        }
        let left = self.x_of(press.from_ns);
        let right = self.x_of(press.until_ns.unwrap_or(self.now_ns));
        let half = lane_height * 0.38;
        let bar = Rect::from_min_max(
            Pos2::new(left, y - half),
            Pos2::new(right.max(left + 1.5), y + half),
        );
        self.painter.rect_filled(bar, 2.0, self.palette.accent);
        if lane_height > 10.0 && bar.width() > 34.0 {
            let length = format!("{:.0} ms", ms_from_nanos(press.length_ns(self.now_ns)));
            let colour = self.palette.on_accent;
            self.text(bar.center(), Align2::CENTER_CENTER, &length, 10.0, colour);
        }
    }
}

/// The outputs pressed within the strip, in the order of the profile.
fn pressed_outputs(playing: &Playing) -> Vec<Output> {
    let oldest_ns = playing.history.now_ns.saturating_sub(HISTORY_NS);
    let outputs = playing.view.profile.outputs.iter().copied();
    outputs
        .filter(|output| {
            playing.history.presses.iter().any(|press| {
                press.output == *output && press.until_ns.is_none_or(|until| until >= oldest_ns)
            })
        })
        .take(MAX_LANES)
        .collect()
}
