//! The first step: choose the board and the pad, and see the quality of the readings.

use egui::Ui;

use super::paragraph;
use crate::app::services::{AppServices, SourceChoice};
use crate::gui::play::{Names, UiAction, file_name};
use crate::gui::playing::Playing;
use crate::gui::signals;

/// Draws the step.
pub(super) fn ui(
    ui: &mut Ui,
    playing: &Playing,
    services: &dyn AppServices,
    names: &mut Names,
) -> Option<UiAction> {
    paragraph(
        ui,
        "Plug the board in, then choose its port. Without a board, use the simulated pad: press it with the mouse.",
    );
    let mut wanted = playing.request.clone();
    ui.radio_value(&mut wanted.source, SourceChoice::Simulated, "Simulated pad");
    for port in &names.ports {
        ui.radio_value(&mut wanted.source, SourceChoice::Serial(port.clone()), port);
    }
    if names.ports.is_empty() {
        ui.weak("No serial port found. If the board is plugged in, check that its cable carries data and not only power.");
    }
    if ui.button("⟲ Search again").clicked() {
        names.ports = services.ports();
    }
    egui::ComboBox::from_label("Pad")
        .selected_text(file_name(&playing.request.pad))
        .show_ui(ui, |ui| {
            for name in &names.pads {
                ui.selectable_value(&mut wanted.pad, name.clone(), file_name(name));
            }
        });
    if wanted != playing.request {
        // A calibration belongs to one pad.
        wanted.calibration = None;
        return Some(UiAction::Play(wanted));
    }
    ui.separator();
    let figures = signals::health::from_signals(
        &playing.view.signals,
        &playing.first_reference,
        &playing.pad.protocol,
    );
    signals::health_table(ui, playing, &figures);
    None
}
