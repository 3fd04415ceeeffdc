//! The settings of the person who plays, as sliders beside what they do right now. Each change is saved in the person's file, which
//! the running game loads.
//!
//! A shipped person is never changed: the first change makes a file of the player's own.

use std::path::{Path, PathBuf};

use egui::Ui;

use crate::app::services::{AppServices, PlayRequest};
use crate::app::texts::is_path;
use crate::gui::edit::document::Document;
use crate::gui::edit::write_atomically;
use crate::gui::playing::Playing;
use crate::gui::request::{UiAction, file_name};
use crate::gui::theme;
use crate::gui::timing_settings::{HintPlace, SETTINGS, draw_slider};

/// The file of a player without a name.
const UNNAMED: &str = "me";

/// The key of the only switch among the settings.
const STICKY_KEYS: &str = "sticky_keys";

/// A changed setting.
#[derive(Clone, Copy)]
enum Setting {
    Number(f64),
    Flag(bool),
}

/// State of the card.
#[derive(Default)]
pub(super) struct PersonSettings {
    /// The slider that is being dragged, and its value.
    dragged: Option<(&'static str, f64)>,
    notice: Option<String>,
}

impl PersonSettings {
    /// Draws the card; returns the game with a person's new file.
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        playing: &Playing,
        services: &dyn AppServices,
    ) -> Option<UiAction> {
        let user = playing.request.user.as_deref();
        draw_whose(ui, user, services);
        ui.weak(
            "Play chooses the person. Set up, step 5, recommends settings from your own presses.",
        );
        let settings = &playing.view.profile.settings;
        let mut change = self.draw_sliders(ui, playing);
        let mut sticky_keys = settings.sticky_keys;
        let label = "Sticky keys";
        if ui.checkbox(&mut sticky_keys, label).changed() {
            change = Some((STICKY_KEYS, Setting::Flag(sticky_keys)));
        }
        let hint = "Shift, Ctrl, Alt and Meta stay down until another press is over: one finger is enough for both.";
        ui.add(egui::Label::new(egui::RichText::new(hint).small().weak()).wrap());
        if let Some(why) = &self.notice {
            ui.colored_label(theme::palette_of(ui).bad, format!("✖ {why}"));
        }
        let path = match save(user, change?, services) {
            Ok(path) => path.display().to_string(),
            Err(why) => {
                self.notice = Some(why);
                return None;
            }
        };
        self.notice = None;
        // The game watches the file that it plays with; only another one has to be started.
        (user != Some(&*path)).then(|| {
            UiAction::Play(PlayRequest {
                user: Some(path),
                ..playing.request.clone()
            })
        })
    }

    /// Draws a slider for each setting that is a number; returns the one that was changed, once it is let go.
    fn draw_sliders(&mut self, ui: &mut Ui, playing: &Playing) -> Option<(&'static str, Setting)> {
        let settings = &playing.view.profile.settings;
        let mut change = None;
        for setting in &SETTINGS {
            let saved = (setting.value)(settings);
            let dragged = self.dragged.filter(|(key, _)| *key == setting.key);
            let shown = dragged.map_or(saved, |(_, value)| value);
            let live = (setting.live)(playing);
            let (wanted, is_final) = draw_slider(ui, setting, shown, live, HintPlace::Below);
            ui.add_space(6.0);
            if (wanted - shown).abs() > 1e-9 {
                self.dragged = Some((setting.key, wanted));
            }
            let is_dragged = ui.input(|input| input.pointer.any_down());
            if let Some((key, value)) = self.dragged
                && key == setting.key
                && (is_final || !is_dragged)
            {
                self.dragged = None;
                change = Some((key, Setting::Number(value)));
            }
        }
        change
    }
}

/// Says whose settings are played with.
fn draw_whose(ui: &mut Ui, user: Option<&str>, services: &dyn AppServices) {
    if let Some(user) = user {
        ui.label(format!("Playing with the settings of {}.", file_name(user)));
        return;
    }
    let folder = services.own_folder().unwrap_or_default().join("users");
    let file = own_file(None, &folder);
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    ui.label(format!(
        "Playing without personal settings: a change starts your own, saved as {name}."
    ));
}

/// Writes a change into the person's own file; returns its path.
fn save(
    user: Option<&str>,
    (key, value): (&str, Setting),
    services: &dyn AppServices,
) -> Result<PathBuf, String> {
    let folder = services.own_folder();
    let folder = folder.ok_or("no folder for your own settings: set HOME")?;
    let folder = folder.join("users");
    let text = user.map_or(Ok(String::new()), |user| services.user_text(user))?;
    let mut document = Document::parse(&text).map_err(|error| error.to_string())?;
    match value {
        Setting::Number(number) => document.set_number(key, number),
        Setting::Flag(flag) => document.set_flag(key, flag),
    }
    let path = own_file(user, &folder);
    write_atomically(&path, &document.text()).map_err(|error| error.to_string())?;
    Ok(path)
}

/// The file that a person's changes are written to: their own, or a new one.
fn own_file(user: Option<&str>, folder: &Path) -> PathBuf {
    let file = |name: &str| folder.join(format!("{name}.toml"));
    match user {
        Some(path) if is_path(path) => PathBuf::from(path),
        Some(name) if file(name).exists() => file(name),
        Some(shipped) => free_file(&file, &format!("my-{shipped}")),
        None => free_file(&file, UNNAMED),
    }
}

fn free_file(file: &dyn Fn(&str) -> PathBuf, name: &str) -> PathBuf {
    let numbered = (2..).map(|number| file(&format!("{name}-{number}")));
    std::iter::once(file(name))
        .chain(numbered)
        .find(|path| !path.exists())
        .unwrap_or_default()
}
