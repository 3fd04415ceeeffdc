//! The side panel of the play view: what is played, held outputs, press lengths, the simulated pad, timing.

use std::path::{Path, PathBuf};

use egui::Ui;

use super::{controller, presses};
use crate::app::services::{OutputChoice, PlayRequest, SourceChoice};
use crate::gui::choice;
use crate::gui::playing::Playing;
use crate::gui::problem::SHORTEST_PRESS_FRAMES;
use crate::gui::request::{Names, UiAction, file_name, output_words};
use crate::gui::theme;
use crate::runtime::PlayCommand;

/// Width of the names before the lists, points.
const NAME_WIDTH: f32 = 66.0;
/// The label for the profile whose `[match]` names the program that runs.
const BY_GAME: &str = "by the running game";
/// The label for no personal settings.
const NOBODY: &str = "anyone";

/// Draws the panel; returns what the player requested.
pub(super) fn ui(
    ui: &mut Ui,
    playing: &mut Playing,
    names: &Names,
    is_pad_open: bool,
) -> Option<UiAction> {
    let card = theme::card(ui).show(ui, |ui| {
        ui.set_width(ui.available_width());
        let chosen = choose(ui, &playing.request, names);
        buttons(ui, playing, is_pad_open).or(chosen)
    });
    theme::titled_card(ui, "Game input", |ui| controller::draw(ui, playing));
    theme::titled_card(ui, "Press length", |ui| presses::ui(ui, playing));
    if playing.is_simulated() {
        theme::titled_card(ui, "Simulated pad", |ui| simulated_pad(ui, playing));
    }
    timing(ui, playing);
    card.inner
}

fn buttons(ui: &mut Ui, playing: &mut Playing, is_pad_open: bool) -> Option<UiAction> {
    let row = ui.horizontal_wrapped(|ui| {
        let mut button = |label, hint| ui.button(label).on_hover_text(hint).clicked();
        let paused = playing.view.paused;
        let label = if paused { "▶ Resume" } else { "⏸ Pause" };
        if button(label, "Pausing releases all keys and sends none") {
            playing.send_command(PlayCommand::Pause);
        }
        if button(
            "Zero",
            "Reset the untouched state: take your hands off the pad first",
        ) {
            playing.send_command(PlayCommand::Rezero);
        }
        let label = match is_pad_open {
            true => "✖ Close the pad window",
            false => "🗖 Pad window",
        };
        if button(
            label,
            "A small pad on top of everything, which you can press while your game has the keyboard",
        ) {
            return Some(UiAction::PadWindow);
        }
        let overlay = button(
            "Overlay",
            "Shows or hides regions and touches on top of your game; clicks go through it. It lies where the pad window was",
        );
        overlay.then_some(UiAction::Overlay)
    });
    row.inner
}

/// Lists of profiles, sources and outputs; returns the changed game.
fn choose(ui: &mut Ui, request: &PlayRequest, names: &Names) -> Option<UiAction> {
    let mut chosen = request.clone();
    choose_profile(ui, &mut chosen, names);
    let label = request.source_label();
    let sources = source_entries(names);
    if let Some(source) = list(ui, "Source", &label, &request.source, sources) {
        chosen.source = source;
    }
    let outputs = [
        OutputChoice::Nothing,
        OutputChoice::Auto,
        OutputChoice::Keyboard,
        OutputChoice::Gamepad,
    ];
    let entries = outputs.map(|output| (output, output_label(output).to_owned()));
    let label = output_label(request.output);
    if let Some(output) = list(ui, "Output", label, &request.output, entries.into()) {
        chosen.output = output;
    }
    let label = request.user.as_deref().map_or(NOBODY.to_owned(), file_name);
    let people = names.users.iter();
    let people = people.map(|user| (Some(user.clone()), file_name(user)));
    let people = std::iter::once((None, NOBODY.to_owned())).chain(people);
    if let Some(user) = list(ui, "Person", &label, &request.user, people.collect()) {
        chosen.user = user;
    }
    if !names.calibrations.is_empty() || request.calibration.is_some() {
        let text = |file: &PathBuf| calibration_name(file);
        let label = request.calibration.as_ref().map_or("none".to_owned(), text);
        let files = names.calibrations.iter();
        let files = files.map(|file| (Some(file.clone()), text(file)));
        let files = std::iter::once((None, "none".to_owned())).chain(files);
        let files = files.collect();
        if let Some(file) = list(ui, "Calibrated", &label, &request.calibration, files) {
            chosen.calibration = file;
        }
    }
    (chosen != *request).then_some(UiAction::Play(chosen))
}

/// The list of profiles; its first entry follows the game that runs.
fn choose_profile(ui: &mut Ui, chosen: &mut PlayRequest, names: &Names) {
    let profiles = names.profiles.iter();
    let entries = profiles.map(|name| (Some(name.clone()), file_name(name)));
    let entries = std::iter::once((None, BY_GAME.to_owned())).chain(entries);
    let current = (!chosen.match_programs).then(|| chosen.profile.clone());
    let label = match chosen.match_programs {
        true => format!("{BY_GAME}, else {}", file_name(&chosen.profile)),
        false => file_name(&chosen.profile),
    };
    match list(ui, "Profile", &label, &current, entries.collect()) {
        Some(Some(profile)) => {
            chosen.profile = profile;
            chosen.match_programs = false;
        }
        Some(None) => chosen.match_programs = true,
        None => {}
    }
}

