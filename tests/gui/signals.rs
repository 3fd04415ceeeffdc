//! The signals view.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::gui::Tab;
use gelpad::gui::signals::Quantity;
use gelpad::gui::still::touch;

use crate::{Stage, WIDE};

fn measured() -> Stage {
    let mut stage = Stage::with_view(Tab::Signals, WIDE);
    stage.update_view(|view| {
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
fn without_measurements_the_view_says_so() {
    let stage = Stage::with_view(Tab::Signals, WIDE);
    assert!(stage.shows("Nothing has been measured yet"));
}

#[test]
fn each_quantity_is_chosen_by_name_and_explained() {
    let mut stage = measured();
    for (name, quantity, text) in [
        ("Changes", Quantity::Changes, "explained by the touches"),
        ("Noise", Quantity::Noise, "Signal-to-noise"),
        ("Reciprocity", Quantity::Reciprocity, "swapped"),
        ("Drift", Quantity::Drift, "since the start"),
        ("Residual", Quantity::Residual, "do not explain"),
        ("Voltages", Quantity::Voltages, "untouched pad"),
    ] {
        stage.click(Role::Button, name);
        assert_eq!(stage.app().signals.quantity, quantity);
        assert!(stage.shows(text), "{name}");
    }
}

#[test]
fn the_signal_quality_is_shown() {
    let mut stage = measured();
    for words in ["60 dB", "no touch found", "208"] {
        assert!(stage.shows(words), "{words}: {:?}", stage.window);
    }
    stage.update_view(|view| view.touches = vec![touch(1, [50.0, 50.0], 0.5)]);
    assert!(stage.shows("60 % of the change"), "{:?}", stage.window);
}

#[test]
fn poor_channels_and_lost_electrodes_are_listed() {
    let mut stage = measured();
    stage.update_view(|view| view.lost_electrodes = vec![2, 6]);
    assert!(stage.has_label("17, 40"));
    assert!(stage.has_label("3, 7"));
}

#[test]
fn drift_is_relative_to_the_first_reference() {
    let mut stage = measured();
    stage.update_view(|view| view.signals.reference[5] = 1.02);
    assert!(stage.shows("2.00 %"), "{:?}", stage.window);
    let _ = stage.window.get_by_label("largest drift");
}
