//! The controller that the game sees, with held buttons filled and pressed in: an NES pad, an Xbox pad, or keys.

use egui::{Align2, Color32, CornerRadius, FontId, Painter, Pos2, Rect, Stroke, Ui, Vec2};

use crate::gui::playing::Playing;
use crate::gui::regions::{output_label, outputs_of_binding};
use crate::gui::theme::{self, Palette};
use crate::profile::Profile;
use crate::types::{Axis, Button, Output};

/// The controller that is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Controller {
    /// The regions are those of an NES pad.
    Nes,
    /// The profile has gamepad buttons.
    Xbox,
    /// Keys only.
    Keys,
}

/// The controller that suits a profile.
pub fn controller(profile: &Profile) -> Controller {
    let drives_pad = profile
        .outputs
        .iter()
        .any(|output| matches!(output, Output::Button(_)));
    if drives_pad {
        return Controller::Xbox;
    }
    let nes_buttons = profile
        .outputs
        .iter()
        .filter(|output| nes_button(profile, **output).is_some())
        .count();
    if nes_buttons >= 4 {
        Controller::Nes
    } else {
        Controller::Keys
    }
}

/// The NES button of an output, by the name of the region that presses it.
pub fn nes_button(profile: &Profile, output: Output) -> Option<Button> {
    let binding = profile
        .bindings
        .iter()
        .find(|binding| outputs_of_binding(profile, binding).any(|driven| driven == output))?;
    let region = binding.regions.first()?;
    Some(match profile.regions.get(*region)?.name.as_str() {
        "jump" | "a" => Button::A,
        "run" | "b" => Button::B,
        "select" => Button::Select,
        "start" => Button::Start,
        "up" => Button::Up,
        "down" => Button::Down,
        "left" => Button::Left,
        "right" => Button::Right,
        _ => return None,
    })
}

/// Draws the controller, and every output as a keycap.
pub fn draw(ui: &mut Ui, playing: &Playing) {
    let profile = &playing.view.profile;
    let held = &playing.view.held;
    let palette = theme::palette_of(ui);
    let width = ui.available_width();
    let allocate = |ui: &mut Ui, share: f32, max_height: f32| {
        let size = Vec2::new(width, (width * share).min(max_height));
        ui.allocate_exact_size(size, egui::Sense::hover()).0
    };
    match controller(profile) {
        Controller::Nes => {
            let room = allocate(ui, 0.4, 112.0);
            let buttons = held.iter().filter_map(|held| nes_button(profile, *held));
            nes(ui.painter(), room, &buttons.collect::<Vec<_>>(), &palette);
        }
        Controller::Xbox => {
            let room = allocate(ui, 0.52, 150.0);
            xbox(ui.painter(), room, held, &playing.history.axes, &palette);
        }
        Controller::Keys => {}
    }
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = Vec2::splat(5.0);
        for output in &profile.outputs {
            keycap(ui, &palette, *output, held.contains(output));
        }
    });
}

/// An output as a keycap, which rises by two points; a held one is pressed in.
fn keycap(ui: &mut Ui, palette: &Palette, output: Output, down: bool) {
    let (text, fill, edge, lift) = if down {
        (palette.on_accent, palette.accent, palette.accent, 0.0)
    } else {
        let fill = ui.visuals().widgets.inactive.bg_fill;
        (palette.text, fill, palette.line, 2.0)
    };
    let font = FontId::monospace(12.5);
    let galley = ui
        .painter()
        .layout_no_wrap(output_label(output), font, text);
    let size = Vec2::new((galley.size().x + 14.0).max(28.0), 28.0);
    let (rect, response) = ui.allocate_exact_size(size, egui::Sense::hover());
    let label = format!("{output}, {}", if down { "held" } else { "up" });
    response
        .widget_info(|| egui::WidgetInfo::selected(egui::Role::Label, true, down, label.clone()));
    response.on_hover_text(output.to_string());
    let corners = CornerRadius::same(5);
    let top = rect.translate(Vec2::new(0.0, -lift));
    let line = Stroke::new(1.0, edge);
    let painter = ui.painter();
    painter.rect_filled(rect, corners, palette.line);
    painter.rect(top, corners, fill, line, egui::StrokeKind::Inside);
    painter.galley(top.center() - galley.size() / 2.0, galley, text);
}