/// The name of a calibration's file without its extension.
fn calibration_name(file: &Path) -> String {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    name.trim_end_matches(".calibration.json").to_owned()
}

/// The simulated pad, the level, and all ports.
fn source_entries(names: &Names) -> Vec<choice::Entry<SourceChoice>> {
    let ports = names.ports.iter().cloned().map(SourceChoice::Serial);
    let built_in = [SourceChoice::Simulated, SourceChoice::Level].into_iter();
    built_in
        .chain(ports)
        .chain(std::iter::once(SourceChoice::Gamepad))
        .map(|source| {
            let request = PlayRequest {
                source,
                ..PlayRequest::default()
            };
            let label = request.source_label();
            (request.source, label)
        })
        .collect()
}

/// A drop-down list after its name, as wide as the room.
fn list<T: PartialEq>(
    ui: &mut Ui,
    name: &str,
    shown: &str,
    current: &T,
    entries: Vec<choice::Entry<T>>,
) -> Option<T> {
    let row = ui.horizontal(|ui| {
        let height = ui.spacing().interact_size.y;
        let left = egui::Layout::left_to_right(egui::Align::Center);
        let size = egui::Vec2::new(NAME_WIDTH, height);
        let label = ui.allocate_ui_with_layout(size, left, |ui| {
            ui.set_min_size(size);
            ui.label(name)
        });
        let label = label.inner;
        let combo = egui::ComboBox::from_id_salt(name)
            .width(ui.available_width())
            .truncate()
            .selected_text(shown);
        choice::list(ui, combo, Some(&label), current, entries)
    });
    row.inner
}

fn output_label(output: OutputChoice) -> &'static str {
    match output {
        OutputChoice::Nothing => "none (trial)",
        other => output_words(other),
    }
}

/// Force of the next press, and how to press.
fn simulated_pad(ui: &mut Ui, playing: &mut Playing) {
    let force = playing.fingers.force();
    ui.horizontal(|ui| {
        ui.label("Force");
        // The number stands beside the slider.
        ui.spacing_mut().slider_width = (ui.available_width() - 60.0).clamp(40.0, 150.0);
        let mut chosen = force;
        let response = ui.add(egui::Slider::new(&mut chosen, 0.1..=1.0).fixed_decimals(1));
        response.widget_info(|| egui::WidgetInfo::slider(true, chosen, "Force of the next press"));
        if (chosen - force).abs() > 1e-9 {
            playing.fingers.change_force((chosen - force) * 10.0);
            playing.send_fingers();
        }
    });
    ui.weak("Press with the mouse. Right click: pin a finger. Wheel: force. Esc: lift all. 1 to 9: press regions.");
    if playing.fingers.any_down() && ui.button("Lift all").clicked() {
        playing.fingers.lift_all();
        playing.send_fingers();
    }
}

/// The table of times. Nothing in it can be pressed, but it takes the focus: so the keyboard scrolls to it and a reader reads it.
fn timing(ui: &mut Ui, playing: &Playing) {
    const TITLE: &str = "Timing: median, 99th percentile";
    let rows = timing_rows(playing);
    let card = ui.scope(|ui| {
        theme::titled_card(ui, TITLE, |ui| {
            let grid = egui::Grid::new("times").num_columns(2);
            grid.spacing([14.0, 3.0]).show(ui, |ui| {
                for (name, value) in &rows {
                    ui.weak(*name);
                    ui.monospace(value);
                    ui.end_row();
                }
            });
        });
    });
    let id = ui.make_persistent_id("timing");
    let sense = egui::Sense::focusable_noninteractive();
    let response = ui.interact(card.response.rect, id, sense);
    response.widget_info(|| {
        let rows = rows.iter().map(|(name, value)| format!("{name} {value}"));
        let text = format!("{TITLE}: {}", rows.collect::<Vec<_>>().join(", "));
        egui::WidgetInfo::labeled(egui::Role::Label, true, text)
    });
}

/// Frame rate, latency of each stage, shortest press, lost frames.
fn timing_rows(playing: &Playing) -> Vec<(&'static str, String)> {
    let view = &playing.view;
    let mut rows = vec![("frame rate", format!("{:.0} frames/s", view.frames_per_s))];
    let stages = &view.stages;
    for (name, spread) in [
        ("queue", &stages.queue),
        ("find touches", &stages.touches),
        ("find keys", &stages.events),
        ("send keys", &stages.device),
        ("frame to key", &stages.frame_to_device),
    ] {
        if spread.count > 0 {
            let [median_ms, p99_ms] = [spread.median_us, spread.p99_us].map(|us| us / 1e3);
            rows.push((name, format!("{median_ms:.2}, {p99_ms:.1} ms")));
        }
    }
    if view.frames_per_s > 0.0 {
        let shortest_ms = SHORTEST_PRESS_FRAMES * 1e3 / view.frames_per_s;
        rows.push(("shortest press", format!("{shortest_ms:.0} ms")));
    }
    rows.push(("lost frames", view.lost_frames.to_string()));
    rows
}
