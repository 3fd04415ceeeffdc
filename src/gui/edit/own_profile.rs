//! Own profiles: renamed, duplicated and deleted. The name in the text follows that of the file.

use std::path::{Path, PathBuf};

use egui::{Context, Ui};

use super::document::Document;
use super::file::{OpenProfile, write_atomically};
use super::{EditView, GameContext};
use crate::app::services::PlayRequest;
use crate::app::texts::is_path;
use crate::gui::file_dialog::FileChange;
use crate::gui::play::UiAction;
use crate::gui::theme;
use crate::profile::DEFAULT_PROFILE;

impl EditView {
    /// The buttons of a profile that is a file of the player.
    pub(super) fn draw_own_profile_buttons(
        &mut self,
        ui: &mut Ui,
        game: GameContext<'_>,
    ) -> Option<UiAction> {
        if !is_path(&self.argument) {
            return None;
        }
        let path = PathBuf::from(&self.argument);
        let row = ui.horizontal_wrapped(|ui| {
            if theme::small_button(ui, "Rename").clicked() {
                self.dialog.rename(&path);
            }
            let duplicates = theme::small_button(ui, "Duplicate").clicked();
            if theme::small_button(ui, "Delete").clicked() {
                self.dialog.delete(&path);
            }
            duplicates
        });
        if !row.inner {
            return None;
        }
        let edited = self.opened.as_ref().filter(|opened| opened.is_unsaved());
        if edited.is_some_and(|opened| opened.checked.is_err()) || self.text_editor.is_some() {
            self.notice = Some("not duplicated: correct or save the text first".to_owned());
            return None;
        }
        match duplicate(&path, edited.map(|opened| opened.document.text())) {
            Ok(copy) => Some(play(&copy.display().to_string(), game)),
            Err(why) => {
                self.notice = Some(why);
                None
            }
        }
    }

    /// Draws the open dialog. A renamed profile is played under its new name; instead of a deleted one, the default.
    pub(super) fn finish_file_dialog(
        &mut self,
        ctx: &Context,
        game: GameContext<'_>,
    ) -> Option<UiAction> {
        let (_, change) = self.dialog.show(ctx)?;
        self.watcher = None;
        // Unsaved changes would be written to the old file.
        let opened = self.opened.take();
        match change {
            FileChange::Renamed(path) => {
                let argument = path.display().to_string();
                match name_after_file(&path) {
                    Ok(saved) => self
                        .drafts
                        .keep(opened.map(|opened| moved(opened, &path, saved))),
                    Err(why) => {
                        let moved = |opened: OpenProfile| {
                            let saved = opened.saved.clone();
                            moved(opened, &path, saved)
                        };
                        self.drafts.keep(opened.map(moved));
                        self.notice = Some(why);
                    }
                }
                Some(play(&argument, game))
            }
            FileChange::Deleted => Some(play(DEFAULT_PROFILE, game)),
        }
    }
}

/// A profile with its unsaved changes and their history, after its file was renamed and has a new text.
fn moved(mut opened: OpenProfile, path: &Path, saved: String) -> OpenProfile {
    opened.document.rename(&stem_of(path));
    opened.argument = path.display().to_string();
    opened.saved = saved;
    opened
}

fn stem_of(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

fn play(profile: &str, game: GameContext<'_>) -> UiAction {
    UiAction::Play(PlayRequest {
        profile: profile.to_owned(),
        ..game.playing.request.clone()
    })
}

/// Copies a profile beside itself, as `NAME-2`, `NAME-3`, ...: as it is in the file, or with unsaved changes.
fn duplicate(path: &Path, edited: Option<String>) -> Result<PathBuf, String> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let base = match stem.rsplit_once('-') {
        Some((base, number)) if number.parse::<u32>().is_ok() => base,
        _ => &stem,
    };
    let copy = (2..)
        .map(|number| path.with_file_name(format!("{base}-{number}.toml")))
        .find(|copy| !copy.exists())
        .unwrap_or_default();
    match edited {
        Some(text) => write_atomically(&copy, &text).map_err(|error| error.to_string())?,
        None => {
            std::fs::copy(path, &copy).map_err(|error| format!("{}: {error}", copy.display()))?;
        }
    }
    name_after_file(&copy)?;
    Ok(copy)
}

/// Writes the name of the file into the text, and returns it. A text with mistakes stays as it is.
fn name_after_file(path: &Path) -> Result<String, String> {
    let failed = |error: std::io::Error| format!("{}: {error}", path.display());
    let text = std::fs::read_to_string(path).map_err(failed)?;
    let Ok(mut document) = Document::parse(&text) else {
        return Ok(text);
    };
    document.rename(&stem_of(path));
    let text = document.text();
    write_atomically(path, &text).map_err(|error| error.to_string())?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{Profile, shipped_profile};

    #[test]
    fn a_duplicate_has_a_name_of_its_own() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("mine.toml");
        let mario = shipped_profile("super-mario").expect("shipped").toml;
        std::fs::write(&path, mario).expect("written");
        for name in ["mine-2", "mine-3"] {
            let copy = duplicate(&path, None).expect("copied");
            assert_eq!(copy, folder.path().join(format!("{name}.toml")));
            let text = std::fs::read_to_string(&copy).expect("a file");
            assert_eq!(Profile::from_toml("p", &text).expect("valid").name, name);
        }
    }
}
