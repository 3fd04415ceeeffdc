//! The pad as it is, found from the presses of the calibration step while the game goes on.

use std::path::PathBuf;
use std::sync::mpsc;

use egui::Ui;

use super::{draw_notice, draw_success, paragraph};
use crate::app::services::{AppServices, FoundFromPresses, PlayRequest};
use crate::calibrate::{GuidedReadings, Press};
use crate::gui::play::UiAction;
use crate::gui::playing::Playing;
use crate::gui::theme;
use crate::runtime::View;
use crate::types::Nanos;

/// What is known of the pad as it is.
#[derive(Default)]
pub(super) struct FoundPad {
    readings: GuidedReadings,
    last_ns: Nanos,
    running: Option<mpsc::Receiver<FoundFromPresses>>,
    saved: Option<PathBuf>,
    summary: Option<String>,
    notice: Option<String>,
}

impl FoundPad {
    /// Keeps the readings of a view of the untouched pad; a view that was taken before is ignored.
    pub(super) fn take_untouched(&mut self, view: &View) {
        if view.t_ns != self.last_ns && !view.signals.volts.is_empty() {
            self.readings.take_untouched(&view.signals.volts);
        }
        self.last_ns = view.t_ns;
    }

    /// Begins to find the pad from presses. A pad that was learned has no drawing to differ from.
    pub(super) fn begin(
        &mut self,
        playing: &Playing,
        services: &dyn AppServices,
        presses: Vec<Press>,
    ) {
        let mut readings = std::mem::take(&mut self.readings);
        *self = Self::default();
        if playing.pad.learned.is_none() {
            readings.presses = presses;
            self.running = Some(services.begin_identifying(&playing.request, readings));
        }
    }

    /// Looks for what was found since the last call.
    pub(super) fn poll(&mut self) {
        let Some(running) = &self.running else { return };
        match running.try_recv() {
            Err(mpsc::TryRecvError::Empty) => return,
            Ok(Ok((path, summary))) => (self.saved, self.summary) = (Some(path), Some(summary)),
            Ok(Err(why)) => self.notice = Some(format!("the pad is kept as drawn: {why}")),
            // Its thread is gone: nothing is known.
            Err(mpsc::TryRecvError::Disconnected) => {}
        }
        self.running = None;
    }

    /// What was found, and a way to play with it.
    pub(super) fn ui(&self, ui: &mut Ui, playing: &Playing) -> Option<UiAction> {
        if self.running.is_some() {
            ui.horizontal_wrapped(|ui| {
                ui.spinner();
                ui.label("looking for the pad that explains these presses");
            });
        }
        draw_success(ui, &self.summary);
        draw_notice(ui, &self.notice);
        let path = self.saved.as_ref()?;
        if self.is_in_use(playing) {
            ui.colored_label(theme::palette_of(ui).good, "✔ the pad as it is, is in use");
            return None;
        }
        paragraph(
            ui,
            "Choose one of the two: the pad as it is helps every finger, also several at once; the calibration corrects where a lone finger is seen.",
        );
        let is_chosen = theme::primary(ui, "Play with the pad as it is").clicked();
        is_chosen.then(|| {
            // A calibration was learned with the pad as drawn.
            UiAction::Play(PlayRequest {
                pad: path.display().to_string(),
                calibration: None,
                ..playing.request.clone()
            })
        })
    }

    /// Whether the pad that was found is played.
    pub(super) fn is_in_use(&self, playing: &Playing) -> bool {
        let saved = self.saved.as_ref().map(|path| path.display().to_string());
        saved.is_some_and(|saved| saved == playing.request.pad)
    }
}
