//! Settings from the player's own presses: the wizard asks for presses, looks how they came out, and recommends timing, force
//! and accessibility settings as a text about this person.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

use egui::Ui;

use super::presses::Changes;
use super::{notice, say};
use crate::calibrate::recommend::{FEWEST_TRIALS, Recommendation, Session, Trial};
use crate::gui::desk::{Choice, Desk};
use crate::gui::edit::write_beside;
use crate::gui::play::Wish;
use crate::gui::playing::Playing;
use crate::gui::theme;

/// Presses that are asked for.
const PRESSES: usize = 24;

/// The step's state.
#[derive(Default)]
pub(super) struct Recommending {
    name: String,
    session: Option<Session>,
    changes: Changes,
    thinking: Option<Receiver<Result<Recommendation, String>>>,
    found: Option<Recommendation>,
    notice: Option<String>,
}

impl Recommending {
    /// The region that is to be pressed now.
    pub(super) fn asked_region(&self) -> Option<String> {
        let (_, asked) = self.session.as_ref()?.asked()?;
        Some(asked.region.clone())
    }

    /// Takes the newest view.
    pub(super) fn look(&mut self, playing: &Playing) {
        if let Some(receiver) = &self.thinking {
            match receiver.try_recv() {
                Ok(Ok(found)) => {
                    self.found = Some(found);
                    self.thinking = None;
                }
                Ok(Err(why)) => {
                    self.notice = Some(why);
                    self.thinking = None;
                }
                Err(TryRecvError::Empty) => {}
                Err(TryRecvError::Disconnected) => {
                    self.notice = Some("a bug in gelpad kept it from thinking".to_owned());
                    self.thinking = None;
                }
            }
        }
        let changed = self.changes.view(&playing.view);
        if let Some(session) = &mut self.session {
            session.frame(playing.view.t_ns, &changed);
        }
    }

    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        playing: &Playing,
        desk: &Arc<dyn Desk>,
    ) -> Option<Wish> {
        say(
            ui,
            "Press what is asked for, in your own way and time. gelpad then recommends times, force and help that suit how you press.",
        );
        ui.horizontal(|ui| {
            let label = ui.label("Your name");
            let field = egui::TextEdit::singleline(&mut self.name).hint_text("anna");
            ui.add(field.desired_width(140.0)).labelled_by(label.id);
        });
        let mut wish = None;
        let asked = self.session.as_ref().and_then(|session| {
            let (number, asked) = session.asked()?;
            Some((number, session.count(), asked.to_string()))
        });
        if let Some((number, count, words)) = asked {
            ui.label(egui::RichText::new(words).size(19.0));
            let done = number as f32 / count as f32;
            ui.add(egui::ProgressBar::new(done).text(format!("{number} of {count}")));
            if ui.button("Stop").clicked() {
                self.session = None;
            }
        } else if let Some(session) = self.session.take() {
            self.think(session.finish(), playing, desk);
        } else if self.thinking.is_some() {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label("looking at your presses …");
            });
        } else if ui.button("Begin").clicked() {
            self.begin(playing);
        }
        if let Some(found) = self.found.clone() {
            wish = self.told(ui, &found, playing, desk.as_ref());
        }
        notice(ui, &self.notice);
        wish
    }

    fn begin(&mut self, playing: &Playing) {
        self.found = None;
        self.notice = None;
        let session = Session::new(Session::usual(&playing.view.profile, PRESSES));
        if session.count() < FEWEST_TRIALS {
            self.notice = Some(
                "this profile has no region that a plain press is bound to: choose another one"
                    .to_owned(),
            );
            return;
        }
        self.session = Some(session);
    }

    fn think(&mut self, trials: Vec<Trial>, playing: &Playing, desk: &Arc<dyn Desk>) {
        let (sender, receiver) = sync_channel(1);
        let (desk, choice) = (Arc::clone(desk), playing.choice.clone());
        let pad_mm = playing.pad.outline.size_mm();
        let spawned = std::thread::Builder::new()
            .name("recommend".to_owned())
            .spawn(move || {
                // Whoever wanted it may have gone.
                let _ = sender.send(desk.recommend(&trials, &choice, pad_mm));
            });
        match spawned {
            Ok(_) => self.thinking = Some(receiver),
            Err(error) => self.notice = Some(format!("no thread to think on: {error}")),
        }
    }

    fn told(
        &mut self,
        ui: &mut Ui,
        found: &Recommendation,
        playing: &Playing,
        desk: &dyn Desk,
    ) -> Option<Wish> {
        let palette = theme::of(ui);
        ui.colored_label(
            palette.good,
            format!(
                "✔ right presses: {:.0} % as it was, {:.0} % with these settings",
                found.before.share() * 100.0,
                found.after.share() * 100.0
            ),
        );
        let text = found.toml();
        ui.add(
            egui::TextEdit::multiline(&mut text.as_str())
                .code_editor()
                .desired_rows(6)
                .desired_width(f32::INFINITY),
        );
        let name = self.name.trim().to_owned();
        let named = !name.is_empty() && !name.contains(['/', '\\', '.']);
        if !named {
            ui.weak("Write your name above to save them.");
        }
        let save = ui.add_enabled(named, egui::Button::new("Save and use"));
        if !save.clicked() {
            return None;
        }
        let Some(folder) = desk.own_folder() else {
            self.notice = Some("there is no folder for settings of your own: set HOME".to_owned());
            return None;
        };
        let path = folder.join("users").join(format!("{name}.toml"));
        if let Err(error) = write_beside(&path, &text) {
            self.notice = Some(format!("{}: {error}", path.display()));
            return None;
        }
        self.notice = Some(format!("saved: {}", path.display()));
        Some(Wish::Play(Choice {
            user: Some(path.display().to_string()),
            ..playing.choice.clone()
        }))
    }
}
