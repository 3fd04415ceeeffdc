//! The setup wizard: board, orientation, zero, calibration, personal settings, profile, output check.

mod board;
mod calibrate;
mod check;
mod gamepad_checks;
mod new_pad;
mod orientation;
pub mod pad_form;
mod port_check;
pub mod presses;
mod recommend;

use std::sync::Arc;

use egui::{Rect, Ui};

use super::picture::{Picture, PictureLayers};
use super::play::{Names, UiAction};
use super::playing::Playing;
use super::request::GameContext;
use super::theme;
use crate::app::services::{AppServices, SourceChoice};
use crate::runtime::PlayCommand;
use crate::types::PointMm;

/// Share of the width for the picture.
const PICTURE: f32 = 0.46;

/// A step of the wizard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Step {
    /// Port, pad, quality of the readings.
    #[default]
    Board,
    /// How the pad is turned, from three corner presses.
    Orientation,
    /// The reference of the untouched pad.
    Zero,
    /// Presses at shown places.
    Calibrate,
    /// Settings for one person, from their presses.
    Recommend,
    /// The profile to play.
    Profile,
    /// Whether keys arrive.
    Check,
}

impl Step {
    /// All steps in order.
    pub const ALL: [Self; 7] = [
        Self::Board,
        Self::Orientation,
        Self::Zero,
        Self::Calibrate,
        Self::Recommend,
        Self::Profile,
        Self::Check,
    ];

    /// Its title.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Board => "Board",
            Self::Orientation => "Orientation",
            Self::Zero => "Zero",
            Self::Calibrate => "Calibrate",
            Self::Recommend => "Personal settings",
            Self::Profile => "Profile",
            Self::Check => "Output",
        }
    }

    fn index(self) -> usize {
        Self::ALL.iter().position(|s| *s == self).unwrap_or(0)
    }

    fn neighbour(self, by: isize) -> Option<Self> {
        let index = self.index().checked_add_signed(by)?;
        Self::ALL.get(index).copied()
    }
}

/// State of the wizard.
#[derive(Default)]
pub struct SetUpView {
    /// The current step.
    pub step: Step,
    picture: Picture,
    way: orientation::OrientationStep,
    calibrate: calibrate::CalibrationStep,
    recommend: recommend::RecommendStep,
    check: check::OutputCheck,
    new_pad: new_pad::NewPad,
    port_check: port_check::PortCheck,
    gamepad_checks: gamepad_checks::GamepadChecks,
}

impl SetUpView {
    /// Whether keys are sent to this window for the output check.
    #[must_use]
    pub fn captures_keys(&self) -> bool {
        self.step == Step::Check && self.check.is_running()
    }

    /// Takes those keys before a widget acts on them.
    pub fn take_keys(&mut self, ui: &Ui) {
        self.check.take_keys(ui);
    }

    /// Draws the wizard; returns what the application should do.
    pub fn ui(
        &mut self,
        ui: &mut Ui,
        playing: &mut Playing,
        services: &Arc<dyn AppServices>,
        names: &mut Names,
    ) -> Option<UiAction> {
        let mut wish = None;
        self.draw_steps(ui);
        ui.add_space(4.0);
        let room = ui.available_rect_before_wrap();
        let split = room.left() + room.width() * PICTURE;
        let pad_room = Rect::from_min_max(room.min, egui::pos2(split - 8.0, room.bottom()));
        let side_room = Rect::from_min_max(egui::pos2(split + 4.0, room.top()), room.max);
        // Steps are updated first: the picture shows where to press next.
        let mark = match self.step {
            Step::Orientation => self.way.take_view(playing),
            Step::Calibrate => self.calibrate.take_view(playing, services.as_ref()),
            Step::Recommend => {
                self.recommend.update(playing);
                None
            }
            _ => None,
        };
        let target_region = match self.step {
            Step::Recommend => self.recommend.target_region(),
            _ => None,
        };
        self.draw_pad(ui, pad_room, playing, mark, target_region.as_deref());
        ui.scope_builder(egui::UiBuilder::new().max_rect(side_room), |ui| {
            egui::ScrollArea::vertical()
                .id_salt("set-up side")
                .auto_shrink(false)
                .show(ui, |ui| {
                    ui.set_width(side_room.width() - 8.0);
                    theme::card(ui).show(ui, |ui| {
                        ui.set_width(ui.available_width());
                        ui.heading(self.step.title());
                        wish = match self.step {
                            Step::Board => self.draw_board(ui, playing, services, names),
                            Step::Orientation => self.way.ui(ui, game_context(playing, services)),
                            Step::Zero => draw_zero(ui, playing),
                            Step::Calibrate => {
                                self.calibrate.ui(ui, game_context(playing, services))
                            }
                            Step::Recommend => self.recommend.ui(ui, playing, services),
                            Step::Profile => draw_profiles(ui, playing, names),
                            Step::Check => self.check.ui(
                                ui,
                                playing,
                                services.as_ref(),
                                &mut self.gamepad_checks,
                            ),
                        };
                        ui.add_space(6.0);
                        ui.separator();
                        self.draw_navigation(ui, &mut wish);
                    });
                });
        });
        ui.advance_cursor_after_rect(room);
        wish
    }

