//! The profile file: opened, reloaded when another program saves it, written on save.
//!
//! Files are read on the thread of a [`FileWatcher`]: a hung network share does not freeze the window.

use std::path::{Path, PathBuf};

use super::document::Document;
use super::text_draft::TextDraft;
use super::{EditView, GameContext};
use crate::app::file_watch::{FileWatcher, WatchedFile};
use crate::app::services::{AppServices, PlayRequest};
use crate::app::texts::is_path;
use crate::files::{self, FileError};
use crate::gui::play::UiAction;
use crate::profile::{Checked, Source};
use crate::types::SourceErrors;

/// A profile under edit.
pub(super) struct OpenProfile {
    /// Name of a shipped profile, or path of a file.
    pub(super) argument: String,
    pub(super) document: Document,
    /// The text last loaded or saved.
    pub(super) saved: String,
    pub(super) checked: Result<Checked, SourceErrors>,
}

impl OpenProfile {
    /// A profile whose file is no TOML, and whose text was corrected.
    pub(super) fn corrected(argument: &str, document: Document, game: GameContext<'_>) -> Self {
        Self {
            argument: argument.to_owned(),
            checked: game.check(document.text()),
            document,
            saved: String::new(),
        }
    }

    pub(super) fn is_unsaved(&self) -> bool {
        self.document.text() != self.saved
    }

    pub(super) fn is_shipped(&self) -> bool {
        !is_path(&self.argument)
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
        self.drafts.keep(self.opened.take());
        self.watcher = None;
        (self.failed, self.selected) = (None, None);
        (self.output_error, self.grid_question) = (None, None);
        (self.notice, self.text_editor) = (None, None);
        self.saved_as = None;
        if let Some(draft) = self.drafts.take(profile) {
            if is_path(profile) {
                self.watch(ctx, Some(draft.saved.clone()));
            }
            self.opened = Some(draft);
        } else if is_path(profile) {
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
        let is_reload = self.opened.is_some();
        let parsed = text.and_then(|text| match Document::parse(&text) {
            Ok(document) => Ok((document, text)),
            Err(error) => {
                if !is_reload {
                    // It can be corrected here.
                    self.text_editor = Some(TextDraft::new(&text));
                }
                Err(error.to_string())
            }
        });
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
            (Ok((document, text)), opened) => {
                self.failed = None;
                if opened.is_none() {
                    // Another program has corrected it.
                    self.text_editor = None;
                }
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
        if self.output_error.is_some() {
            self.notice = Some("not saved: correct the red field first".to_owned());
            return None;
        }
        if let Some(line) = self.text_editor.as_ref().and_then(TextDraft::broken_line) {
            self.notice = Some(format!("not saved: correct line {line} first"));
            return None;
        }
        let opened = self.opened.as_mut()?;
        let before = opened.argument.clone();
        if let Err(why) = opened.write(game.services) {
            self.notice = Some(why);
            return None;
        }
        opened.check(game);
        let (argument, text) = (opened.argument.clone(), opened.saved.clone());
        (self.notice, self.saved_as) = (None, Some(argument.clone()));
        self.argument.clone_from(&argument);
        // A new watcher: the old one may still report a text from before this save.
        self.watch(ctx, Some(text));
        // The game watches the file itself; only a copy has to be started.
        (argument != before).then(|| {
            UiAction::Play(PlayRequest {
                profile: argument,
                ..game.playing.request.clone()
            })
        })
    }

    /// Saves every profile with unsaved changes, when the window closes.
    ///
    /// # Errors
    /// The first that cannot be written, or that has mistakes.
    pub fn save_all(&mut self, services: &dyn AppServices) -> Result<(), String> {
        let opened = self.opened.iter_mut();
        for profile in opened.chain(self.drafts.all_mut()) {
            if profile.is_unsaved() {
                profile.write(services)?;
            }
        }
        Ok(())
    }
}

impl OpenProfile {
    /// Writes the text to its file. A shipped profile becomes a file of its own, under a name that is free.
    fn write(&mut self, services: &dyn AppServices) -> Result<(), String> {
        if self.checked.is_err() {
            return Err(format!(
                "{} has mistakes: correct them first",
                self.argument
            ));
        }
        let path = if self.is_shipped() {
            let Some(folder) = services.own_folder() else {
                return Err("no folder for your own settings: set HOME".to_owned());
            };
            let (name, path) = free_file(&folder.join("profiles"), &self.argument);
            self.document.rename(&name);
            path
        } else {
            PathBuf::from(&self.argument)
        };
        let text = self.document.text();
        write_atomically(&path, &text).map_err(|error| error.to_string())?;
        self.saved = text;
        self.argument = path.display().to_string();
        Ok(())
    }
}

/// A name and a file for the copy of a shipped profile: `my-NAME`, `my-NAME-2`, ...: no file is replaced.
fn free_file(folder: &Path, shipped: &str) -> (String, PathBuf) {
    let name = |number: usize| match number {
        1 => format!("my-{shipped}"),
        _ => format!("my-{shipped}-{number}"),
    };
    let file = |number| folder.join(format!("{}.toml", name(number)));
    let mut number = 1;
    while file(number).exists() {
        number += 1;
    }
    (name(number), file(number))
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
