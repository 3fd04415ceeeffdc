//! The view of the signals.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::gui::Tab;
use gelpad::gui::signals::Kind;

use crate::{Stage, WIDE};

fn measured() -> Stage {
    let mut stage = Stage::of(Tab::Signals, WIDE);
    stage.see(|view| {
        view.signals.volts = vec![1.0; 208];
        view.signals.reference = vec![1.0; 208];
        view.signals.changes = vec![0.01; 208];
        view.signals.explained = vec![0.004; 208];
        view.signals.noise = vec![1e-3; 208];
        view.signals.noise[17] = f32::INFINITY;
        view.signals.noise[40] = 0.05;
    });
    stage
}

#[test]
fn before_anything_is_measured_it_says_so() {
    let stage = Stage::of(Tab::Signals, WIDE);
    assert!(stage.tells("Nothing has been measured yet"));
}

#[test]
fn each_figure_is_chosen_by_its_name_and_explained() {
    let mut stage = measured();
    for (name, kind, words) in [
        ("Changes", Kind::Changes, "what touches explain"),
        ("Noise", Kind::Noise, "signal-to-noise"),
        ("Reciprocity", Kind::Reciprocity, "swapped"),
        ("Drift", Kind::Drift, "since the start"),
        ("Residual", Kind::Residual, "do not explain"),
        ("Voltages", Kind::Voltages, "untouched pad"),
    ] {
        stage.click(Role::Button, name);
        assert_eq!(stage.app().signals.kind, kind);
        assert!(stage.tells(words), "{name}");
    }
}

#[test]
fn the_health_of_the_readings_is_told_in_figures() {
    let stage = measured();
    for words in ["60 dB", "60 %", "208"] {
        assert!(stage.tells(words), "{words}: {:?}", stage.window);
    }
}

#[test]
fn bad_channels_and_lost_electrodes_are_named() {
    let mut stage = measured();
    stage.see(|view| view.lost_electrodes = vec![2, 6]);
    assert!(stage.has("17, 40"));
    assert!(stage.has("3, 7"));
}

#[test]
fn drift_is_counted_from_the_first_reading() {
    let mut stage = measured();
    stage.see(|view| view.signals.reference[5] = 1.02);
    assert!(stage.tells("2.00 %"), "{:?}", stage.window);
    let _ = stage.window.get_by_label("drift, at most");
}
