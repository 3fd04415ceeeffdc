//! The orientation step: three corner presses show the first electrode and the direction of numbering.

use egui::Ui;

use super::{draw_notice, draw_success, paragraph};
use crate::app::services::{AppServices, PlayRequest};
use crate::calibrate::orientation::{
    GuidedPressRecorder, Orientation, OrientationSolver, Progress, with_numbering,
};
use crate::gui::background::{Background, take_result};
use crate::gui::edit::write_atomically;
use crate::gui::play::{UiAction, file_name};
use crate::gui::playing::Playing;
use crate::gui::request::GameContext;
use crate::gui::theme;
use crate::types::{Frame, Nanos, PointMm};

/// State of the step.
#[derive(Default)]
pub(super) struct OrientationStep {
    solving: Option<Background<Result<OrientationSolver, String>>>,
    presses: Option<Box<GuidedPressRecorder>>,
    progress: Option<Progress>,
    last_ns: Nanos,
    notice: Option<String>,
    /// Where the numbering was saved.
    saved: Option<String>,
}

impl OrientationStep {
    /// Takes the newest frame; returns the place to press next.
    pub(super) fn take_view(&mut self, playing: &Playing) -> Option<PointMm> {
        let died = || Err("a bug in gelpad: the thread that solves the pad stopped".to_owned());
        match take_result(&mut self.solving, died) {
            Some(Ok(solver)) => {
                self.presses = Some(Box::new(GuidedPressRecorder::new(solver)));
            }
            Some(Err(why)) => self.notice = Some(why),
            None => {}
        }
        let view = &playing.view;
        let fits = view.signals.volts.len() == playing.pad.channels();
        if let Some(presses) = &mut self.presses
            && view.t_ns != self.last_ns
            && fits
        {
            self.last_ns = view.t_ns;
            self.progress = Some(presses.take_frame(&Frame {
                t_ns: view.t_ns,
                volts: view.signals.volts.clone(),
            }));
        }
        match self.progress {
            Some(Progress::Press { place_mm, .. }) => Some(place_mm),
            _ => None,
        }
    }

    pub(super) fn ui(&mut self, ui: &mut Ui, game: GameContext<'_>) -> Option<UiAction> {
        let GameContext { playing, services } = game;
        paragraph(
            ui,
            "A square pad can be connected in eight ways that look the same at rest. Press the three shown corners, one after the other, to find out which one is yours.",
        );
        let palette = theme::palette_of(ui);
        let label = if self.solving.is_some() {
            "… solving the pad"
        } else {
            "Begin"
        };
        if ui
            .add_enabled(self.solving.is_none(), egui::Button::new(label))
            .clicked()
        {
            self.begin(playing);
        }
        let mut wish = None;
        match self.progress.clone() {
            None => {}
            Some(Progress::Resting) => {
                ui.label("Do not touch the pad for a moment …");
            }
            Some(Progress::Press { number, .. }) => {
                ui.label(
                    egui::RichText::new(format!("{} of 3: press the shown corner", number + 1))
                        .size(17.0),
                );
            }
            Some(Progress::Pressed { number }) => {
                ui.label(
                    egui::RichText::new(format!("{} of 3: detected, let go", number + 1))
                        .size(17.0),
                );
            }
            Some(Progress::Done(Ok(found))) => {
                ui.colored_label(palette.good, format!("✔ {}", summary(&found)));
                if theme::primary(ui, "Use it").clicked() {
                    wish = self.save(playing, services, &found);
                }
            }
            Some(Progress::Done(Err(error))) => {
                let text = egui::RichText::new(format!("✖ {error}")).color(palette.bad);
                ui.add(egui::Label::new(text).wrap());
            }
        }
        draw_success(ui, &self.saved);
        draw_notice(ui, &self.notice);
        wish
    }

    fn begin(&mut self, playing: &Playing) {
        (self.notice, self.saved) = (None, None);
        self.progress = None;
        self.presses = None;
        let pad = playing.pad.clone();
        let started = Background::start("orientation", move || {
            OrientationSolver::new(&pad).map_err(|error| error.to_string())
        });
        match started {
            Ok(solving) => self.solving = Some(solving),
            Err(error) => self.notice = Some(format!("cannot start a thread: {error}")),
        }
    }

    /// Writes the pad's text with the found numbering into the player's own folder, and plays that pad.
    fn save(
        &mut self,
        playing: &Playing,
        services: &dyn AppServices,
        found: &Orientation,
    ) -> Option<UiAction> {
        let saved = services
            .pad_text(&playing.request.pad)
            .and_then(|text| {
                with_numbering(&text, found.numbering).map_err(|error| error.to_string())
            })
            .and_then(|text| {
                let folder = services
                    .own_folder()
                    .ok_or("no folder for your own settings: set HOME")?;
                let name = format!("{}.toml", file_name(&playing.request.pad));
                let path = folder.join("pads").join(name);
                write_atomically(&path, &text).map_err(|error| error.to_string())?;
                Ok(path)
            });
        match saved {
            Ok(path) => {
                self.saved = Some(format!("saved: {}", path.display()));
                Some(UiAction::Play(PlayRequest {
                    pad: path.display().to_string(),
                    calibration: None,
                    ..playing.request.clone()
                }))
            }
            Err(why) => {
                self.notice = Some(why);
                None
            }
        }
    }
}

fn summary(found: &Orientation) -> String {
    format!(
        "electrode 1 is at place {} of the pad file, numbered {} (fit {:.0} %, second best {:.0} %)",
        found.numbering.first + 1,
        found.numbering.direction.name(),
        found.fit * 100.0,
        found.next * 100.0
    )
}
