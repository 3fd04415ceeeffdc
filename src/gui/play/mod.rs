//! The play view: the pad, the last five seconds, held outputs, and the most severe problem with its fix.

pub mod controller;
mod presses;
mod side;
pub mod strip;

pub use super::request::{Names, UiAction, file_name};

use egui::{Pos2, Rect, Response, Sense, Stroke, Ui, Vec2};

use super::pad_nodes;
use super::picture::{Picture, PictureLayers};
use super::place::PadTransform;
use super::playing::Playing;
use super::press::handle_input;
use super::problem::{Problem, Severity};
use super::regions::output_label;
use super::theme;

/// Side panel: share of the width, minimum and maximum, points.
const SIDE: (f32, f32, f32) = (0.28, 232.0, 330.0);
/// Strip chart: share of the height, minimum and maximum, points.
const STRIP: (f32, f32, f32) = (0.18, 66.0, 124.0);
/// Height of the problem line, points.
const PROBLEM_LINE: f32 = 40.0;
/// Gap between parts, points.
const GAP: f32 = 10.0;

/// Draws the view; returns what the player requested.
pub fn ui(
    ui: &mut Ui,
    picture: &mut Picture,
    playing: &mut Playing,
    problem: Option<&Problem>,
    names: &Names,
) -> Option<UiAction> {
    let mut action = None;
    let room = ui.available_rect_before_wrap();
    let side = (room.width() * SIDE.0).clamp(SIDE.1, SIDE.2);
    let strip_height = (room.height() * STRIP.0).clamp(STRIP.1, STRIP.2);
    let middle = room.right() - side - GAP;
    let problem_room = Rect::from_min_max(room.min, Pos2::new(middle, room.top() + PROBLEM_LINE));
    let strip_room = Rect::from_min_max(
        Pos2::new(room.left(), room.bottom() - strip_height),
        Pos2::new(middle, room.bottom()),
    );
    let pad_room = Rect::from_min_max(
        problem_room.left_bottom() + Vec2::new(0.0, GAP),
        strip_room.right_top() - Vec2::new(0.0, GAP),
    );
    let side_room = Rect::from_min_max(Pos2::new(middle + GAP, room.top()), room.max);

    ui.scope_builder(egui::UiBuilder::new().max_rect(problem_room), |ui| {
        action = problem_line(ui, problem);
    });
    pad(ui, pad_room, picture, playing, true);
    strip::draw(ui, strip_room, playing);
    ui.scope_builder(egui::UiBuilder::new().max_rect(side_room), |ui| {
        egui::ScrollArea::vertical()
            .id_salt("play side")
            .auto_shrink(false)
            .show(ui, |ui| {
                ui.set_width(side - 4.0);
                action = side::ui(ui, playing, names).or(action.take());
            });
    });
    ui.advance_cursor_after_rect(room);
    action
}

/// The pad; the simulated one can be pressed.
pub fn pad(
    ui: &mut Ui,
    room: Rect,
    picture: &mut Picture,
    playing: &mut Playing,
    scale: bool,
) -> (Response, PadTransform) {
    let shown = PictureLayers {
        image: true,
        regions: true,
        electrodes: false,
        scale,
    };
    let place = picture.draw(ui, room, playing, &playing.view.profile, shown);
    let response = ui.interact(
        place.rect,
        ui.scope_id().with("pad"),
        Sense::click_and_drag(),
    );
    let label = pad_label(playing);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, label.clone()));
    if response.has_focus() {
        let line = Stroke::new(2.0, theme::palette_of(ui).accent);
        ui.painter()
            .rect_stroke(place.rect.expand(3.0), 5.0, line, egui::StrokeKind::Outside);
        ui.memory_mut(|memory| {
            // Arrows and Escape stay with the pad; Tab moves the focus on.
            memory.set_focus_lock_filter(
                response.id,
                egui::EventFilter {
                    tab: false,
                    horizontal_arrows: true,
                    vertical_arrows: true,
                    escape: true,
                },
            );
        });
    }
    let view = &playing.view;
    pad_nodes::add(ui, response.id, &place, &view.profile, &view.held);
    handle_input(ui, &response, &place, playing);
    (response, place)
}

/// The label of the pad for screen readers.
fn pad_label(playing: &Playing) -> String {
    let touches = match playing.view.touches.len() {
        0 => "no touch".to_owned(),
        1 => "1 touch".to_owned(),
        count => format!("{count} touches"),
    };
    let held: Vec<String> = playing.view.held.iter().map(|o| output_label(*o)).collect();
    if held.is_empty() {
        format!("Pad: {touches}")
    } else {
        format!("Pad: {touches}, holding {}", held.join(" "))
    }
}

/// The most severe problem; returns its fix when the button is clicked.
fn problem_line(ui: &mut Ui, problem: Option<&Problem>) -> Option<UiAction> {
    let palette = theme::palette_of(ui);
    let text = problem.map_or("No problems", |problem| problem.text.as_str());
    let (mark, colour) = match problem.map(|problem| problem.severity) {
        None => ("✔", palette.good),
        Some(Severity::Hint) => ("ℹ", palette.weak),
        Some(Severity::Warning) => ("⚠", palette.warn),
        Some(Severity::Error) => ("⛔", palette.bad),
    };
    let room = ui.max_rect();
    ui.painter()
        .rect_filled(room, f32::from(theme::ROUND), palette.card);
    let edge = Rect::from_min_size(room.min, Vec2::new(4.0, room.height()));
    ui.painter().rect_filled(edge, 2.0, colour);
    let inner = room.shrink2(Vec2::new(12.0, 4.0));
    let layout = egui::Layout::right_to_left(egui::Align::Center);
    let builder = egui::UiBuilder::new().max_rect(inner).layout(layout);
    let clicked = ui.scope_builder(builder, |ui| {
        let fix = problem.and_then(|problem| problem.fix.as_ref());
        let clicked = fix.filter(|(label, _)| theme::primary(ui, label).clicked());
        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
            ui.label(egui::RichText::new(mark).color(colour).size(17.0));
            ui.add(egui::Label::new(text).truncate())
                .on_hover_text(text);
        });
        clicked.map(|(_, action)| action.clone())
    });
    clicked.inner
}
