//! The view to play in: the pad and what it does, the last seconds, what is held, and the worst problem with what mends it.

pub mod controller;
pub mod strip;

use egui::{Align2, Color32, FontId, Pos2, Rect, Response, Sense, Stroke, Ui, Vec2};

use super::desk::{Choice, From, To};
use super::picture::{Picture, Shown};
use super::place::Place;
use super::playing::Playing;
use super::press::press;
use super::problem::{Mend, Problem, Weight};
use super::regions::short;
use super::theme;
use crate::runtime::Command;
use crate::types::ms_from_nanos;

/// Names before the lists to choose from are so wide, points.
const NAME_WIDTH: f32 = 52.0;
/// The side: its share of the width, and from where to where, points.
const SIDE: (f32, f32, f32) = (0.28, 232.0, 330.0);
/// The strip: its share of the height, and from where to where, points.
const STRIP: (f32, f32, f32) = (0.18, 66.0, 124.0);
/// The line of the worst problem, points.
const BANNER: f32 = 40.0;
/// Between parts, points.
const GAP: f32 = 10.0;
/// A press this long fills its bar, ms.
const FULL_BAR_MS: f64 = 600.0;
/// Presses that are listed.
const LISTED: usize = 7;

/// What the player wants of the application.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Something else is to be played.
    Play(Choice),
    /// What mends a problem.
    Mend(Mend),
    /// The pad in a window of its own.
    PadWindow,
    /// A recording begins or ends.
    Record,
    /// The view to play in.
    ShowPlay,
}

/// Names that can be chosen from.
#[derive(Clone, Debug, Default)]
pub struct Names {
    /// Profiles.
    pub profiles: Vec<String>,
    /// Pads.
    pub pads: Vec<String>,
    /// People.
    pub users: Vec<String>,
    /// Serial ports.
    pub ports: Vec<String>,
}

/// Draws the view; returns what the player wants.
pub fn ui(
    ui: &mut Ui,
    picture: &mut Picture,
    playing: &mut Playing,
    problem: Option<&Problem>,
    names: &Names,
) -> Option<Wish> {
    let mut wish = None;
    let room = ui.available_rect_before_wrap();
    let side = (room.width() * SIDE.0).clamp(SIDE.1, SIDE.2);
    let strip_height = (room.height() * STRIP.0).clamp(STRIP.1, STRIP.2);
    let middle = room.right() - side - GAP;
    let banner_room = Rect::from_min_max(room.min, Pos2::new(middle, room.top() + BANNER));
    let strip_room = Rect::from_min_max(
        Pos2::new(room.left(), room.bottom() - strip_height),
        Pos2::new(middle, room.bottom()),
    );
    let pad_room = Rect::from_min_max(
        banner_room.left_bottom() + Vec2::new(0.0, GAP),
        strip_room.right_top() - Vec2::new(0.0, GAP),
    );
    let side_room = Rect::from_min_max(Pos2::new(middle + GAP, room.top()), room.max);

    ui.scope_builder(egui::UiBuilder::new().max_rect(banner_room), |ui| {
        if let Some(mend) = banner(ui, problem) {
            wish = Some(Wish::Mend(mend));
        }
    });
    pad(ui, pad_room, picture, playing, true);
    strip::draw(ui, strip_room, playing);
    ui.scope_builder(egui::UiBuilder::new().max_rect(side_room), |ui| {
        egui::ScrollArea::vertical()
            .id_salt("play side")
            .auto_shrink(false)
            .show(ui, |ui| {
                ui.set_width(side - 4.0);
                wish = side_ui(ui, playing, names).or(wish.take());
            });
    });
    ui.advance_cursor_after_rect(room);
    wish
}

