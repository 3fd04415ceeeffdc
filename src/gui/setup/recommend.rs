//! Personal settings: the player makes guided presses, and timing, force and accessibility settings are recommended from
//! them as a settings file for this person.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::Ui;

use super::presses::TouchChanges;
use super::recommended;
use super::{draw_notice, draw_success, paragraph};
use crate::app::services::{AppServices, PlayRequest};
use crate::calibrate::recommend::{
    FEWEST_TRIALS, PressLength, PressRequest, PressSession, PressTrial, QUIET_NS, Recommendation,
};
use crate::gui::background::{Background, take_result};
use crate::gui::edit::write_atomically;
use crate::gui::play::UiAction;
use crate::gui::playing::Playing;
use crate::gui::regions::press_outputs;
use crate::gui::request::file_name;
use crate::gui::theme;
use crate::profile::Profile;
use crate::types::NANOS_PER_MS;

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
    search: Option<Background<Result<Recommendation, String>>>,
    recommendation: Option<Recommendation>,
    /// With whose settings the presses were made.
    person: Option<String>,
    notice: Option<String>,
    prompt: Prompt,
    /// What the step has led to: the saved file, or that nothing changed.
    outcome: Option<String>,
}

/// What is asked now, and what the player has done for it.
#[derive(Default)]
struct Prompt {
    number: usize,
    words: String,
    /// Whether the same was asked before.
    is_again: bool,
    /// Touches that went up since.
    lifts: usize,
    /// Lifts that are asked for.
    wanted_lifts: usize,
}

/// How the player ends the presses before their end.
enum PromptChoice {
    /// The presses so far are used.
    Enough,
    /// They are dropped.
    Stop,
}

impl Prompt {
    /// Takes the current request, what people call its region, and the touches that were lifted since it began.
    fn take(&mut self, number: usize, asked: &PressRequest, title: &str, lifts: usize) {
        let words = PressRequest {
            region: title.to_owned(),
            length: asked.length,
        }
        .to_string();
        if self.number != number || self.words.is_empty() {
            self.is_again = number > 0 && self.words == words;
            (self.number, self.words) = (number, words);
        }
        self.lifts = lifts;
        self.wanted_lifts = match asked.length {
            PressLength::Twice => 2,
            PressLength::Short | PressLength::Long => 1,
        };
    }

    fn is_seen(&self) -> bool {
        self.lifts >= self.wanted_lifts
    }

    fn instruction(&self) -> String {
        match self.is_again {
            true => format!("once more: {}", self.words),
            false => self.words.clone(),
        }
    }

    /// Says at once that a press has arrived, and how the next one comes: when the pad was at rest for a while. Touches until then
    /// belong to the press.
    fn acknowledgement(&self, count: usize) -> String {
        let rest_s = QUIET_NS / (1000 * NANOS_PER_MS);
        let number = self.number + 1;
        let next = match number == count {
            true => "then all are done",
            false => "then comes the next",
        };
        match self.lifts {
            0 => "Press now. Esc stops.".to_owned(),
            _ if !self.is_seen() => "✔ first tap seen: now the second, within 10 s".to_owned(),
            lifts if lifts == self.wanted_lifts => {
                format!(
                    "✔ press {number} of {count} seen. Do not touch the pad for {rest_s} s, {next}."
                )
            }
            _ => format!(
                "✔ press {number} of {count} seen, but more came after it. Do not touch the pad for {rest_s} s, {next}."
            ),
        }
    }
}

/// What people call a region that they are asked to press: a cell of a grid shows only what it sends.
fn prompt_title(profile: &Profile, region: &str) -> String {
    let outputs = press_outputs(profile, region);
    let mut regions = profile.regions.iter();
    let is_cell = regions.any(|other| other.name == region && other.is_cell);
    match (outputs.is_empty(), is_cell) {
        (true, _) => region.to_owned(),
        (false, true) => outputs,
        (false, false) => format!("{region} ({outputs})"),
    }
}

impl RecommendStep {
    /// The region to press next.
    pub(super) fn target_region(&self) -> Option<String> {
        let (_, asked) = self.session.as_ref()?.current_request()?;
        Some(asked.region.clone())
    }

    /// Takes the result of a search, and the touches of the newest view.
    pub(super) fn update(&mut self, playing: &Playing) {
        let died = || Err("internal error: the search stopped without a result".to_owned());
        match take_result(&mut self.search, died) {
            Some(Ok(recommendation)) => self.recommendation = Some(recommendation),
            Some(Err(why)) => self.notice = Some(why),
            None => {}
        }
        let changed = self.changes.take_view(&playing.view);
        if let Some(session) = &mut self.session {
            session.take_frame(playing.view.t_ns, &changed);
            if let Some((number, asked)) = session.current_request() {
                let title = prompt_title(&playing.view.profile, &asked.region);
                self.prompt.take(number, asked, &title, session.lifts());
            }
        }
    }