/// Draws in units of the controller drawing.
struct Pen<'a> {
    painter: &'a Painter,
    palette: &'a Palette,
    origin: Pos2,
    unit: f32,
}

impl Pen<'_> {
    fn at(&self, x: f32, y: f32) -> Pos2 {
        self.origin + Vec2::new(x, y) * self.unit
    }

    fn colours(&self, down: bool) -> (Color32, Stroke) {
        if down {
            (self.palette.accent, Stroke::new(2.0, self.palette.text))
        } else {
            (self.palette.ground, Stroke::new(1.2, self.palette.weak))
        }
    }

    fn round(&self, x: f32, y: f32, radius: f32, down: bool, label: &str) {
        let (fill, line) = self.colours(down);
        self.painter
            .circle(self.at(x, y), radius * self.unit, fill, line);
        self.label(x, y, label, down, radius * 1.1);
    }

    fn bar(&self, x: f32, y: f32, w: f32, h: f32, down: bool) {
        let (fill, line) = self.colours(down);
        let rect = Rect::from_center_size(self.at(x, y), Vec2::new(w, h) * self.unit);
        self.painter.rect(
            rect,
            h * self.unit * 0.3,
            fill,
            line,
            egui::StrokeKind::Inside,
        );
    }

    fn label(&self, x: f32, y: f32, label: &str, down: bool, size: f32) {
        let colour = if down {
            self.palette.on_accent
        } else {
            self.palette.weak
        };
        let font = FontId::proportional((size * self.unit).max(9.0));
        self.painter
            .text(self.at(x, y), Align2::CENTER_CENTER, label, font, colour);
    }

    fn cross(&self, x: f32, y: f32, arm: f32, down: [bool; 4]) {
        // Right, up, left, down.
        let directions = [(1.0, 0.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 1.0)];
        for ((dx, dy), down) in directions.into_iter().zip(down) {
            self.bar(x + dx * arm, y + dy * arm, arm, arm, down);
            let tip = self.at(x + dx * arm * 1.28, y + dy * arm * 1.28);
            let (along, across) = (Vec2::new(dx, dy), Vec2::new(-dy, dx));
            let size = arm * self.unit * 0.2;
            let colour = if down {
                self.palette.on_accent
            } else {
                self.palette.weak
            };
            self.painter.add(egui::Shape::convex_polygon(
                vec![
                    tip,
                    tip - along * size * 1.4 + across * size,
                    tip - along * size * 1.4 - across * size,
                ],
                colour,
                Stroke::NONE,
            ));
        }
    }
}

/// A pen for a drawing of `w` by `h` units, centred in `room`.
fn pen<'a>(painter: &'a Painter, palette: &'a Palette, room: Rect, w: f32, h: f32) -> Pen<'a> {
    let unit = (room.width() / w).min(room.height() / h);
    let size = Vec2::new(w, h) * unit;
    Pen {
        painter,
        palette,
        origin: room.center() - size / 2.0,
        unit,
    }
}

fn nes(painter: &Painter, room: Rect, down: &[Button], palette: &Palette) {
    let pen = pen(painter, palette, room, 26.0, 11.0);
    let body = Rect::from_min_max(pen.at(0.3, 0.3), pen.at(25.7, 10.7));
    painter.rect(
        body,
        6.0,
        palette.ground.lerp_to_gamma(palette.line, 0.35),
        Stroke::new(1.2, palette.line),
        egui::StrokeKind::Inside,
    );
    let is = |button: Button| down.contains(&button);
    pen.cross(
        5.2,
        5.5,
        2.1,
        [Button::Right, Button::Up, Button::Left, Button::Down].map(is),
    );
    pen.bar(11.4, 7.0, 2.6, 1.2, is(Button::Select));
    pen.bar(15.0, 7.0, 2.6, 1.2, is(Button::Start));
    pen.label(11.4, 5.2, "select", false, 1.15);
    pen.label(15.0, 5.2, "start", false, 1.15);
    pen.round(19.0, 6.4, 1.7, is(Button::B), "B");
    pen.round(23.0, 6.4, 1.7, is(Button::A), "A");
}

