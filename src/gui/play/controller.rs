//! What is held, drawn as what the game sees: a NES pad, an Xbox pad, keys.
//!
//! What is held is filled and pressed in; it does not depend on colour alone.

use egui::{Align2, Color32, CornerRadius, FontId, Painter, Pos2, Rect, Stroke, Ui, Vec2};

use crate::gui::playing::Playing;
use crate::gui::regions::{outputs, short};
use crate::gui::theme::{self, Palette};
use crate::profile::Profile;
use crate::types::{Axis, Button, Output};

/// A button of the NES pad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nes {
    /// Jumps.
    A,
    /// Runs.
    B,
    /// Select.
    Select,
    /// Start.
    Start,
    /// The cross.
    Up,
    /// The cross.
    Down,
    /// The cross.
    Left,
    /// The cross.
    Right,
}

/// Which pad suits a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// The regions are those of a NES pad.
    Nes,
    /// It drives a gamepad.
    Xbox,
    /// Keys alone.
    Keys,
}

/// The pad that suits a profile.
#[must_use]
pub fn face(profile: &Profile) -> Face {
    let drives_pad = profile
        .outputs
        .iter()
        .any(|output| matches!(output, Output::Button(_)));
    if drives_pad {
        return Face::Xbox;
    }
    let roles = profile
        .outputs
        .iter()
        .filter(|output| nes_role(profile, **output).is_some())
        .count();
    if roles >= 4 { Face::Nes } else { Face::Keys }
}

/// What an output is on a NES pad, by the name of the region that drives it.
#[must_use]
pub fn nes_role(profile: &Profile, output: Output) -> Option<Nes> {
    let binding = profile
        .bindings
        .iter()
        .find(|binding| outputs(profile, binding).any(|driven| driven == output))?;
    let region = binding.regions.first()?;
    Some(match profile.regions.get(*region)?.name.as_str() {
        "jump" | "a" => Nes::A,
        "run" | "b" => Nes::B,
        "select" => Nes::Select,
        "start" => Nes::Start,
        "up" => Nes::Up,
        "down" => Nes::Down,
        "left" => Nes::Left,
        "right" => Nes::Right,
        _ => return None,
    })
}

/// Draws what is held.
pub fn draw(ui: &mut Ui, playing: &Playing) {
    let profile = &playing.view.profile;
    let held = &playing.view.held;
    let width = ui.available_width();
    match face(profile) {
        Face::Nes => {
            let (rect, _) = ui.allocate_exact_size(
                Vec2::new(width, (width * 0.4).min(112.0)),
                egui::Sense::hover(),
            );
            let down: Vec<Nes> = held
                .iter()
                .filter_map(|output| nes_role(profile, *output))
                .collect();
            nes(ui.painter(), rect, &down, &theme::of(ui));
        }
        Face::Xbox => {
            let (rect, _) = ui.allocate_exact_size(
                Vec2::new(width, (width * 0.52).min(150.0)),
                egui::Sense::hover(),
            );
            xbox(
                ui.painter(),
                rect,
                held,
                &playing.story.axes,
                &theme::of(ui),
            );
        }
        Face::Keys => {}
    }
    caps(ui, playing);
}

