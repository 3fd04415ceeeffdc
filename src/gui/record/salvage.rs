//! Saves what can be read of a damaged recording, after the player's click.

use std::path::PathBuf;
use std::sync::Arc;

use egui::Ui;

use crate::app::services::AppServices;
use crate::gui::background::{Background, take_result};

/// The file that was saved and what it holds, or why nothing was saved.
type Saved = Result<(PathBuf, String), String>;

/// A recording that could not be opened since it is damaged.
#[derive(Default)]
pub(super) struct Salvage {
    damaged: Option<PathBuf>,
    saving: Option<Background<Saved>>,
}

impl Salvage {
    /// Offers to save the readable part of a recording; `None` takes the offer back.
    pub(super) fn offer(&mut self, damaged: Option<PathBuf>) {
        self.damaged = damaged;
    }

    /// Draws the offer; returns the result of a click once it is there.
    pub(super) fn ui(&mut self, ui: &mut Ui, services: &Arc<dyn AppServices>) -> Option<Saved> {
        if self.saving.is_some() {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label("Saving what can be read …");
            });
        } else if self.damaged.is_some() {
            let button = ui.button("Save what can be read");
            let is_clicked = button
                .on_hover_text(
                    "Writes a new recording beside the damaged one, which stays as it is",
                )
                .clicked();
            if let Some(recording) = self.damaged.take_if(|_| is_clicked)
                && let Err(error) = self.start(recording, services)
            {
                return Some(Err(format!("Nothing can be saved: {error}")));
            }
        }
        take_result(&mut self.saving, || {
            Err("Nothing was saved because of a bug in gelpad".to_owned())
        })
    }

    fn start(
        &mut self,
        recording: PathBuf,
        services: &Arc<dyn AppServices>,
    ) -> std::io::Result<()> {
        let services = Arc::clone(services);
        let save = move || services.save_readable_part(&recording);
        self.saving = Some(Background::start("recover", save)?);
        Ok(())
    }
}
