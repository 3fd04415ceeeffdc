//! Asks before the window closes while some edits are not saved.

use std::sync::Arc;

use egui::{Context, Id, Modal, ViewportCommand};

use super::edit::EditView;
use super::request::file_name;
use super::theme;
use crate::app::services::AppServices;

/// The question on closing.
#[derive(Default)]
pub struct Closing {
    /// Close without asking: a signal ends the program.
    pub forced: bool,
    asks: bool,
    /// Why saving failed.
    failed: Option<String>,
}

impl Closing {
    /// Holds a close request back while edits are unsaved, and draws the question.
    pub(super) fn show(
        &mut self,
        ctx: &Context,
        edit: &mut EditView,
        services: &Arc<dyn AppServices>,
    ) {
        let unsaved = edit.unsaved();
        let requested = ctx.input(|input| input.viewport().close_requested());
        if requested && !self.forced && !unsaved.is_empty() {
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
            self.asks = true;
        }
        if !self.asks {
            return;
        }
        let mut closes = false;
        let modal = Modal::new(Id::unique("closing")).show(ctx, |ui| {
            ui.set_max_width(380.0);
            ui.heading("Save your changes?");
            let names: Vec<String> = unsaved.iter().map(|one| file_name(one)).collect();
            ui.label(format!("Not saved: {}.", names.join(", ")));
            if let Some(why) = &self.failed {
                ui.colored_label(theme::palette_of(ui).bad, format!("✖ {why}"));
            }
            ui.add_space(6.0);
            ui.horizontal_wrapped(|ui| {
                if theme::primary(ui, "Save and close").clicked() {
                    match edit.save_all(services.as_ref()) {
                        Ok(()) => closes = true,
                        Err(why) => self.failed = Some(why),
                    }
                }
                closes |= ui.button("Close without saving").clicked();
                if ui.button("Keep editing").clicked() {
                    ui.close();
                }
            });
        });
        if closes {
            self.forced = true;
            ctx.send_viewport_cmd(ViewportCommand::Close);
        }
        if closes || modal.should_close() {
            self.asks = false;
            self.failed = None;
        }
    }
}