/// Every output as a cap.
fn caps(ui: &mut Ui, playing: &Playing) {
    let palette = theme::of(ui);
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = Vec2::splat(5.0);
        for output in &playing.view.profile.outputs {
            let down = playing.view.held.contains(output);
            let name = short(*output);
            let colour = if down {
                palette.on_accent
            } else {
                palette.text
            };
            let font = FontId::monospace(12.5);
            let galley = ui.painter().layout_no_wrap(name, font, colour);
            let size = Vec2::new((galley.size().x + 14.0).max(28.0), 28.0);
            let (rect, response) = ui.allocate_exact_size(size, egui::Sense::hover());
            let words = format!("{output}, {}", if down { "held" } else { "up" });
            response.widget_info(|| {
                egui::WidgetInfo::selected(egui::Role::Label, true, down, words.clone())
            });
            response.on_hover_text(output.to_string());
            // A cap stands two points above the table; held, it lies on it.
            let top = rect.translate(Vec2::new(0.0, if down { 0.0 } else { -2.0 }));
            let fill = if down {
                palette.accent
            } else {
                ui.visuals().widgets.inactive.bg_fill
            };
            ui.painter()
                .rect_filled(rect, CornerRadius::same(5), palette.line);
            ui.painter().rect(
                top,
                CornerRadius::same(5),
                fill,
                Stroke::new(1.0, if down { palette.accent } else { palette.line }),
                egui::StrokeKind::Inside,
            );
            ui.painter()
                .galley(top.center() - galley.size() / 2.0, galley, colour);
        }
    });
}

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

    fn round(&self, x: f32, y: f32, radius: f32, down: bool, words: &str) {
        let (fill, line) = self.colours(down);
        self.painter
            .circle(self.at(x, y), radius * self.unit, fill, line);
        self.words(x, y, words, down, radius * 1.1);
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

    fn words(&self, x: f32, y: f32, words: &str, down: bool, size: f32) {
        let colour = if down {
            self.palette.on_accent
        } else {
            self.palette.weak
        };
        let font = FontId::proportional((size * self.unit).max(9.0));
        self.painter
            .text(self.at(x, y), Align2::CENTER_CENTER, words, font, colour);
    }

    fn cross(&self, x: f32, y: f32, arm: f32, down: [bool; 4]) {
        // Right, up, left, down.
        let ways = [(1.0, 0.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 1.0)];
        for ((dx, dy), down) in ways.into_iter().zip(down) {
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

/// A drawing of so many units, in the middle of a room.
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

fn nes(painter: &Painter, room: Rect, down: &[Nes], palette: &Palette) {
    let pen = pen(painter, palette, room, 26.0, 11.0);
    let body = Rect::from_min_max(pen.at(0.3, 0.3), pen.at(25.7, 10.7));
    painter.rect(
        body,
        6.0,
        palette.ground.lerp_to_gamma(palette.line, 0.35),
        Stroke::new(1.2, palette.line),
        egui::StrokeKind::Inside,
    );
    let is = |button: Nes| down.contains(&button);
    pen.cross(
        5.2,
        5.5,
        2.1,
        [Nes::Right, Nes::Up, Nes::Left, Nes::Down].map(is),
    );
    pen.bar(11.4, 7.0, 2.6, 1.2, is(Nes::Select));
    pen.bar(15.0, 7.0, 2.6, 1.2, is(Nes::Start));
    pen.words(11.4, 5.2, "select", false, 1.15);
    pen.words(15.0, 5.2, "start", false, 1.15);
    pen.round(19.0, 6.4, 1.7, is(Nes::B), "B");
    pen.round(23.0, 6.4, 1.7, is(Nes::A), "A");
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
    fn the_nes_pad_suits_the_nes_profiles_and_every_output_has_its_button() {
        let profile = still::profile();
        assert_eq!(face(&profile), Face::Nes);
        let role = |name: &str| nes_role(&profile, name.parse().expect("an output"));
        assert_eq!(role("key:f"), Some(Nes::A));
        assert_eq!(role("key:d"), Some(Nes::B));
        assert_eq!(role("key:left"), Some(Nes::Left));
        assert_eq!(role("key:q"), None);
    }

    #[test]
    fn a_profile_that_drives_a_gamepad_gets_one() {
        let text = "schema = 1\nname = \"p\"\nabout = \"p\"\n[[region]]\nname = \"r\"\nshape = \"rect\"\nx = 0.0\ny = 0.0\nw = 0.5\nh = 0.5\n[[binding]]\nregion = \"r\"\noutput = \"pad:a\"\n";
        let profile = Profile::from_toml("p", text).expect("sound");
        assert_eq!(face(&profile), Face::Xbox);
    }
}