    /// Ends the guided presses before their end; they can be started again.
    pub(super) fn stop_presses(&mut self) {
        if self.session.take().is_some() {
            self.notice = Some("stopped: nothing was changed".to_owned());
        }
    }

    /// Whether the step has led to something.
    pub(super) fn is_done(&self) -> bool {
        self.outcome.is_some()
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
        let row = ui.horizontal(|ui| {
            let label = ui.label("Your name");
            let field = egui::TextEdit::singleline(&mut self.name).hint_text(NO_NAME);
            let field = ui.add(field.desired_width(140.0)).labelled_by(label.id);
            theme::keep_focus_on_enter(ui, &field);
            field.lost_focus()
        });
        let mut wish = None;
        // Escape also leaves the field, and closes lists and questions.
        let is_taken = row.inner
            || egui::Popup::is_any_open(ui.ctx())
            || ui.memory(|memory| memory.top_modal_layer().is_some());
        if !is_taken && ui.input(|input| input.key_pressed(egui::Key::Escape)) {
            self.stop_presses();
        }
        let count = self.session.as_ref().and_then(|session| {
            let _ = session.current_request()?;
            Some(session.request_count())
        });
        if let Some(count) = count {
            match self.draw_prompt(ui, count) {
                Some(PromptChoice::Enough) => {
                    if let Some(session) = self.session.take() {
                        self.start_search(session.finish(), playing, services);
                    }
                }
                Some(PromptChoice::Stop) => self.stop_presses(),
                None => {}
            }
        } else if let Some(session) = self.session.take() {
            self.start_search(session.finish(), playing, services);
        } else if self.search.is_some() {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label("analysing your presses …");
            });
        } else {
            let is_way_on = self.recommendation.is_none() && !self.is_done();
            if theme::way_on(ui, "Start", is_way_on).clicked() {
                self.start(playing);
            }
        }
        if let Some(found) = self.recommendation.clone() {
            wish = self.draw_recommendation(ui, &found, playing, services.as_ref());
        }
        draw_success(ui, &self.outcome);
        draw_notice(ui, &self.notice);
        wish
    }

    /// What to press now and what has arrived; returns whether the player ends the presses.
    fn draw_prompt(&self, ui: &mut Ui, count: usize) -> Option<PromptChoice> {
        let prompt = &self.prompt;
        let palette = theme::palette_of(ui);
        ui.label(egui::RichText::new(prompt.instruction()).size(19.0));
        let colour = match prompt.lifts {
            0 => palette.weak,
            _ => palette.good,
        };
        let words = egui::RichText::new(prompt.acknowledgement(count)).color(colour);
        ui.add(egui::Label::new(words).wrap());
        let done = prompt.number + usize::from(prompt.is_seen());
        let bar = egui::ProgressBar::new(done as f32 / count as f32);
        ui.add(bar.text(format!("{done} of {count}")));
        let mut choice = None;
        ui.horizontal_wrapped(|ui| {
            if prompt.number >= FEWEST_TRIALS && ui.button("That is enough").clicked() {
                choice = Some(PromptChoice::Enough);
            }
            if ui.button("Stop").clicked() {
                choice = Some(PromptChoice::Stop);
            }
        });
        choice
    }

    fn start(&mut self, playing: &Playing) {
        self.recommendation = None;
        (self.notice, self.outcome) = (None, None);
        self.prompt = Prompt::default();
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
        self.person = playing.request.user.as_deref().map(file_name);
        let (services, request) = (Arc::clone(services), playing.request.clone());
        let pad_mm = playing.pad.outline.size_mm();
        let started = Background::start("recommend", move || {
            services.recommend(&trials, &request, pad_mm)
        });
        match started {
            Ok(search) => self.search = Some(search),
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
        let words = recommended::outcome_words(found, self.person.as_deref());
        let is_worse = found.is_worse();
        let helps_nothing = found.helps_nothing();
        let words = if is_worse {
            egui::RichText::new(format!(
                "⚠ {words}. The new settings are worse: keep what you have."
            ))
            .color(palette.warn)
        } else if helps_nothing {
            egui::RichText::new(format!(
                "{words}. The new settings would not help: keep what you have."
            ))
        } else {
            egui::RichText::new(format!("✔ {words}")).color(palette.good)
        };
        ui.add(egui::Label::new(words).wrap());
        recommended::draw(ui, found);
        if self.is_done() {
            return None;
        }
        let folder = services.own_folder().map(|folder| folder.join("users"));
        let name = match self.name.trim() {
            "" => folder.as_deref().map_or(NO_NAME.to_owned(), unused_name),
            name => name.to_owned(),
        };
        let problem = name_problem(&name);
        let is_valid = problem.is_none();
        let is_typed = !self.name.trim().is_empty();
        let taken = folder.as_deref();
        let taken = taken.and_then(|folder| name_taken(folder, &name, is_typed));
        if let Some(words) = problem.or(taken) {
            let words = egui::RichText::new(words).color(palette.warn);
            ui.add(egui::Label::new(words).wrap());
        }
        let row = ui.horizontal_wrapped(|ui| {
            let keeps =
                (is_worse || helps_nothing) && theme::primary(ui, "Keep what you have").clicked();
            if keeps {
                self.outcome = Some("kept: your settings are as they were".to_owned());
            }
            let label = match is_worse {
                true => "Save and use anyway",
                false => "Save and use",
            };
            let save = ui.add_enabled_ui(is_valid, |ui| {
                theme::way_on(ui, label, !is_worse && !helps_nothing)
            });
            save.inner.clicked()
        });
        if !row.inner {
            return None;
        }
        self.save(folder, &name, &found.toml(), playing)
    }

    fn save(
        &mut self,
        folder: Option<PathBuf>,
        name: &str,
        text: &str,
        playing: &Playing,
    ) -> Option<UiAction> {
        let Some(folder) = folder else {
            self.notice = Some("no folder for your own settings: set HOME".to_owned());
            return None;
        };
        let path = folder.join(format!("{name}.toml"));
        if let Err(error) = write_atomically(&path, text) {
            self.notice = Some(error.to_string());
            return None;
        }
        self.notice = None;
        self.outcome = Some(format!("saved: {}", path.display()));
        Some(UiAction::Play(PlayRequest {
            user: Some(path.display().to_string()),
            ..playing.request.clone()
        }))
    }
}

