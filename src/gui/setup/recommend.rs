//! Personal settings: the player makes guided presses, and timing, force and accessibility settings are recommended from
//! them as a settings file for this person.

use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

use egui::Ui;

use super::presses::TouchChanges;
use super::{draw_notice, paragraph};
use crate::app::services::{AppServices, PlayRequest};
use crate::calibrate::recommend::{FEWEST_TRIALS, PressSession, PressTrial, Recommendation};
use crate::gui::edit::write_atomically;
use crate::gui::play::UiAction;
use crate::gui::playing::Playing;
use crate::gui::theme;

/// The name of someone who types none: a mouse is enough.
const NO_NAME: &str = "me";
/// Guided presses.
const PRESSES: usize = 24;

/// State of the step.
#[derive(Default)]
pub(super) struct RecommendStep {
    name: String,
    session: Option<PressSession>,
    changes: TouchChanges,
    search: Option<Receiver<Result<Recommendation, String>>>,
    recommendation: Option<Recommendation>,
    notice: Option<String>,
}

impl RecommendStep {
    /// The region to press next.
    pub(super) fn target_region(&self) -> Option<String> {
        let (_, asked) = self.session.as_ref()?.current_request()?;
        Some(asked.region.clone())
    }

    /// Takes the result of a search, and the touches of the newest view.
    pub(super) fn update(&mut self, playing: &Playing) {
        if let Some(receiver) = &self.search {
            match receiver.try_recv() {
                Ok(Ok(recommendation)) => {
                    self.recommendation = Some(recommendation);
                    self.search = None;
                }
                Ok(Err(why)) => {
                    self.notice = Some(why);
                    self.search = None;
                }
                Err(TryRecvError::Empty) => {}
                Err(TryRecvError::Disconnected) => {
                    self.notice =
                        Some("internal error: the search stopped without a result".to_owned());
                    self.search = None;
                }
            }
        }
        let changed = self.changes.take_view(&playing.view);
        if let Some(session) = &mut self.session {
            session.take_frame(playing.view.t_ns, &changed);
        }
    }

    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        playing: &Playing,
        services: &Arc<dyn AppServices>,
    ) -> Option<UiAction> {
        paragraph(
            ui,
            "Make the presses shown here in your own way and at your own pace. gelpad then recommends timing, force and accessibility settings that suit you.",
        );
        ui.horizontal(|ui| {
            let label = ui.label("Your name");
            let field = egui::TextEdit::singleline(&mut self.name).hint_text(NO_NAME);
            let field = ui.add(field.desired_width(140.0)).labelled_by(label.id);
            theme::keep_focus_on_enter(ui, &field);
        });
        let mut wish = None;
        let asked = self.session.as_ref().and_then(|session| {
            let (number, asked) = session.current_request()?;
            Some((number, session.request_count(), asked.to_string()))
        });
        if let Some((number, count, words)) = asked {
            ui.label(egui::RichText::new(words).size(19.0));
            let done = number as f32 / count as f32;
            ui.add(egui::ProgressBar::new(done).text(format!("{number} of {count}")));
            if ui.button("Stop").clicked() {
                self.session = None;
            }
        } else if let Some(session) = self.session.take() {
            self.start_search(session.finish(), playing, services);
        } else if self.search.is_some() {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label("analysing your presses …");
            });
        } else if ui.button("Start").clicked() {
            self.start(playing);
        }
        if let Some(found) = self.recommendation.clone() {
            wish = self.draw_recommendation(ui, &found, playing, services.as_ref());
        }
        draw_notice(ui, &self.notice);
        wish
    }

    fn start(&mut self, playing: &Playing) {
        self.recommendation = None;
        self.notice = None;
        let session = PressSession::new(PressSession::default_requests(
            &playing.view.profile,
            PRESSES,
        ));
        if session.request_count() < FEWEST_TRIALS {
            self.notice = Some(
                "this profile has no region with a plain press: choose another profile".to_owned(),
            );
            return;
        }
        self.session = Some(session);
    }

    fn start_search(
        &mut self,
        trials: Vec<PressTrial>,
        playing: &Playing,
        services: &Arc<dyn AppServices>,
    ) {
        let (sender, receiver) = sync_channel(1);
        let (services, request) = (Arc::clone(services), playing.request.clone());
        let pad_mm = playing.pad.outline.size_mm();
        let spawned = std::thread::Builder::new()
            .name("recommend".to_owned())
            .spawn(move || {
                // The window may have been closed.
                let _ = sender.send(services.recommend(&trials, &request, pad_mm));
            });
        match spawned {
            Ok(_) => self.search = Some(receiver),
            Err(error) => self.notice = Some(format!("cannot start a thread: {error}")),
        }
    }

    fn draw_recommendation(
        &mut self,
        ui: &mut Ui,
        found: &Recommendation,
        playing: &Playing,
        services: &dyn AppServices,
    ) -> Option<UiAction> {
        let palette = theme::palette_of(ui);
        ui.colored_label(
            palette.good,
            format!(
                "✔ correct presses: {:.0} % before, {:.0} % with these settings",
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
        let folder = services.own_folder().map(|folder| folder.join("users"));
        let name = match self.name.trim() {
            "" => folder.as_deref().map_or(NO_NAME.to_owned(), unused_name),
            name => name.to_owned(),
        };
        let is_valid = match name_problem(&name) {
            Some(problem) => {
                ui.colored_label(palette.warn, problem);
                false
            }
            None => true,
        };
        let save = ui.add_enabled(is_valid, egui::Button::new("Save and use"));
        if !save.clicked() {
            return None;
        }
        let Some(folder) = folder else {
            self.notice = Some("no folder for your own settings: set HOME".to_owned());
            return None;
        };
        let path = folder.join(format!("{name}.toml"));
        if let Err(error) = write_atomically(&path, &text) {
            self.notice = Some(error.to_string());
            return None;
        }
        self.notice = Some(format!("saved: {}", path.display()));
        Some(UiAction::Play(PlayRequest {
            user: Some(path.display().to_string()),
            ..playing.request.clone()
        }))
    }
}

/// `me`, `me-2`, ...: nobody's settings are replaced.
fn unused_name(folder: &Path) -> String {
    let name = |number: usize| match number {
        1 => NO_NAME.to_owned(),
        _ => format!("{NO_NAME}-{number}"),
    };
    let is_free = |name: &String| !folder.join(format!("{name}.toml")).exists();
    (1..).map(name).find(is_free).unwrap_or_default()
}

/// Why settings cannot be saved under a name; the name becomes that of a file.
fn name_problem(name: &str) -> Option<String> {
    let wrong = name
        .chars()
        .find(|c| "/\\.:*?\"<>|".contains(*c) || c.is_control())?;
    Some(format!(
        "Your name cannot contain {wrong:?}: the settings are saved as a file of this name. Leave it out."
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_was_not_typed_replaces_nobody() {
        let folder = tempfile::tempdir().expect("a folder");
        assert_eq!(unused_name(folder.path()), "me");
        std::fs::write(folder.path().join("me.toml"), "").expect("written");
        assert_eq!(unused_name(folder.path()), "me-2");
    }

    #[test]
    fn a_name_that_no_file_can_have_is_refused_with_the_reason() {
        assert_eq!(name_problem("Anna Ż"), None);
        for (name, why) in [("a/b", "'/'"), ("a\\b", "'\\\\'")] {
            let problem = name_problem(name).unwrap_or_default();
            assert!(problem.contains(why), "{name}: {problem}");
        }
    }
}
