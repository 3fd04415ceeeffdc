//! Dialogs that rename or delete a file of the player.

use std::path::{Path, PathBuf};

use egui::text::{CCursor, CCursorRange};
use egui::text_edit::TextEditState;
use egui::{Context, Id, Modal, Ui};

use super::theme;
use crate::app::own_files;

/// What was done with a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum FileChange {
    /// It has another name now.
    Renamed(PathBuf),
    /// It is gone.
    Deleted,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Task {
    Rename,
    Delete,
}

/// The open dialog, if one is.
#[derive(Default)]
pub(super) struct FileDialog {
    open: Option<(Task, PathBuf)>,
    name: String,
    /// Whether the dialog has just opened: the name is to be selected, or *Cancel* to get the focus.
    is_new: bool,
    failed: Option<String>,
}

impl FileDialog {
    /// Opens the dialog that renames a file.
    pub(super) fn rename(&mut self, path: &Path) {
        let stem = path.file_stem().unwrap_or_default();
        self.name = stem.to_string_lossy().into_owned();
        self.is_new = true;
        (self.open, self.failed) = (Some((Task::Rename, path.to_owned())), None);
    }

    /// Opens the question before a file is deleted.
    pub(super) fn delete(&mut self, path: &Path) {
        self.is_new = true;
        (self.open, self.failed) = (Some((Task::Delete, path.to_owned())), None);
    }

    /// Draws the dialog; returns the file and what was done with it.
    pub(super) fn show(&mut self, ctx: &Context) -> Option<(PathBuf, FileChange)> {
        let (task, path) = self.open.clone()?;
        let mut result = None;
        let modal = Modal::new(Id::unique("file dialog")).show(ctx, |ui| {
            ui.set_max_width(360.0);
            result = match task {
                Task::Rename => self.draw_rename(ui, &path),
                Task::Delete => draw_delete(ui, &path),
            };
            if let Some(why) = &self.failed {
                ui.colored_label(theme::palette_of(ui).bad, format!("✖ {why}"));
            }
            let cancel = ui.button("Cancel");
            if self.is_new && !ui.is_sizing_pass() {
                self.is_new = false;
                cancel.request_focus();
            }
            if cancel.clicked() {
                ui.close();
            }
        });
        match result {
            Some(Ok(change)) => {
                self.open = None;
                return Some((path, change));
            }
            Some(Err(why)) => self.failed = Some(why),
            None if modal.should_close() => self.open = None,
            None => {}
        }
        None
    }

    fn draw_rename(&mut self, ui: &mut Ui, path: &Path) -> Option<Result<FileChange, String>> {
        ui.heading("Rename");
        let label = ui.label("New name");
        let id = ui.make_persistent_id("new name");
        let field = ui.add(egui::TextEdit::singleline(&mut self.name).id(id));
        let field = field.labelled_by(label.id);
        if self.is_new && !ui.is_sizing_pass() {
            self.is_new = false;
            field.request_focus();
            select_all(ui.ctx(), id, &self.name);
        }
        let entered = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        let clicked = theme::primary(ui, "Rename").clicked();
        let renames = clicked || entered;
        renames.then(|| own_files::rename(path, &self.name).map(FileChange::Renamed))
    }
}

/// Selects the text of a field: typing replaces it.
fn select_all(ctx: &Context, field: Id, text: &str) {
    let mut state = TextEditState::load(ctx, field).unwrap_or_default();
    let end = CCursor::new(text.chars().count());
    let all = CCursorRange::two(CCursor::new(0), end);
    state.cursor.set_char_range(Some(all));
    state.store(ctx, field);
}

fn draw_delete(ui: &mut Ui, path: &Path) -> Option<Result<FileChange, String>> {
    ui.heading("Delete?");
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    ui.label(format!("{name} cannot be restored."));
    let clicked = ui.button("Delete").clicked();
    clicked.then(|| own_files::delete(path).map(|()| FileChange::Deleted))
}