/// The pad, pressable if it is the simulated one.
pub fn pad(
    ui: &mut Ui,
    room: Rect,
    picture: &mut Picture,
    playing: &mut Playing,
    scale: bool,
) -> (Response, Place) {
    let shown = Shown {
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
    let words = pad_words(playing);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, words.clone()));
    if response.has_focus() {
        let line = Stroke::new(2.0, theme::of(ui).accent);
        let around = place.rect.expand(3.0);
        ui.painter()
            .rect_stroke(around, 5.0, line, egui::StrokeKind::Outside);
        ui.memory_mut(|memory| {
            // Space and the arrows are for the pad, Tab goes on.
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
    press(ui, &response, &place, playing);
    (response, place)
}

/// The pad for those who do not see it.
fn pad_words(playing: &Playing) -> String {
    let touches = match playing.view.touches.len() {
        0 => "no touch".to_owned(),
        1 => "1 touch".to_owned(),
        count => format!("{count} touches"),
    };
    let held: Vec<String> = playing.view.held.iter().map(|o| short(*o)).collect();
    if held.is_empty() {
        format!("Pad: {touches}")
    } else {
        format!("Pad: {touches}, holding {}", held.join(" "))
    }
}

/// The worst problem; returns what its button does.
fn banner(ui: &mut Ui, problem: Option<&Problem>) -> Option<Mend> {
    let palette = theme::of(ui);
    let (mark, colour, words) = match problem {
        None => ("✔", palette.good, "All is well: play"),
        Some(problem) => match problem.weight {
            Weight::Hint => ("ℹ", palette.weak, problem.words.as_str()),
            Weight::Warning => ("⚠", palette.warn, problem.words.as_str()),
            Weight::Wrong => ("⛔", palette.bad, problem.words.as_str()),
        },
    };
    let room = ui.max_rect();
    ui.painter()
        .rect_filled(room, f32::from(theme::ROUND), palette.card);
    let edge = Rect::from_min_size(room.min, Vec2::new(4.0, room.height()));
    ui.painter().rect_filled(edge, 2.0, colour);
    let inner = room.shrink2(Vec2::new(12.0, 4.0));
    let mut mend = None;
    ui.scope_builder(
        egui::UiBuilder::new()
            .max_rect(inner)
            .layout(egui::Layout::right_to_left(egui::Align::Center)),
        |ui| {
            if let Some(cure) = problem.and_then(|problem| problem.mend.as_ref())
                && theme::primary(ui, cure.words()).clicked()
            {
                mend = Some(cure.clone());
            }
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                ui.label(egui::RichText::new(mark).color(colour).size(17.0));
                ui.add(egui::Label::new(words).truncate())
                    .on_hover_text(words);
            });
        },
    );
    mend
}

fn side_ui(ui: &mut Ui, playing: &mut Playing, names: &Names) -> Option<Wish> {
    let mut wish = None;
    theme::card(ui).show(ui, |ui| {
        ui.set_width(ui.available_width());
        wish = choose(ui, &playing.choice, names);
        ui.horizontal_wrapped(|ui| {
            let words = if playing.view.paused { "▶ Go on" } else { "⏸ Pause" };
            if ui.button(words).on_hover_text("everything comes up, nothing counts").clicked() {
                playing.ask(Command::Pause);
            }
            if ui
                .button("Zero")
                .on_hover_text("the pad counts as untouched as it is now")
                .clicked()
            {
                playing.ask(Command::Rezero);
            }
            if playing.has_hand()
                && ui
                    .button("🗖 Pad window")
                    .on_hover_text("a small window that takes no focus: press it while your game has the keyboard")
                    .clicked()
            {
                wish = Some(Wish::PadWindow);
            }
        });
    });
    theme::card(ui).show(ui, |ui| {
        ui.set_width(ui.available_width());
        theme::title(ui, "what the game sees");
        controller::draw(ui, playing);
    });
    theme::card(ui).show(ui, |ui| {
        ui.set_width(ui.available_width());
        theme::title(ui, "how long is how high");
        presses(ui, playing);
    });
    if playing.has_hand() {
        theme::card(ui).show(ui, |ui| {
            ui.set_width(ui.available_width());
            theme::title(ui, "press the pad");
            hand(ui, playing);
        });
    }
    theme::card(ui).show(ui, |ui| {
        ui.set_width(ui.available_width());
        theme::title(ui, "times: the usual · one of a hundred");
        times(ui, playing);
    });
    wish
}

/// Profile, source and output.
fn choose(ui: &mut Ui, choice: &Choice, names: &Names) -> Option<Wish> {
    let mut wanted = choice.clone();
    chooser(ui, "Profile", &file_name(&choice.profile), |ui| {
        for name in &names.profiles {
            ui.selectable_value(&mut wanted.profile, name.clone(), file_name(name));
        }
    });
    chooser(ui, "From", &choice.source_words(), |ui| {
        ui.selectable_value(&mut wanted.from, From::Hand, "simulated pad, your mouse");
        ui.selectable_value(&mut wanted.from, From::Level, "simulated pad, the level");
        for port in &names.ports {
            ui.selectable_value(&mut wanted.from, From::Serial(port.clone()), port);
        }
    });
    chooser(ui, "To", to_words(choice.to), |ui| {
        for to in [To::Nothing, To::Auto] {
            ui.selectable_value(&mut wanted.to, to, to_words(to));
        }
    });
    (wanted != *choice).then_some(Wish::Play(wanted))
}

