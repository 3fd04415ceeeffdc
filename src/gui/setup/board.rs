//! The first step: which board, which pad, and how good its readings are.

use egui::Ui;

use super::say;
use crate::gui::desk::{Desk, From};
use crate::gui::play::{Names, Wish, file_name};
use crate::gui::playing::Playing;
use crate::gui::signals;

/// Draws the step.
pub(super) fn ui(
    ui: &mut Ui,
    playing: &Playing,
    desk: &dyn Desk,
    names: &mut Names,
) -> Option<Wish> {
    say(
        ui,
        "Plug the board in, then choose its port. Without a board, the simulated pad plays: press it with the mouse.",
    );
    let mut wanted = playing.choice.clone();
    ui.radio_value(&mut wanted.from, From::Hand, "Simulated pad");
    for port in &names.ports {
        ui.radio_value(&mut wanted.from, From::Serial(port.clone()), port);
    }
    if names.ports.is_empty() {
        ui.weak("No serial port is there. If the board is plugged in: does the cable carry data?");
    }
    if ui.button("⟲ Look again").clicked() {
        names.ports = desk.ports();
    }
    egui::ComboBox::from_label("Pad")
        .selected_text(file_name(&playing.choice.pad))
        .show_ui(ui, |ui| {
            for name in &names.pads {
                ui.selectable_value(&mut wanted.pad, name.clone(), file_name(name));
            }
        });
    if wanted != playing.choice {
        // Another pad has another calibration.
        wanted.calibration = None;
        return Some(Wish::Play(wanted));
    }
    ui.separator();
    let figures = signals::health::health(
        &playing.view.signals,
        &playing.first_reference,
        &playing.pad.protocol,
    );
    signals::rows(ui, playing, &figures);
    None
}
