//! Saves what can be read of a damaged recording, after the player's click.

use std::path::PathBuf;
use std::sync::Arc;

use egui::Ui;

use crate::app::services::{AppServices, SavedPart};
use crate::gui::background::{Background, take_result};

/// A recording that could not be opened since it is damaged.
#[derive(Default)]
pub(super) struct Salvage {
    damaged: Option<PathBuf>,
    saving: Option<Background<Result<SavedPart, String>>>,
    /// Whether what is being saved is opened then: no other file was opened meanwhile.
    opens_saved: bool,
}

/// The end of a save.
pub(super) struct Salvaged {
    pub(super) result: Result<SavedPart, String>,
    /// Whether the player still waits for it.
    pub(super) is_awaited: bool,
}

impl Salvage {
    /// Offers to save the readable part of a recording; `None` takes the offer back.
    pub(super) fn offer(&mut self, damaged: Option<PathBuf>) {
        self.damaged = damaged;
        self.opens_saved = false;
    }

    /// Draws the offer; returns what a click led to once that is known.
    pub(super) fn ui(&mut self, ui: &mut Ui, services: &Arc<dyn AppServices>) -> Option<Salvaged> {
        if self.saving.is_some() {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label("Saving what can be read …");
            });
        } else if let Some(recording) = &self.damaged {
            let name = recording.file_name().unwrap_or_default().to_string_lossy();
            let button = ui.button(format!("Save what can be read of {name}"));
            let button = button.on_hover_text(
                "Writes a new recording beside the damaged one, which stays as it is",
            );
            if button.clicked() {
                let (recording, services) = (recording.clone(), Arc::clone(services));
                let save = move || services.save_readable_part(&recording);
                self.opens_saved = true;
                match Background::start("recover", save) {
                    Ok(saving) => self.saving = Some(saving),
                    Err(error) => {
                        return Some(self.end(Err(format!("Nothing can be saved: {error}"))));
                    }
                }
            }
        }
        let died = || Err("Nothing was saved because of a bug in gelpad".to_owned());
        let result = take_result(&mut self.saving, died)?;
        Some(self.end(result))
    }

    /// The offer stays where nothing was saved: the player may make room and try again.
    fn end(&mut self, result: Result<SavedPart, String>) -> Salvaged {
        let is_awaited = std::mem::take(&mut self.opens_saved);
        if result.is_ok() && is_awaited {
            self.damaged = None;
        }
        Salvaged { result, is_awaited }
    }
}
