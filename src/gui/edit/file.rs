//! The profile file: opened, reloaded when another program saves it, written on save.
//!
//! Files are read on the thread of a [`FileWatcher`]: a hung network share does not freeze the window.

use std::path::{Path, PathBuf};

use super::document::Document;
use super::{EditView, GameContext};
use crate::app::file_watch::{FileWatcher, WatchedFile};
use crate::app::services::PlayRequest;
use crate::files::{self, FileError};
use crate::gui::play::{UiAction, file_name};
use crate::profile::{Checked, Source};
use crate::types::SourceErrors;

/// A profile under edit.
pub(super) struct OpenProfile {
    /// Name of a shipped profile, or path of a file.
    pub(super) argument: String,
    pub(super) document: Document,
    /// The text last loaded or saved.
    saved: String,
    pub(super) checked: Result<Checked, SourceErrors>,
}

impl OpenProfile {
    pub(super) fn is_unsaved(&self) -> bool {
        self.document.text() != self.saved
    }

    pub(super) fn is_shipped(&self) -> bool {
        !is_file(&self.argument)
    }

    pub(super) fn check(&mut self, game: GameContext<'_>) {
        self.checked = game.check(self.document.text());
    }
}

impl GameContext<'_> {
    /// Checks the text of the profile with the user settings of the game.
    fn check(self, toml: String) -> Result<Checked, SourceErrors> {
        let request = &self.playing.request;
        let name = request.profile.clone();
        let source = Source { name, toml };
        self.services.check_profile(source, request.user.as_deref())
    }
}

impl EditView {
    /// Opens the profile of the play request, unless it is open, loading or failed.
    pub(super) fn open(&mut self, ctx: &egui::Context, game: GameContext<'_>) {
        let profile = &game.playing.request.profile;
        if self.requested == *profile {
            return;
        }
        self.requested.clone_from(profile);
        if self.argument == *profile {
            // The copy of a shipped profile, open since it was saved.
            return;
        }
        self.argument.clone_from(profile);
        (self.opened, self.watcher) = (None, None);
        (self.failed, self.selected) = (None, None);
        if is_file(profile) {
            self.watch(ctx, None);
        } else {
            self.load(game.services.profile_text(profile), game);
        }
    }

    /// Watches the file of the profile; `known` is the text that it should hold.
    fn watch(&mut self, ctx: &egui::Context, known: Option<String>) {
        let file = WatchedFile {
            path: PathBuf::from(&self.argument),
            known,
        };
        let ctx = ctx.clone();
        match FileWatcher::start(vec![file], move || ctx.request_repaint()) {
            Ok(watcher) => self.watcher = Some(watcher),
            Err(error) => self.failed = Some(format!("cannot watch the file: {error}")),
        }
    }

    /// Loads what the watcher found in the file.
    pub(super) fn load_changes(&mut self, game: GameContext<'_>) {
        while let Some(change) = self.watcher.as_ref().and_then(FileWatcher::try_recv) {
            self.load(change.text, game);
        }
    }

    /// Takes a new text of the file, unless there are unsaved changes.
    fn load(&mut self, text: Result<String, String>, game: GameContext<'_>) {
        let parsed = text.and_then(|text| match Document::parse(&text) {
            Ok(document) => Ok((document, text)),
            Err(error) => Err(error.to_string()),
        });
        let is_reload = self.opened.is_some();
        self.notice = match (parsed, &self.opened) {
            (Err(why), None) => {
                self.failed = Some(why);
                return;
            }
            (Err(why), Some(_)) => Some(format!("the file on disk: {why}; saving replaces it")),
            (Ok((_, text)), Some(opened)) if text == opened.saved => None,
            (Ok(_), Some(opened)) if opened.is_unsaved() => Some(
                "the file was changed by another program: undo your changes to load it, or save to replace it"
                    .to_owned(),
            ),
            (Ok((document, text)), _) => {
                self.failed = None;
                self.opened = Some(OpenProfile {
                    argument: self.argument.clone(),
                    document,
                    checked: game.check(text.clone()),
                    saved: text,
                });
                is_reload.then(|| "reloaded: the file was changed by another program".to_owned())
            }
        };
    }

    /// Writes the text to its file; a shipped profile is written to the player's own folder, and that copy is played.
    pub(super) fn save(&mut self, ctx: &egui::Context, game: GameContext<'_>) -> Option<UiAction> {
        let opened = self.opened.as_mut()?;
        let text = opened.document.text();
        let path = if opened.is_shipped() {
            let Some(folder) = game.services.own_folder() else {
                self.notice = Some("no folder for your own settings: set HOME".to_owned());
                return None;
            };
            let name = format!("{}.toml", file_name(&opened.argument));
            folder.join("profiles").join(name)
        } else {
            PathBuf::from(&opened.argument)
        };
        if let Err(error) = write_atomically(&path, &text) {
            self.notice = Some(error.to_string());
            return None;
        }
        opened.saved.clone_from(&text);
        let argument = path.display().to_string();
        self.notice = Some(format!("saved: {argument}"));
        let is_copy = argument != opened.argument;
        opened.argument.clone_from(&argument);
        self.argument.clone_from(&argument);
        // A new watcher: the old one may still report a text from before this save.
        self.watch(ctx, Some(text));
        // The game watches the file itself; only a copy has to be started.
        is_copy.then(|| {
            UiAction::Play(PlayRequest {
                profile: argument,
                ..game.playing.request.clone()
            })
        })
    }
}

fn is_file(argument: &str) -> bool {
    argument.contains('/') || argument.ends_with(".toml")
}

/// Writes a file, and the folder that it is in, so that no program reads half of it.
pub(in crate::gui) fn write_atomically(path: &Path, text: &str) -> Result<(), FileError> {
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder {
        std::fs::create_dir_all(folder).map_err(|error| FileError::new(folder, error))?;
    }
    files::write(path, text.as_bytes())
}
