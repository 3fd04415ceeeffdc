//! The wizard from port to play: find the board, which way round, zero, calibrate, settings from the player's own presses, a
//! profile, and whether the output arrives.

mod board;
mod calibrate;
mod check;
pub mod presses;
mod recommend;
mod way;

use std::sync::Arc;

use egui::{Rect, Ui};

use super::desk::Desk;
use super::picture::{Picture, Shown};
use super::play::{Names, Wish};
use super::playing::Playing;
use super::theme;
use crate::runtime::Command;
use crate::types::PointMm;

/// The picture's share of the width.
const PICTURE: f32 = 0.46;

/// The steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Step {
    /// Port, pad, health of the readings.
    #[default]
    Board,
    /// Three corners.
    WayRound,
    /// The untouched pad.
    Zero,
    /// Presses at shown places.
    Calibrate,
    /// Settings from the player's own presses.
    Recommend,
    /// What is played.
    Profile,
    /// Whether the system sees it.
    Check,
}

impl Step {
    /// All, in order.
    pub const ALL: [Self; 7] = [
        Self::Board,
        Self::WayRound,
        Self::Zero,
        Self::Calibrate,
        Self::Recommend,
        Self::Profile,
        Self::Check,
    ];

    /// Its title.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Board => "Board",
            Self::WayRound => "Which way round",
            Self::Zero => "Zero",
            Self::Calibrate => "Calibrate",
            Self::Recommend => "Your presses",
            Self::Profile => "Profile",
            Self::Check => "Output",
        }
    }

    fn index(self) -> usize {
        Self::ALL.iter().position(|s| *s == self).unwrap_or(0)
    }

    fn beside(self, by: isize) -> Option<Self> {
        let index = self.index().checked_add_signed(by)?;
        Self::ALL.get(index).copied()
    }
}

/// The wizard's state.
#[derive(Default)]
pub struct SetUpView {
    /// The step that is shown.
    pub step: Step,
    picture: Picture,
    way: way::Way,
    calibrate: calibrate::Calibrating,
    recommend: recommend::Recommending,
    check: check::Check,
}

impl SetUpView {
    /// Whether the keys that come to this window are its own, to be looked at.
    #[must_use]
    pub fn checks_keys(&self) -> bool {
        self.step == Step::Check && self.check.checks()
    }

    /// Takes those keys, before anything acts on them.
    pub fn take_keys(&mut self, ui: &Ui) {
        self.check.take_keys(ui);
    }

    /// Draws the wizard; returns what the player wants.
    pub fn ui(
        &mut self,
        ui: &mut Ui,
        playing: &mut Playing,
        desk: &Arc<dyn Desk>,
        names: &mut Names,
    ) -> Option<Wish> {
        let mut wish = None;
        self.steps(ui);
        ui.add_space(4.0);
        let room = ui.available_rect_before_wrap();
        let split = room.left() + room.width() * PICTURE;
        let pad_room = Rect::from_min_max(room.min, egui::pos2(split - 8.0, room.bottom()));
        let side_room = Rect::from_min_max(egui::pos2(split + 4.0, room.top()), room.max);
        // What is gathered is gathered before anything is drawn: the picture shows where to press now.
        let mark = match self.step {
            Step::WayRound => self.way.look(playing),
            Step::Calibrate => self.calibrate.look(playing, desk.as_ref()),
            Step::Recommend => {
                self.recommend.look(playing);
                None
            }
            _ => None,
        };
        let asked = match self.step {
            Step::Recommend => self.recommend.asked_region(),
            _ => None,
        };
        self.pad(ui, pad_room, playing, mark, asked.as_deref());
        ui.scope_builder(egui::UiBuilder::new().max_rect(side_room), |ui| {
            egui::ScrollArea::vertical()
                .id_salt("set-up side")
                .auto_shrink(false)
                .show(ui, |ui| {
                    ui.set_width(side_room.width() - 8.0);
                    theme::card(ui).show(ui, |ui| {
                        ui.set_width(ui.available_width());
                        ui.heading(self.step.name());
                        wish = match self.step {
                            Step::Board => board::ui(ui, playing, desk.as_ref(), names),
                            Step::WayRound => self.way.ui(ui, playing, desk.as_ref()),
                            Step::Zero => zero(ui, playing),
                            Step::Calibrate => self.calibrate.ui(ui, playing, desk.as_ref()),
                            Step::Recommend => self.recommend.ui(ui, playing, desk),
                            Step::Profile => profile(ui, playing, names),
                            Step::Check => self.check.ui(ui, playing),
                        };
                        ui.add_space(6.0);
                        ui.separator();
                        self.turn(ui, &mut wish);
                    });
                });
        });
        ui.advance_cursor_after_rect(room);
        wish
    }

