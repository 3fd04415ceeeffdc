//! The list of recordings: open, rename, delete.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use egui::{ScrollArea, Ui};

use crate::app::own_files::{self, OwnFile};
use crate::app::services::AppServices;
use crate::gui::file_dialog::FileDialog;
use crate::gui::theme;
use crate::session::RecordingSummary;

/// How often the folder is read again while the list is shown, s.
const REFRESH_S: f64 = 2.0;

/// The recordings in the player's folder.
#[derive(Default)]
pub(super) struct RecordingList {
    files: Vec<OwnFile>,
    /// What the index of each file says: a file is read again when it was written again.
    summaries: HashMap<(PathBuf, Option<SystemTime>), Option<RecordingSummary>>,
    /// When the folder was read last, egui time, s.
    read_at_s: Option<f64>,
    dialog: FileDialog,
    /// Why the folder was not shown.
    notice: Option<String>,
}

impl RecordingList {
    /// Draws the list; returns the recording to open. `recording` is the file that is being written: it is left alone.
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        recording: Option<&Path>,
        services: &dyn AppServices,
    ) -> Option<PathBuf> {
        let now_s = ui.ctx().time();
        if self.read_at_s.is_none_or(|at| now_s - at > REFRESH_S) {
            let folder = services.recordings_folder();
            self.files = folder.map_or(Vec::new(), |folder| own_files::list(&folder, "mcap"));
            self.read_summaries();
            self.read_at_s = Some(now_s);
        }
        if self.dialog.show(ui.ctx()).is_some() {
            self.read_at_s = None;
        }
        if let Some(folder) = services
            .recordings_folder()
            .filter(|_| !self.files.is_empty())
        {
            let button = theme::small_button(ui, "Show folder");
            if button.on_hover_text(folder.display().to_string()).clicked() {
                self.notice = services.show_folder(&folder).err();
            }
        }
        if let Some(why) = &self.notice {
            ui.colored_label(theme::palette_of(ui).bad, format!("✖ {why}"));
        }
        let mut open = None;
        let now = now();
        ScrollArea::vertical().id_salt("recordings").show(ui, |ui| {
            for file in &self.files {
                ui.horizontal_wrapped(|ui| {
                    if recording == Some(&*file.path) {
                        draw_running(ui, file);
                        return;
                    }
                    let key = (file.path.clone(), file.modified);
                    let summary = self.summaries.get(&key).and_then(Option::as_ref);
                    if draw_row(ui, file, summary, now, &mut self.dialog) {
                        open = Some(file.path.clone());
                    }
                });
            }
        });
        open
    }

    /// Reads the index of files that are new or were written again, and forgets those of others.
    fn read_summaries(&mut self) {
        let mut known = std::mem::take(&mut self.summaries);
        for file in &self.files {
            let key = (file.path.clone(), file.modified);
            let summary = known.remove(&key);
            let summary = summary.unwrap_or_else(|| RecordingSummary::read(&file.path));
            self.summaries.insert(key, summary);
        }
    }

    /// Whether there are no recordings.
    pub(super) fn is_empty(&self) -> bool {
        self.files.is_empty()
    }
}

/// Draws the recording that is being written.
fn draw_running(ui: &mut Ui, file: &OwnFile) {
    let name = file.path.file_stem().unwrap_or_default().to_string_lossy();
    ui.label(name);
    ui.colored_label(theme::palette_of(ui).bad, "⏺ recording now");
    ui.weak(format!("{:.1} MB", file.bytes as f64 / 1e6));
}

/// Draws a recording of the list; whether it was chosen.
fn draw_row(
    ui: &mut Ui,
    file: &OwnFile,
    summary: Option<&RecordingSummary>,
    now: SystemTime,
    dialog: &mut FileDialog,
) -> bool {
    let name = file.path.file_stem().unwrap_or_default().to_string_lossy();
    let open = ui
        .button(format!("▶ {name}"))
        .on_hover_text(file.path.display().to_string());
    match summary {
        Some(summary) => {
            ui.label(length_in_words(summary.length));
            if let Some(profile) = &summary.profile {
                ui.label(profile.trim_end_matches(".toml"));
            }
        }
        None => {
            ui.weak("not finished");
        }
    }
    ui.weak(format!("{:.1} MB", file.bytes as f64 / 1e6));
    if let Some(age) = file.modified.and_then(|at| now.duration_since(at).ok()) {
        ui.weak(age_in_words(age));
    }
    let rename = theme::small_button(ui, "Rename");
    name_for_readers(&rename, format!("Rename {name}"));
    if rename.clicked() {
        dialog.rename(&file.path);
    }
    let delete = theme::small_button(ui, "Delete");
    name_for_readers(&delete, format!("Delete {name}"));
    if delete.clicked() {
        dialog.delete(&file.path);
    }
    open.clicked()
}

/// A label that says which file a button belongs to.
fn name_for_readers(button: &egui::Response, label: String) {
    button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, label.clone()));
}

#[allow(clippy::disallowed_methods, reason = "ages of files, for people")]
fn now() -> SystemTime {
    SystemTime::now()
}

/// Minutes and seconds: `2:07`.
fn length_in_words(length: Duration) -> String {
    let seconds = length.as_secs_f64().round() as u64;
    format!("{}:{:02}", seconds / 60, seconds % 60)
}

/// How long ago, in words.
fn age_in_words(age: Duration) -> String {
    let (count, unit) = match age.as_secs() {
        0..60 => return "just now".to_owned(),
        seconds @ 60..3600 => (seconds / 60, "minute"),
        seconds @ 3600..86_400 => (seconds / 3600, "hour"),
        seconds => (seconds / 86_400, "day"),
    };
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {unit}{plural} ago")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_minutes_and_seconds() {
        let words = |ms| length_in_words(Duration::from_millis(ms));
        assert_eq!(words(400), "0:00");
        assert_eq!(words(59_600), "1:00");
        assert_eq!(words(3_661_000), "61:01");
    }

    #[test]
    fn ages_are_rounded_down() {
        let words = |seconds| age_in_words(Duration::from_secs(seconds));
        assert_eq!(words(59), "just now");
        assert_eq!(words(119), "1 minute ago");
        assert_eq!(words(7200), "2 hours ago");
        assert_eq!(words(200_000), "2 days ago");
    }
}