/// What happens to settings that are there already.
fn name_taken(folder: &Path, name: &str, is_typed: bool) -> Option<String> {
    let exists = folder.join(format!("{name}.toml")).exists();
    match is_typed {
        true if exists => Some(format!(
            "{name} has settings already: saving replaces them."
        )),
        false if name != NO_NAME => Some(format!(
            "{NO_NAME} has settings already: these are saved as {name}. To replace the others, type {NO_NAME} as your name."
        )),
        _ => None,
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
    fn settings_that_are_there_already_are_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let taken = |name: &str, is_typed| name_taken(folder.path(), name, is_typed);
        assert_eq!(taken("me", false), None);
        assert_eq!(taken("anna", true), None);
        std::fs::write(folder.path().join("anna.toml"), "").expect("written");
        assert!(taken("anna", true).is_some_and(|words| words.contains("replaces")));
        assert!(taken("me-2", false).is_some_and(|words| words.contains("saved as me-2")));
    }

    #[test]
    fn a_cell_of_a_grid_is_asked_for_by_what_it_shows() {
        let profile = |name| {
            let text = crate::profile::shipped_profile(name).expect("shipped").toml;
            Profile::from_toml(name, text).expect("valid")
        };
        assert_eq!(prompt_title(&profile("large-buttons"), "buttons-1"), "←");
        assert_eq!(prompt_title(&profile("super-mario"), "jump"), "jump (F)");
    }

    #[test]
    fn a_press_is_acknowledged_when_it_lifts_and_a_repeated_prompt_says_so() {
        let asked = |length| PressRequest {
            region: "jump".to_owned(),
            length,
        };
        let mut prompt = Prompt::default();
        prompt.take(0, &asked(PressLength::Short), "jump (F)", 0);
        assert_eq!(prompt.instruction(), "tap jump (F), briefly");
        assert!(!prompt.is_seen());
        prompt.take(0, &asked(PressLength::Short), "jump (F)", 1);
        let said = prompt.acknowledgement(24);
        assert!(
            said.starts_with("✔ press 1 of 24 seen. Do not touch the pad for 2 s"),
            "{said}"
        );
        prompt.take(0, &asked(PressLength::Short), "jump (F)", 2);
        let said = prompt.acknowledgement(24);
        assert!(said.contains("more came after it"), "{said}");
        prompt.take(1, &asked(PressLength::Short), "jump (F)", 0);
        assert_eq!(prompt.instruction(), "once more: tap jump (F), briefly");
        assert!(!prompt.is_seen());
        prompt.take(2, &asked(PressLength::Twice), "jump", 1);
        assert_eq!(
            prompt.acknowledgement(24),
            "✔ first tap seen: now the second, within 10 s"
        );
        prompt.take(2, &asked(PressLength::Twice), "jump", 2);
        assert!(prompt.is_seen());
        prompt.take(23, &asked(PressLength::Short), "jump", 1);
        let said = prompt.acknowledgement(24);
        assert!(said.ends_with("then all are done."), "{said}");
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
