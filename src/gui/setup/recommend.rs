//! Settings from the player's own presses: the wizard asks for presses, looks how they came out, and recommends timing, force
//! and accessibility settings as a text about this person.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

use egui::Ui;

use super::presses::TrialTaker;
use super::{notice, say};
use crate::calibrate::recommend::{Asked, Length, Recommendation, Trial};
use crate::gui::desk::{Choice, Desk};
use crate::gui::edit::write_beside;
use crate::gui::play::Wish;
use crate::gui::playing::Playing;
use crate::gui::theme;
use crate::profile::Profile;
use crate::types::{NANOS_PER_MS, Nanos};

/// A trial is over when nothing has been touched for so long.
const OVER_NS: Nanos = 1_200 * NANOS_PER_MS;
/// Rounds over the regions that are asked for.
const ROUNDS: usize = 3;
/// Regions that are asked for.
const REGIONS: usize = 3;

/// The step's state.
#[derive(Default)]
pub(super) struct Recommending {
    name: String,
    asked: Vec<Asked>,
    trials: Vec<Trial>,
    taker: TrialTaker,
    thinking: Option<Receiver<Result<Recommendation, String>>>,
    found: Option<Recommendation>,
    notice: Option<String>,
}

impl Recommending {
    /// The region that is to be pressed now.
    pub(super) fn asked_region(&self) -> Option<String> {
        let asked = self.asked.get(self.trials.len())?;
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
        if self.trials.len() < self.asked.len() {
            self.taker.view(&playing.view);
            if self.taker.quiet_ns().is_some_and(|quiet| quiet >= OVER_NS) {
                let asked = self.asked[self.trials.len()].clone();
                self.trials.push(self.taker.finish(Some(asked)));
            }
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
        match self.asked.get(self.trials.len()) {
            Some(asked) => {
                let words = match asked.length {
                    Length::Short => format!("tap {}, briefly", asked.region),
                    Length::Long => format!("press {} and hold it a second", asked.region),
                    Length::Twice => format!("tap {} twice, quickly", asked.region),
                };
                ui.label(egui::RichText::new(words).size(19.0));
                let done = self.trials.len() as f32 / self.asked.len() as f32;
                let count = format!("{} of {}", self.trials.len(), self.asked.len());
                ui.add(egui::ProgressBar::new(done).text(count));
                if ui.button("Stop").clicked() {
                    *self = Self {
                        name: std::mem::take(&mut self.name),
                        ..Self::default()
                    };
                }
            }
            None if self.thinking.is_some() => {
                ui.horizontal(|ui| {
                    ui.spinner();
                    ui.label("looking at your presses …");
                });
            }
            None => {
                if ui.button("Begin").clicked() {
                    self.asked = asked_of(&playing.view.profile);
                    self.trials.clear();
                    self.found = None;
                    self.notice = None;
                }
                if !self.asked.is_empty() && self.found.is_none() && self.notice.is_none() {
                    self.think(playing, desk);
                }
            }
        }
        if let Some(found) = self.found.clone() {
            wish = self.told(ui, &found, playing, desk.as_ref());
        }
        notice(ui, &self.notice);
        wish
    }

    fn think(&mut self, playing: &Playing, desk: &Arc<dyn Desk>) {
        let (sender, receiver) = sync_channel(1);
        let (desk, choice, trials) = (
            Arc::clone(desk),
            playing.choice.clone(),
            self.trials.clone(),
        );
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

/// What is asked for: short, long and double presses of the first regions, mixed.
fn asked_of(profile: &Profile) -> Vec<Asked> {
    let bound: Vec<&str> = profile
        .regions
        .iter()
        .enumerate()
        .filter(|(index, region)| {
            !region.rest && profile.bindings.iter().any(|b| b.regions.contains(index))
        })
        .map(|(_, region)| region.name.as_str())
        .collect();
    // The largest are pressed most; jump and the arrows are among the first of every profile.
    let chosen = bound.iter().take(REGIONS);
    let mut asked = Vec::new();
    for round in 0..ROUNDS {
        for (index, region) in chosen.clone().enumerate() {
            for length in [Length::Short, Length::Long, Length::Twice] {
                // Not every region in every way: that would take minutes.
                if length == Length::Twice && (round + index) % 2 == 1 {
                    continue;
                }
                asked.push(Asked {
                    region: (*region).to_owned(),
                    length,
                });
            }
        }
    }
    asked
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::recommend::FEWEST_TRIALS;
    use crate::gui::still;

    #[test]
    fn enough_is_asked_for_in_every_way() {
        let asked = asked_of(&still::profile());
        assert!(
            asked.len() >= FEWEST_TRIALS && asked.len() <= 30,
            "{}",
            asked.len()
        );
        for length in [Length::Short, Length::Long, Length::Twice] {
            assert!(asked.iter().any(|asked| asked.length == length));
        }
    }
}
