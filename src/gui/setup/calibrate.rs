//! The calibration step: the player presses shown places, and gelpad learns how far the model is off at each, and what the pad itself is
//! like.

use egui::Ui;

use super::found_pad::FoundPad;
use super::presses::ViewPresses;
use super::{draw_notice, draw_success, paragraph};
use crate::app::error_estimate::{ErrorEstimate, ExpectedError};
use crate::app::services::{AppServices, PlayRequest};
use crate::calibrate::{FEWEST_PRESSES, Press, RecordedPress};
use crate::gui::play::UiAction;
use crate::gui::playing::Playing;
use crate::gui::request::GameContext;
use crate::gui::theme;
use crate::types::PointMm;

/// Numbers of places that can be chosen.
const PLACES: std::ops::RangeInclusive<usize> = 12..=60;
const DEFAULT_PLACES: usize = 25;
/// Places that follow if nothing can be learned from the chosen number.
const MORE_PLACES: usize = 8;

/// State of the step.
pub(super) struct CalibrationStep {
    place_count: usize,
    places: Vec<PointMm>,
    presses: Vec<Press>,
    recorder: ViewPresses,
    estimate: ErrorEstimate,
    /// The error to expect with the presses so far.
    expected: Option<ExpectedError>,
    notice: Option<String>,
    /// What the last calibration has learned.
    learned: Option<String>,
    saved: Option<std::path::PathBuf>,
    found: FoundPad,
}

impl Default for CalibrationStep {
    fn default() -> Self {
        Self {
            place_count: DEFAULT_PLACES,
            places: Vec::new(),
            presses: Vec::new(),
            recorder: ViewPresses::default(),
            estimate: ErrorEstimate::default(),
            expected: None,
            notice: None,
            learned: None,
            saved: None,
            found: FoundPad::default(),
        }
    }
}

impl CalibrationStep {
    /// Takes the newest view; returns the place to press next.
    pub(super) fn take_view(
        &mut self,
        playing: &Playing,
        services: &dyn AppServices,
    ) -> Option<PointMm> {
        self.expected = self.estimate.poll().or(self.expected);
        self.found.poll();
        let place = *self.places.get(self.presses.len())?;
        let recorded = self.recorder.take_view(&playing.view, place);
        if self.recorder.is_untouched() {
            self.found.take_untouched(&playing.view);
        }
        match recorded {
            RecordedPress::Pending => {}
            RecordedPress::Refused(why) => self.notice = Some(why.to_owned()),
            RecordedPress::Complete(press) => {
                self.notice = None;
                self.presses.push(press);
                let size_mm = playing.pad.outline.size_mm();
                self.estimate.begin(&self.presses, size_mm);
                if self.presses.len() == self.places.len() {
                    self.learn(playing, services);
                }
            }
        }
        self.places.get(self.presses.len()).copied()
    }

    /// Learns from the presses so far. If nothing can be learned from them, they are kept, and more places follow.
    fn learn(&mut self, playing: &Playing, services: &dyn AppServices) {
        match services.calibrate(&playing.pad, self.presses.clone()) {
            Ok((path, summary)) => {
                self.places.clear();
                let presses = std::mem::take(&mut self.presses);
                self.found.begin(playing, services, presses);
                self.saved = Some(path);
                self.learned = Some(summary);
            }
            Err(why) => {
                self.notice = Some(why);
                if self.presses.len() == self.places.len() {
                    let more = self.places.len() + MORE_PLACES;
                    self.places = services.calibration_places(&playing.pad, more);
                }
            }
        }
    }

    pub(super) fn ui(&mut self, ui: &mut Ui, game: GameContext<'_>) -> Option<UiAction> {
        let GameContext { playing, services } = game;
        paragraph(
            ui,
            "Press each shown place once, as you usually do. gelpad learns where your pad differs from its drawing. This step is optional.",
        );
        let mut wish = None;
        if self.places.is_empty() {
            ui.add(egui::Slider::new(&mut self.place_count, PLACES).text("places"));
            if ui.button("Begin").clicked() {
                self.places = services.calibration_places(&playing.pad, self.place_count);
                self.presses.clear();
                self.saved = None;
                (self.estimate, self.expected) = (ErrorEstimate::default(), None);
                (self.notice, self.learned) = (None, None);
                self.found = FoundPad::default();
            }
        } else {
            self.draw_progress(ui, game);
        }
        if let Some(path) = &self.saved
            && playing.request.calibration.as_ref() != Some(path)
            // It was learned with the pad as drawn.
            && !self.found.is_in_use(playing)
            && theme::primary(ui, "Use the calibration").clicked()
        {
            wish = Some(UiAction::Play(PlayRequest {
                calibration: Some(path.clone()),
                ..playing.request.clone()
            }));
        }
        if playing.request.calibration.is_some() {
            ui.colored_label(theme::palette_of(ui).good, "✔ a calibration is in use");
            if ui.button("Play without it").clicked() {
                wish = Some(UiAction::Play(PlayRequest {
                    calibration: None,
                    ..playing.request.clone()
                }));
            }
        }
        draw_success(ui, &self.learned);
        draw_notice(ui, &self.notice);
        wish.or(self.found.ui(ui, playing))
    }

    /// How many places are pressed, what error to expect, and the ways to end.
    fn draw_progress(&mut self, ui: &mut Ui, game: GameContext<'_>) {
        let GameContext { playing, services } = game;
        let done = self.presses.len() as f32 / self.places.len() as f32;
        let text = format!("{} of {}", self.presses.len(), self.places.len());
        ui.add(egui::ProgressBar::new(done).text(text));
        if let Some(expected) = &self.expected {
            ui.label(expected.to_string());
        }
        ui.horizontal_wrapped(|ui| {
            let is_enough = self.presses.len() >= FEWEST_PRESSES;
            if is_enough && ui.button("That is enough: learn from these").clicked() {
                self.learn(playing, services);
            }
            let takes_back = egui::Button::new("Take back the last press");
            if ui
                .add_enabled(!self.presses.is_empty(), takes_back)
                .clicked()
            {
                self.presses.pop();
                self.notice = None;
            }
            if ui.button("Stop").clicked() {
                self.places.clear();
                self.presses.clear();
            }
        });
    }
}