/// A list to choose from, its name before it: the list takes the room that is left, however little that is.
fn chooser(ui: &mut Ui, name: &str, chosen: &str, entries: impl FnOnce(&mut Ui)) {
    ui.horizontal(|ui| {
        let height = ui.spacing().interact_size.y;
        let words = egui::Label::new(name).halign(egui::Align::LEFT);
        let label = ui.add_sized([NAME_WIDTH, height], words);
        egui::ComboBox::from_id_salt(name)
            .width(ui.available_width())
            .truncate()
            .selected_text(chosen)
            .show_ui(ui, entries)
            .response
            .labelled_by(label.id);
    });
}

fn to_words(to: To) -> &'static str {
    match to {
        To::Nothing => "nothing (a try-out)",
        To::Auto => "this desktop's keys",
    }
}

/// The last part of a path, without `.toml`.
pub fn file_name(argument: &str) -> String {
    let last = argument.rsplit('/').next().unwrap_or(argument);
    last.strip_suffix(".toml").unwrap_or(last).to_owned()
}

/// The last presses, newest first, each with a bar as long as it was held.
fn presses(ui: &mut Ui, playing: &Playing) {
    let palette = theme::of(ui);
    let now_ns = playing.story.now_ns;
    let newest = playing.story.presses.iter().rev().take(LISTED);
    let mut none = true;
    for press in newest {
        none = false;
        let ms = ms_from_nanos(press.length_ns(now_ns));
        let (rect, _) =
            ui.allocate_exact_size(Vec2::new(ui.available_width(), 18.0), Sense::hover());
        let painter = ui.painter_at(rect);
        let font = FontId::monospace(12.0);
        let text = |x: f32, align: Align2, words: String, colour: Color32| {
            painter.text(
                Pos2::new(x, rect.center().y),
                align,
                words,
                font.clone(),
                colour,
            )
        };
        text(
            rect.left(),
            Align2::LEFT_CENTER,
            short(press.output),
            palette.text,
        );
        let length = text(
            rect.left() + 118.0,
            Align2::RIGHT_CENTER,
            format!("{ms:.0} ms"),
            palette.weak,
        );
        let left = length.right() + 8.0;
        let share = (ms / FULL_BAR_MS).clamp(0.0, 1.0) as f32;
        let bar = Rect::from_min_max(
            Pos2::new(left, rect.top() + 4.0),
            Pos2::new(
                left + (rect.right() - left) * share.max(0.01),
                rect.bottom() - 4.0,
            ),
        );
        if press.until_ns.is_some() {
            painter.rect_filled(bar, 3.0, palette.accent.gamma_multiply(0.75));
        } else {
            let line = Stroke::new(1.5, palette.text);
            painter.rect(bar, 3.0, palette.accent, line, egui::StrokeKind::Inside);
        }
    }
    if none {
        ui.weak("Press the pad: every press shows here.");
    }
}

fn hand(ui: &mut Ui, playing: &mut Playing) {
    let force = playing.fingers.force();
    ui.horizontal(|ui| {
        ui.label("Force");
        let mut wanted = force;
        let slider = egui::Slider::new(&mut wanted, 0.1..=1.0).fixed_decimals(1);
        let response = ui.add(slider);
        response.widget_info(|| egui::WidgetInfo::slider(true, wanted, "Force of the next press"));
        if (wanted - force).abs() > 1e-9 {
            playing.fingers.harder((wanted - force) * 10.0);
            playing.press();
        }
    });
    ui.weak("Mouse presses, wheel: force, Space pins a finger, Esc lifts all. Keys 1 to 9 press regions.");
    if playing.fingers.any() && ui.button("Lift all").clicked() {
        playing.fingers.lift_all();
        playing.press();
    }
}

fn times(ui: &mut Ui, playing: &Playing) {
    let view = &playing.view;
    egui::Grid::new("times")
        .num_columns(2)
        .spacing([14.0, 3.0])
        .show(ui, |ui| {
            let mut row = |what: &str, value: String| {
                ui.weak(what);
                ui.monospace(value);
                ui.end_row();
            };
            row("frames", format!("{:.0} a second", view.frames_per_s));
            // Median and one of a hundred, of every stage of a frame.
            let stages = &view.stages;
            for (what, spread) in [
                ("in the queue", &stages.queue),
                ("to touches", &stages.touches),
                ("to events", &stages.events),
                ("to the device", &stages.device),
                ("frame to device", &stages.frame_to_device),
            ] {
                if spread.count > 0 {
                    let [median, p99] = [spread.median_us, spread.p99_us].map(|us| us / 1e3);
                    row(what, format!("{median:.2} · {p99:.1} ms"));
                }
            }
            if view.frames_per_s > 0.0 {
                row(
                    "sure to be seen",
                    format!("{:.0} ms", 2e3 / view.frames_per_s),
                );
            }
            row("lost frames", view.lost_frames.to_string());
        });
}