fn xbox(painter: &Painter, room: Rect, held: &[Output], axes: &[(Axis, f32)], palette: &Palette) {
    let pen = pen(painter, palette, room, 26.0, 14.0);
    let body = Rect::from_min_max(pen.at(0.5, 1.8), pen.at(25.5, 13.8));
    painter.rect(
        body,
        5.0 * pen.unit,
        palette.ground.lerp_to_gamma(palette.line, 0.35),
        Stroke::new(1.2, palette.line),
        egui::StrokeKind::Inside,
    );
    let is = |button: Button| held.contains(&Output::Button(button));
    let value = |axis: Axis| {
        axes.iter()
            .find(|(known, _)| *known == axis)
            .map_or(0.0, |(_, value)| *value)
    };
    pen.bar(5.0, 1.5, 5.0, 1.3, is(Button::LeftShoulder));
    pen.bar(21.0, 1.5, 5.0, 1.3, is(Button::RightShoulder));
    for (x, axis) in [(5.0, Axis::LeftTrigger), (21.0, Axis::RightTrigger)] {
        let share = value(axis).clamp(0.0, 1.0);
        pen.bar(x, 0.4, 5.0, 0.6, false);
        if share > 0.02 {
            pen.bar(x - 2.5 + 2.5 * share, 0.4, 5.0 * share, 0.6, true);
        }
    }
    for (x, y, button, sides) in [
        (5.0, 5.4, Button::LeftStick, [Axis::LeftX, Axis::LeftY]),
        (17.0, 10.0, Button::RightStick, [Axis::RightX, Axis::RightY]),
    ] {
        pen.round(x, y, 2.3, false, "");
        let [dx, dy] = sides.map(value);
        let moved = is(button) || dx.abs() > 0.05 || dy.abs() > 0.05;
        pen.round(x + dx * 1.1, y - dy * 1.1, 1.3, moved, "");
    }
    pen.cross(
        9.2,
        10.0,
        1.25,
        [Button::Right, Button::Up, Button::Left, Button::Down].map(is),
    );
    pen.round(21.0, 7.6, 1.15, is(Button::A), "A");
    pen.round(23.1, 5.5, 1.15, is(Button::B), "B");
    pen.round(18.9, 5.5, 1.15, is(Button::X), "X");
    pen.round(21.0, 3.9, 1.15, is(Button::Y), "Y");
    pen.round(11.0, 5.4, 0.8, is(Button::Select), "");
    pen.round(13.0, 4.4, 1.0, is(Button::Guide), "");
    pen.round(15.0, 5.4, 0.8, is(Button::Start), "");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gui::still;

    #[test]
    fn a_nes_profile_is_drawn_as_a_nes_pad() {
        let profile = still::profile();
        assert_eq!(controller(&profile), Controller::Nes);
        let button = |name: &str| nes_button(&profile, name.parse().expect("an output"));
        assert_eq!(button("key:f"), Some(Button::A));
        assert_eq!(button("key:d"), Some(Button::B));
        assert_eq!(button("key:left"), Some(Button::Left));
        assert_eq!(button("key:q"), None);
    }

    #[test]
    fn a_gamepad_profile_is_drawn_as_an_xbox_pad() {
        let text = "schema = 1\nname = \"p\"\nabout = \"p\"\n[[region]]\nname = \"r\"\nshape = \"rect\"\nx = 0.0\ny = 0.0\nw = 0.5\nh = 0.5\n[[binding]]\nregion = \"r\"\noutput = \"pad:a\"\n";
        let profile = Profile::from_toml("p", text).expect("sound");
        assert_eq!(controller(&profile), Controller::Xbox);
    }
}