    /// The steps as a row; each can be gone to.
    fn steps(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            for step in Step::ALL {
                let words = format!("{} {}", step.index() + 1, step.name());
                if ui.selectable_label(self.step == step, words).clicked() {
                    self.step = step;
                }
            }
        });
    }

    fn turn(&mut self, ui: &mut Ui, wish: &mut Option<Wish>) {
        ui.horizontal(|ui| {
            let back = self.step.beside(-1);
            if ui
                .add_enabled(back.is_some(), egui::Button::new("◀ Back"))
                .clicked()
                && let Some(back) = back
            {
                self.step = back;
            }
            match self.step.beside(1) {
                Some(next) => {
                    if theme::primary(ui, "Next ▶").clicked() {
                        self.step = next;
                    }
                }
                None => {
                    if theme::primary(ui, "Play").clicked() {
                        *wish = Some(Wish::ShowPlay);
                    }
                }
            }
        });
    }

    /// The pad, pressable; a place to press is marked on it.
    fn pad(
        &mut self,
        ui: &mut Ui,
        room: Rect,
        playing: &mut Playing,
        mark: Option<PointMm>,
        asked: Option<&str>,
    ) {
        let shown = Shown {
            regions: matches!(self.step, Step::Recommend | Step::Profile | Step::Check),
            electrodes: matches!(self.step, Step::Board | Step::WayRound | Step::Zero),
            scale: false,
        };
        let place = self
            .picture
            .draw(ui, room, playing, &playing.view.profile, shown);
        let id = ui.scope_id().with("set-up pad");
        let response = ui.interact(place.rect, id, egui::Sense::click_and_drag());
        let words = match (mark, asked) {
            (Some([x, y]), _) => format!("Pad: press at {x:.0}, {y:.0} mm"),
            (None, Some(region)) => format!("Pad: press {region}"),
            (None, None) => "Pad".to_owned(),
        };
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, words.clone()));
        super::press::press(ui, &response, &place, playing);
        if let Some(mark) = mark {
            target(ui, place.of_pad(mark));
        }
        if let Some(region) = asked
            && let Some(region) = playing
                .view
                .profile
                .regions
                .iter()
                .find(|r| r.name == region)
        {
            let placed = region.placed(place.seen_mm, &playing.view.profile.settings.area);
            target(ui, place.of_seen(placed.centre_mm()));
        }
    }
}

/// A target: rings and a cross, seen on any ground.
fn target(ui: &Ui, at: egui::Pos2) {
    let painter = ui.painter();
    for (radius, width, colour) in [
        (22.0, 5.0, egui::Color32::BLACK),
        (22.0, 2.5, egui::Color32::WHITE),
        (11.0, 2.5, egui::Color32::WHITE),
    ] {
        painter.circle_stroke(at, radius, egui::Stroke::new(width, colour));
    }
    let line = egui::Stroke::new(2.0, theme::palette(true).accent);
    painter.hline(at.x - 30.0..=at.x + 30.0, at.y, line);
    painter.vline(at.x, at.y - 30.0..=at.y + 30.0, line);
}

/// A sentence that may be long.
fn say(ui: &mut Ui, words: &str) {
    ui.add(egui::Label::new(words).wrap());
}

/// A notice: what went wrong, or where something went.
fn notice(ui: &mut Ui, words: &Option<String>) {
    if let Some(words) = words {
        let colour = theme::of(ui).warn;
        ui.add(egui::Label::new(egui::RichText::new(words).color(colour)).wrap());
    }
}

fn zero(ui: &mut Ui, playing: &mut Playing) -> Option<Wish> {
    say(
        ui,
        "Take your hands off the pad, then set it to zero: what it reads then counts as untouched. It follows slow drift by itself; zero it again when something was laid on it or taken off.",
    );
    if ui.button("Zero now").clicked() {
        playing.ask(Command::Rezero);
    }
    let count = playing.view.touches.len();
    if count > 0 {
        let words = format!("{count} touched places are seen: is the pad free?");
        ui.colored_label(theme::of(ui).warn, words);
    } else {
        ui.colored_label(theme::of(ui).good, "✔ nothing touches it");
    }
    None
}

fn profile(ui: &mut Ui, playing: &Playing, names: &Names) -> Option<Wish> {
    say(
        ui,
        "What do you play? A profile says which part of the pad presses what.",
    );
    let mut wanted = playing.choice.clone();
    for name in &names.profiles {
        let words = super::play::file_name(name);
        ui.radio_value(&mut wanted.profile, name.clone(), words);
    }
    ui.add_space(4.0);
    say(ui, &playing.view.profile.about.clone());
    (wanted != playing.choice).then_some(Wish::Play(wanted))
}
