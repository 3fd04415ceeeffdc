//! The comfort view and its saved preferences.

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use gelpad::gui::Tab;
use gelpad::gui::comfort::preferences::Preferences;

use crate::{Stage, WIDE};

fn stage() -> Stage {
    Stage::with_view(Tab::Comfort, WIDE)
}

fn saved(stage: &Stage) -> Preferences {
    let file = stage.services.folder.path().join("window.toml");
    Preferences::read(&std::fs::read_to_string(file).expect("saved"))
}

#[test]
fn the_theme_is_chosen_and_saved() {
    let mut stage = stage();
    stage.click(Role::RadioButton, "Light");
    assert!(!stage.window.ctx.global_style().visuals.dark_mode);
    assert_eq!(saved(&stage).theme, egui::ThemePreference::Light);
    stage.click(Role::RadioButton, "Dark");
    assert!(stage.window.ctx.global_style().visuals.dark_mode);
}

#[test]
fn the_text_size_is_chosen_and_saved() {
    let mut stage = stage();
    stage
        .window
        .get_by_role_and_label(Role::Slider, "Text size")
        .set_value_accesskit(150.0);
    stage.steps(4);
    assert!((stage.window.ctx.zoom_factor() - 1.5).abs() < 1e-3);
    assert!((saved(&stage).text_scale - 1.5).abs() < 1e-3);
}

#[test]
fn each_kind_of_feedback_is_switched_and_saved() {
    let mut stage = stage();
    for label in [
        "Flash the window edge on every accepted press",
        "Ring the terminal bell",
        "Show pause, profile change and disconnection in large letters",
    ] {
        stage.click(Role::CheckBox, label);
    }
    let preferences = saved(&stage);
    assert!(preferences.flash && preferences.bell && !preferences.large_alerts);
}

#[test]
fn the_next_window_loads_the_preferences() {
    let mut stage = stage();
    stage.click(Role::RadioButton, "Light");
    let services = std::sync::Arc::clone(&stage.services);
    let again = Stage::with_services(services, Tab::Play, WIDE);
    assert!(!again.window.ctx.global_style().visuals.dark_mode);
}

#[test]
fn the_times_of_the_profile_are_shown() {
    let mut stage = stage();
    let slow_keys_ms = |stage: &Stage| {
        let slider = stage
            .window
            .get_by_role_and_label(Role::Slider, "Slow keys");
        slider.accesskit_node().numeric_value()
    };
    assert_eq!(slow_keys_ms(&stage), Some(0.0));
    let mut profile = (*stage.app().playing.view.profile).clone();
    profile.settings.slow_keys_ns = 250_000_000;
    stage.update_view(|view| view.profile = std::sync::Arc::new(profile));
    assert_eq!(slow_keys_ms(&stage), Some(250.0));
}

#[test]
fn a_persons_settings_are_changed_here_and_a_shipped_person_is_copied() {
    let mut stage = stage();
    let set = |stage: &mut Stage, ms: f64| {
        stage
            .window
            .get_by_role_and_label(Role::Slider, "Slow keys")
            .set_value_accesskit(ms);
        stage.wait_for_start();
    };
    set(&mut stage, 120.0);
    let own = stage.services.folder.path().join("users/me.toml");
    let text = |path: &std::path::Path| std::fs::read_to_string(path).expect("a file");
    assert_eq!(text(&own), "slow_keys_ms = 120\n");
    let played = |stage: &Stage| stage.services.last_request().expect("a start").user;
    assert_eq!(played(&stage), Some(own.display().to_string()));

    stage.app().playing.request.user = Some("tremor".to_owned());
    stage.steps(2);
    set(&mut stage, 300.0);
    let copy = stage.services.folder.path().join("users/my-tremor.toml");
    assert!(text(&copy).contains("slow_keys_ms = 300") && text(&copy).contains("tremor_mm = 6"));
    assert_eq!(played(&stage), Some(copy.display().to_string()));
    assert_eq!(text(&own), "slow_keys_ms = 120\n", "another person's file");
}