    /// The first step, and below it the form for another pad.
    fn draw_board(
        &mut self,
        ui: &mut Ui,
        playing: &mut Playing,
        services: &Arc<dyn AppServices>,
        names: &mut Names,
    ) -> Option<UiAction> {
        let chosen = board::choose(ui, playing, services.as_ref(), names);
        if playing.request.source == SourceChoice::Gamepad {
            self.gamepad_checks.ui(ui, services.as_ref());
        }
        let diagnosed = self.port_check.ui(ui, playing, services);
        board::quality(ui, playing);
        let form = ui.collapsing("Make a pad of your own", |ui| {
            self.new_pad.ui(ui, game_context(playing, services))
        });
        chosen.or(diagnosed).or(form.body_returned.flatten())
    }

    /// The steps as a row of tabs.
    fn draw_steps(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            for step in Step::ALL {
                let label = format!("{} {}", step.index() + 1, step.title());
                if ui.selectable_label(self.step == step, label).clicked() {
                    self.step = step;
                }
            }
        });
    }

    fn draw_navigation(&mut self, ui: &mut Ui, wish: &mut Option<UiAction>) {
        ui.horizontal(|ui| {
            let back = self.step.neighbour(-1);
            if ui
                .add_enabled(back.is_some(), egui::Button::new("◀ Back"))
                .clicked()
                && let Some(back) = back
            {
                self.step = back;
            }
            match self.step.neighbour(1) {
                Some(next) => {
                    if theme::primary(ui, "Next ▶").clicked() {
                        self.step = next;
                    }
                }
                None => {
                    if theme::primary(ui, "Play").clicked() {
                        *wish = Some(UiAction::Show(crate::gui::Tab::Play));
                    }
                }
            }
        });
    }

    /// The pad, which can be pressed, with a mark where to press next.
    fn draw_pad(
        &mut self,
        ui: &mut Ui,
        room: Rect,
        playing: &mut Playing,
        mark: Option<PointMm>,
        target_region: Option<&str>,
    ) {
        let shown = PictureLayers {
            image: true,
            regions: matches!(self.step, Step::Recommend | Step::Profile | Step::Check),
            electrodes: matches!(self.step, Step::Board | Step::Orientation | Step::Zero),
            scale: false,
        };
        let place = self
            .picture
            .draw(ui, room, playing, &playing.view.profile, shown);
        let id = ui.scope_id().with("set-up pad");
        let response = ui.interact(place.rect, id, egui::Sense::click_and_drag());
        let label = match (mark, target_region) {
            (Some([x, y]), _) => format!("Pad: press at {x:.0}, {y:.0} mm"),
            (None, Some(region)) => format!("Pad: press {region}"),
            (None, None) => "Pad".to_owned(),
        };
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, label.clone()));
        super::press::handle_input(ui, &response, &place, playing);
        if let Some(mark) = mark {
            draw_target(ui, place.screen_from_pad(mark));
        }
        if let Some(region) = target_region
            && let Some(region) = playing
                .view
                .profile
                .regions
                .iter()
                .find(|r| r.name == region)
        {
            let placed = region.placed(place.seen_mm, &playing.view.profile.settings.area);
            draw_target(ui, place.screen_from_seen(placed.centre_mm()));
        }
    }
}

fn game_context<'a>(playing: &'a Playing, services: &'a Arc<dyn AppServices>) -> GameContext<'a> {
    let services = services.as_ref();
    GameContext { playing, services }
}

/// Rings and a cross, visible on any background.
fn draw_target(ui: &Ui, at: egui::Pos2) {
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

/// A paragraph of text.
fn paragraph(ui: &mut Ui, words: &str) {
    ui.add(egui::Label::new(words).wrap());
}

/// An error, or where something was saved.
fn draw_notice(ui: &mut Ui, words: &Option<String>) {
    if let Some(words) = words {
        let colour = theme::palette_of(ui).warn;
        ui.add(egui::Label::new(egui::RichText::new(words).color(colour)).wrap());
    }
}

fn draw_zero(ui: &mut Ui, playing: &mut Playing) -> Option<UiAction> {
    paragraph(
        ui,
        "Take your hands off the pad, then set it to zero: the current readings become those of the untouched pad. Slow drift is corrected automatically. Set it to zero again after placing something on the pad or removing it.",
    );
    if ui.button("Set to zero").clicked() {
        playing.send_command(PlayCommand::Rezero);
    }
    let palette = theme::palette_of(ui);
    if playing.view.touches.is_empty() {
        ui.colored_label(palette.good, "✔ no touches");
    } else {
        ui.colored_label(palette.warn, "A touch is detected: is the pad free?");
    }
    None
}

fn draw_profiles(ui: &mut Ui, playing: &Playing, names: &Names) -> Option<UiAction> {
    paragraph(
        ui,
        "Which game do you play? A profile defines which part of the pad presses which key.",
    );
    let mut wanted = playing.request.clone();
    for name in &names.profiles {
        let label = super::play::file_name(name);
        ui.radio_value(&mut wanted.profile, name.clone(), label);
    }
    ui.add_space(4.0);
    paragraph(ui, &playing.view.profile.about.clone());
    (wanted != playing.request).then_some(UiAction::Play(wanted))
}
