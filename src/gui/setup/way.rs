//! Which way round: three corner presses tell the first electrode and the direction of counting.

use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

use egui::Ui;

use super::{notice, say};
use crate::calibrate::orientation::{Orienter, Progress, ThreePresses, WhichWay, numbered};
use crate::gui::desk::{Choice, Desk};
use crate::gui::edit::write_beside;
use crate::gui::play::{Wish, file_name};
use crate::gui::playing::Playing;
use crate::gui::theme;
use crate::types::{Frame, Nanos, PointMm};

/// The step's state.
#[derive(Default)]
pub(super) struct Way {
    solving: Option<Receiver<Result<Orienter, String>>>,
    presses: Option<Box<ThreePresses>>,
    progress: Option<Progress>,
    last_ns: Nanos,
    notice: Option<String>,
}

impl Way {
    /// Takes the newest frame; where to press now.
    pub(super) fn look(&mut self, playing: &Playing) -> Option<PointMm> {
        if let Some(receiver) = &self.solving {
            match receiver.try_recv() {
                Ok(Ok(orienter)) => {
                    self.presses = Some(Box::new(ThreePresses::new(orienter)));
                    self.solving = None;
                }
                Ok(Err(why)) => {
                    self.notice = Some(why);
                    self.solving = None;
                }
                Err(TryRecvError::Empty) => {}
                Err(TryRecvError::Disconnected) => {
                    self.notice = Some("a bug in gelpad kept the pad from being solved".to_owned());
                    self.solving = None;
                }
            }
        }
        let view = &playing.view;
        let fits = view.signals.volts.len() == playing.pad.channels();
        if let Some(presses) = &mut self.presses
            && view.t_ns != self.last_ns
            && fits
        {
            self.last_ns = view.t_ns;
            self.progress = Some(presses.frame(&Frame {
                t_ns: view.t_ns,
                volts: view.signals.volts.clone(),
            }));
        }
        match self.progress {
            Some(Progress::Press { place_mm, .. }) => Some(place_mm),
            _ => None,
        }
    }

    pub(super) fn ui(&mut self, ui: &mut Ui, playing: &Playing, desk: &dyn Desk) -> Option<Wish> {
        say(
            ui,
            "A square pad can be plugged in eight ways that read alike. Press three shown corners, one after the other, and gelpad knows which is yours.",
        );
        let palette = theme::of(ui);
        let words = if self.solving.is_some() {
            "… solving the pad"
        } else {
            "Begin"
        };
        if ui
            .add_enabled(self.solving.is_none(), egui::Button::new(words))
            .clicked()
        {
            self.begin(playing);
        }
        let mut wish = None;
        match self.progress.clone() {
            None => {}
            Some(Progress::Resting) => {
                ui.label("Leave the pad alone for a moment …");
            }
            Some(Progress::Press { number, .. }) => {
                ui.label(
                    egui::RichText::new(format!("{} of 3: press the shown corner", number + 1))
                        .size(17.0),
                );
            }
            Some(Progress::Pressed { number }) => {
                ui.label(
                    egui::RichText::new(format!("{} of 3: seen, now let go", number + 1))
                        .size(17.0),
                );
            }
            Some(Progress::Done(Ok(found))) => {
                ui.colored_label(palette.good, format!("✔ {}", in_words(&found)));
                if theme::primary(ui, "Use it").clicked() {
                    wish = self.save(playing, desk, &found);
                }
            }
            Some(Progress::Done(Err(error))) => {
                let words = egui::RichText::new(format!("✖ {error}")).color(palette.bad);
                ui.add(egui::Label::new(words).wrap());
            }
        }
        notice(ui, &self.notice);
        wish
    }

    fn begin(&mut self, playing: &Playing) {
        self.notice = None;
        self.progress = None;
        self.presses = None;
        let (sender, receiver) = sync_channel(1);
        let pad = playing.pad.clone();
        let spawned = std::thread::Builder::new()
            .name("orienter".to_owned())
            .spawn(move || {
                let solved = Orienter::new(&pad).map_err(|error| error.to_string());
                // Whoever wanted it may have gone.
                let _ = sender.send(solved);
            });
        match spawned {
            Ok(_) => self.solving = Some(receiver),
            Err(error) => self.notice = Some(format!("no thread to solve on: {error}")),
        }
    }

    /// Writes the pad's text with its numbering into the player's own folder, and plays that.
    fn save(&mut self, playing: &Playing, desk: &dyn Desk, found: &WhichWay) -> Option<Wish> {
        let saved = desk
            .pad_text(&playing.choice.pad)
            .and_then(|text| numbered(&text, found.numbering).map_err(|error| error.to_string()))
            .and_then(|text| {
                let folder = desk
                    .own_folder()
                    .ok_or("there is no folder for settings of your own: set HOME")?;
                let name = format!("{}.toml", file_name(&playing.choice.pad));
                let path = folder.join("pads").join(name);
                write_beside(&path, &text)
                    .map_err(|error| format!("{}: {error}", path.display()))?;
                Ok(path)
            });
        match saved {
            Ok(path) => {
                self.notice = Some(format!("saved: {}", path.display()));
                Some(Wish::Play(Choice {
                    pad: path.display().to_string(),
                    calibration: None,
                    ..playing.choice.clone()
                }))
            }
            Err(why) => {
                self.notice = Some(why);
                None
            }
        }
    }
}

fn in_words(found: &WhichWay) -> String {
    format!(
        "electrode 1 is at place {} of the pad's text, counted {} (fits {:.0} %, the next best {:.0} %)",
        found.numbering.first + 1,
        found.numbering.direction.word(),
        found.fit * 100.0,
        found.next * 100.0
    )
}
