//! The first step: choose the board and the pad, and see the quality of the readings.

use egui::Ui;

use super::paragraph;
use crate::app::services::{AppServices, SourceChoice};
use crate::gui::choice;
use crate::gui::play::{Names, UiAction, file_name};
use crate::gui::playing::Playing;
use crate::gui::{signals, theme};
use crate::source::wire::FormatChoice;

/// Draws the choice of source and pad.
pub(super) fn choose(
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
    if let SourceChoice::Serial(port) = &playing.request.source
        && !names.ports.contains(port)
    {
        ui.radio_value(&mut wanted.source, SourceChoice::Serial(port.clone()), port);
    }
    ui.radio_value(
        &mut wanted.source,
        SourceChoice::Gamepad,
        "Gamepad or switches",
    );
    if let Some(port) = other_port(ui) {
        wanted.source = SourceChoice::Serial(port);
    }
    if names.ports.is_empty() {
        ui.weak("No serial port found. If the board is plugged in, check that its cable carries data and not only power.");
    }
    if ui.button("⟲ Search again").clicked() {
        names.ports = services.ports();
    }
    let combo = egui::ComboBox::from_label("Pad").selected_text(file_name(&playing.request.pad));
    let pads = names.pads.iter();
    let pads = pads.map(|name| (name.clone(), file_name(name)));
    if let Some(pad) = choice::list(ui, combo, None, &playing.request.pad, pads.collect()) {
        wanted.pad = pad;
    }
    if wanted.source != playing.request.source {
        // So does a format to one board.
        wanted.board.format = FormatChoice::default();
    }
    if wanted != playing.request {
        // A calibration belongs to one pad.
        wanted.calibration = None;
        return Some(UiAction::Play(wanted));
    }
    None
}

/// Draws why the board's frames are not played, if they are not.
pub(super) fn draw_misfit(ui: &mut Ui, playing: &Playing) {
    let ended = playing.ended.as_deref();
    let skipped = playing.skip_reason.as_deref();
    let Some(reason) = ended.or(skipped.filter(|_| playing.view.frames == 0)) else {
        return;
    };
    ui.colored_label(theme::palette_of(ui).bad, format!("✖ {reason}"));
    if matches!(playing.request.source, SourceChoice::Serial(_)) {
        paragraph(
            ui,
            "Diagnose this port finds out what it sends, and which pad fits.",
        );
    }
}

/// Draws the quality of the readings.
pub(super) fn quality(ui: &mut Ui, playing: &Playing) {
    if playing.request.source == SourceChoice::Gamepad {
        return;
    }
    ui.separator();
    let figures = signals::health::from_signals(
        &playing.view.signals,
        &playing.first_reference,
        &playing.pad.protocol,
    );
    signals::health_table(ui, playing, &figures);
}

/// A port to type: a pseudo-terminal, or a link that the system does not list.
fn other_port(ui: &mut Ui) -> Option<String> {
    let id = ui.scope_id().with("other port");
    let mut port = ui.data_mut(|data| data.get_temp::<String>(id).unwrap_or_default());
    let row = ui.horizontal(|ui| {
        let label = ui.label("Other port");
        let field = egui::TextEdit::singleline(&mut port)
            .desired_width((ui.available_width() - 70.0).clamp(80.0, 220.0))
            .hint_text("/dev/pts/3");
        let field = ui.add(field).labelled_by(label.id);
        theme::keep_focus_on_enter(ui, &field);
        let entered = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        let is_named = !port.trim().is_empty();
        let used = ui.add_enabled(is_named, egui::Button::new("Use")).clicked();
        is_named && (used || entered)
    });
    let chosen = row.inner.then(|| port.trim().to_owned());
    ui.data_mut(|data| data.insert_temp(id, port));
    chosen
}
