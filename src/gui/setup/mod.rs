//! The setup wizard: board, orientation, zero, calibration, personal settings, profile, output check.

mod board;
mod calibrate;
mod check;
mod found_pad;
mod gamepad_checks;
mod new_pad;
mod orientation;
pub mod pad_form;
mod port_check;
pub mod presses;
mod recommend;
mod recommended;

use std::sync::Arc;

use egui::{Rect, Ui};

use super::focus_ring::follow_focus;
use super::picture::{Picture, PictureLayers};
use super::play::{Names, UiAction};
use super::playing::Playing;
use super::request::GameContext;
use super::theme;
use crate::app::services::{AppServices, SourceChoice, StartError};
use crate::runtime::PlayCommand;
use crate::types::{Output, PointMm};

/// Share of the width for the picture.
const PICTURE: f32 = 0.46;
/// Share of the height for the picture above the step, in a narrow window.
const COLUMN_PICTURE: f32 = 0.6;
/// Height of the row that leads to the next step, points.
const NAVIGATION: f32 = 42.0;

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

    /// Takes those keys before a widget acts on them: others, such as F1, still work.
    pub fn take_keys(&mut self, ui: &Ui, sent: &[Output]) {
        self.check.take_keys(ui, sent);
    }

    /// Draws the wizard; returns what the application should do.
    pub fn ui(
        &mut self,
        ui: &mut Ui,
        playing: &mut Playing,
        services: &Arc<dyn AppServices>,
        names: &mut Names,
        failed: Option<&StartError>,
    ) -> Option<UiAction> {
        if self.step != Step::Recommend {
            self.leave();
        }
        let is_column = ui.available_width() < theme::COLUMN;
        self.draw_steps(ui, is_column);
        ui.add_space(4.0);
        let room = ui.available_rect_before_wrap();
        let split = room.left() + room.width() * PICTURE;
        let pad_room = room.with_max_x(split - 8.0);
        let side_room = match is_column {
            true => room,
            false => room.with_min_x(split + 4.0),
        };
        // The way on stays in view.
        let end = side_room.bottom() - NAVIGATION;
        let (side_room, end_room) = (side_room.with_max_y(end), side_room.with_min_y(end));
        let target = self.take_view(playing, services.as_ref());
        if !is_column {
            self.draw_pad(ui, pad_room, playing, &target);
        }
        let mut wish = None;
        ui.scope_builder(egui::UiBuilder::new().max_rect(side_room), |ui| {
            egui::ScrollArea::vertical()
                .id_salt("set-up side")
                .auto_shrink(false)
                .show(ui, |ui| {
                    ui.set_width(side_room.width() - 8.0);
                    if is_column {
                        let height = (side_room.height() * COLUMN_PICTURE).max(100.0);
                        let size = egui::vec2(ui.available_width(), height);
                        let (pad_room, _) = ui.allocate_exact_size(size, egui::Sense::hover());
                        let place = egui::UiBuilder::new().max_rect(pad_room);
                        self.draw_pad(&mut ui.new_child(place), pad_room, playing, &target);
                    }
                    theme::card(ui).show(ui, |ui| {
                        ui.set_width(ui.available_width());
                        ui.heading(self.step.title());
                        wish = self.draw_step(ui, playing, services, names, failed);
                    });
                    follow_focus(ui);
                });
        });
        ui.scope_builder(egui::UiBuilder::new().max_rect(end_room), |ui| {
            ui.add_space(8.0);
            self.draw_navigation(ui, &mut wish);
        });
        ui.advance_cursor_after_rect(room);
        wish
    }

    /// Ends guided presses: the player does something else.
    pub fn leave(&mut self) {
        self.recommend.stop_presses();
    }

    /// Updates the step, before the picture shows where to press next.
    fn take_view(&mut self, playing: &Playing, services: &dyn AppServices) -> Target {
        match self.step {
            Step::Orientation => self.way.take_view(playing).into(),
            Step::Calibrate => self.calibrate.take_view(playing, services).into(),
            Step::Recommend => {
                self.recommend.update(playing);
                match self.recommend.target_region() {
                    Some(region) => Target::Region(region),
                    None => Target::None,
                }
            }
            _ => Target::None,
        }
    }

    fn draw_step(
        &mut self,
        ui: &mut Ui,
        playing: &mut Playing,
        services: &Arc<dyn AppServices>,
        names: &mut Names,
        failed: Option<&StartError>,
    ) -> Option<UiAction> {
        match self.step {
            Step::Board => self.draw_board(ui, playing, services, names),
            Step::Orientation => self.way.ui(ui, game_context(playing, services)),
            Step::Zero => draw_zero(ui, playing),
            Step::Calibrate => self.calibrate.ui(ui, game_context(playing, services)),
            Step::Recommend => self.recommend.ui(ui, playing, services),
            Step::Profile => draw_profiles(ui, playing, names),
            Step::Check => {
                let (game, gamepad) = (game_context(playing, services), &mut self.gamepad_checks);
                self.check.ui(ui, game, gamepad, failed)
            }
        }
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
        board::draw_misfit(ui, playing);
        let diagnosed = self.port_check.ui(ui, playing, services);
        board::quality(ui, playing);
        let wanted = self.port_check.take_wanted_pad();
        if let Some(electrodes) = wanted {
            self.new_pad.set_electrodes(electrodes);
        }
        let header = egui::CollapsingHeader::new("Make a pad of your own");
        let form = header.open(wanted.map(|_| true)).show(ui, |ui| {
            self.new_pad.ui(ui, game_context(playing, services))
        });
        if wanted.is_some() {
            form.header_response.scroll_to_me(Some(egui::Align::TOP));
        }
        chosen.or(diagnosed).or(form.body_returned.flatten())
    }

    /// The steps as a row of tabs; in a narrow window, their numbers.
    fn draw_steps(&mut self, ui: &mut Ui, is_column: bool) {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            for step in Step::ALL {
                let (number, is_shown) = (step.index() + 1, self.step == step);
                let label = format!("{number} {}", step.title());
                let tab = match is_column {
                    true => ui.selectable_label(is_shown, number.to_string()),
                    false => ui.selectable_label(is_shown, &label),
                };
                tab.widget_info(|| {
                    egui::WidgetInfo::selected(egui::Role::Button, true, is_shown, &label)
                });
                if tab.clicked() {
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
                    // Another button may be the way on.
                    let is_way_on = self.step != Step::Recommend || self.recommend.is_done();
                    if theme::way_on(ui, "Next ▶", is_way_on).clicked() {
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
    fn draw_pad(&mut self, ui: &mut Ui, room: Rect, playing: &mut Playing, target: &Target) {
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
        let label = match target {
            Target::Place([x, y]) => format!("Pad: press at {x:.0}, {y:.0} mm"),
            Target::Region(region) => format!("Pad: press {region}"),
            Target::None => "Pad".to_owned(),
        };
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, label.clone()));
        // Pinned fingers are lifted before guided presses are stopped.
        if self.recommend.target_region().is_some() {
            super::press::lift_pinned_on_escape(ui, playing);
        }
        super::press::handle_input(ui, &response, &place, playing);
        let profile = &playing.view.profile;
        match target {
            Target::Place(mark) => draw_target(ui, place.screen_from_pad(*mark)),
            Target::Region(name) => {
                let region = profile.regions.iter().find(|r| r.name == *name);
                if let Some(region) = region {
                    let placed = region.placed(place.seen_mm, &profile.settings.area);
                    draw_target(ui, place.screen_from_seen(placed.centre_mm()));
                }
            }
            Target::None => {}
        }
    }
}

/// What is to be pressed next.
enum Target {
    None,
    /// A place on the pad.
    Place(PointMm),
    /// A region of the profile.
    Region(String),
}

impl From<Option<PointMm>> for Target {
    fn from(place: Option<PointMm>) -> Self {
        place.map_or(Self::None, Self::Place)
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

/// What has worked.
fn draw_success(ui: &mut Ui, words: &Option<String>) {
    if let Some(words) = words {
        let text = egui::RichText::new(format!("✔ {words}"));
        ui.add(egui::Label::new(text.color(theme::palette_of(ui).good)).wrap());
    }
}

/// What has not worked, or has to be repeated.
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
