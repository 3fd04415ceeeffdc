//! Calibration: the player presses shown places, and what the model had missed is learned.

use egui::Ui;

use super::presses::{PressTaker, Taken};
use super::{notice, say};
use crate::calibrate::Press;
use crate::gui::desk::{Choice, Desk};
use crate::gui::play::Wish;
use crate::gui::playing::Playing;
use crate::gui::theme;
use crate::types::PointMm;

/// How many places are pressed, at least, at most, and unless asked.
const PLACES: (usize, usize, usize) = (12, 60, 25);

/// The step's state.
pub(super) struct Calibrating {
    wanted: usize,
    places: Vec<PointMm>,
    presses: Vec<Press>,
    taker: PressTaker,
    notice: Option<String>,
    saved: Option<std::path::PathBuf>,
}

impl Default for Calibrating {
    fn default() -> Self {
        Self {
            wanted: PLACES.2,
            places: Vec::new(),
            presses: Vec::new(),
            taker: PressTaker::default(),
            notice: None,
            saved: None,
        }
    }
}

impl Calibrating {
    /// Takes the newest view; where to press now.
    pub(super) fn look(&mut self, playing: &Playing, desk: &dyn Desk) -> Option<PointMm> {
        let place = *self.places.get(self.presses.len())?;
        match self.taker.view(&playing.view, place) {
            Taken::Nothing => {}
            Taken::Unfit(why) => self.notice = Some(why.to_owned()),
            Taken::Press(press) => {
                self.notice = None;
                self.presses.push(press);
                if self.presses.len() == self.places.len() {
                    self.learn(playing, desk);
                }
            }
        }
        self.places.get(self.presses.len()).copied()
    }

    fn learn(&mut self, playing: &Playing, desk: &dyn Desk) {
        let presses = std::mem::take(&mut self.presses);
        self.places.clear();
        match desk.calibrate(&playing.pad, presses) {
            Ok((path, told)) => {
                self.saved = Some(path);
                self.notice = Some(told);
            }
            Err(why) => self.notice = Some(why),
        }
    }

    pub(super) fn ui(&mut self, ui: &mut Ui, playing: &Playing, desk: &dyn Desk) -> Option<Wish> {
        say(
            ui,
            "Press each shown place once, as you usually do. gelpad learns where your pad differs from its drawing. You can leave this out.",
        );
        let mut wish = None;
        if self.places.is_empty() {
            ui.add(egui::Slider::new(&mut self.wanted, PLACES.0..=PLACES.1).text("places"));
            if ui.button("Begin").clicked() {
                self.places = desk.places(&playing.pad, self.wanted);
                self.presses.clear();
                self.saved = None;
                self.notice = None;
            }
        } else {
            let done = self.presses.len() as f32 / self.places.len() as f32;
            let words = format!("{} of {}", self.presses.len(), self.places.len());
            ui.add(egui::ProgressBar::new(done).text(words));
            if ui.button("Stop").clicked() {
                self.places.clear();
                self.presses.clear();
            }
        }
        if let Some(path) = &self.saved
            && playing.choice.calibration.as_ref() != Some(path)
            && theme::primary(ui, "Use it").clicked()
        {
            wish = Some(Wish::Play(Choice {
                calibration: Some(path.clone()),
                ..playing.choice.clone()
            }));
        }
        if playing.choice.calibration.is_some() {
            ui.colored_label(theme::of(ui).good, "✔ a calibration is in use");
            if ui.button("Play without it").clicked() {
                wish = Some(Wish::Play(Choice {
                    calibration: None,
                    ..playing.choice.clone()
                }));
            }
        }
        notice(ui, &self.notice);
        wish
    }
}
