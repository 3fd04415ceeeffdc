//! The play view: the pad, the last five seconds, held outputs, and the most severe problem with its fix.

pub mod controller;
mod presses;
mod side;
pub mod strip;

pub use super::request::{Names, UiAction, file_name};

use egui::{Pos2, Rect, Response, Sense, Stroke, Ui, Vec2};

use super::focus_ring::follow_focus;
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
/// Share of the height for the pad in a narrow window.
const PAD_SHARE: f32 = 0.75;
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
    is_pad_open: bool,
) -> Option<UiAction> {
    let mut action = None;
    let room = ui.available_rect_before_wrap();
    if room.width() < theme::COLUMN {
        return column(ui, picture, playing, problem, names, is_pad_open);
    }
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
                action = side::ui(ui, playing, names, is_pad_open).or(action.take());
                follow_focus(ui);
            });
    });
    ui.advance_cursor_after_rect(room);
    action
}

/// The parts below each other, which scroll.
fn column(
    ui: &mut Ui,
    picture: &mut Picture,
    playing: &mut Playing,
    problem: Option<&Problem>,
    names: &Names,
    is_pad_open: bool,
) -> Option<UiAction> {
    let room = ui.available_rect_before_wrap();
    let scroll = egui::ScrollArea::vertical().id_salt("play column");
    let shown = scroll.auto_shrink(false).show(ui, |ui| {
        let width = room.width() - GAP;
        ui.set_width(width);
        let part = |ui: &mut Ui, height: f32| {
            let size = Vec2::new(width, height);
            ui.allocate_exact_size(size, Sense::hover()).0
        };
        let place = |room: Rect| egui::UiBuilder::new().max_rect(room);
        let line_room = part(ui, PROBLEM_LINE);
        let fixed = problem_line(&mut ui.new_child(place(line_room)), problem);
        let pad_room = part(ui, (room.height() * PAD_SHARE).max(STRIP.2));
        let mut pad_ui = ui.new_child(place(pad_room));
        pad(&mut pad_ui, pad_room, picture, playing, false);
        let strip_room = part(ui, STRIP.1);
        strip::draw(ui, strip_room, playing);
        let action = side::ui(ui, playing, names, is_pad_open).or(fixed);
        follow_focus(ui);
        action
    });
    shown.inner
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
        // Another problem has another button: a slow click on the one before does nothing.
        let draw = |(label, _): &(&str, UiAction)| {
            ui.push_id(*label, |ui| theme::primary(ui, label)).inner
        };
        let button = fix.map(draw);
        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
            ui.label(egui::RichText::new(mark).color(colour).size(17.0));
            let mut line = egui::Label::new(text).truncate();
            if button.is_none() {
                // It keeps the focus of a button that has gone.
                line = line.sense(Sense::focusable_noninteractive());
            }
            let line = ui.add(line).on_hover_text(text);
            pass_focus_on(ui, button.as_ref().unwrap_or(&line));
        });
        let is_clicked = button.is_some_and(|button| button.clicked());
        fix.filter(|_| is_clicked).map(|(_, action)| action.clone())
    });
    clicked.inner
}

/// Gives the focus of the button that the problem line had before to what the line has now: Tab goes on from there.
fn pass_focus_on(ui: &Ui, to: &Response) {
    let id = egui::Id::unique("problem line");
    let before: Option<egui::Id> = ui.data(|data| data.get_temp(id));
    ui.data_mut(|data| data.insert_temp(id, to.id));
    let focused = ui.memory(|memory| memory.focused());
    if before.is_some_and(|before| before != to.id && focused == Some(before)) {
        to.request_focus();
    }
}
