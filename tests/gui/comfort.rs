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
fn a_dragged_text_size_is_applied_on_release() {
    let mut stage = stage();
    let slider = stage
        .window
        .get_by_role_and_label(Role::Slider, "Text size");
    let start = slider.rect().left_center() + egui::vec2(20.0, 0.0);
    stage.window.drag_at(start);
    for step in 1..=8 {
        stage
            .window
            .hover_at(start + egui::vec2(10.0 * step as f32, 0.0));
        stage.steps(2);
        assert_eq!(stage.window.ctx.zoom_factor(), 1.0, "step {step}");
    }
    stage.window.drop_at(start + egui::vec2(80.0, 0.0));
    stage.steps(4);
    assert!(stage.window.ctx.zoom_factor() > 1.1);
}

#[test]
fn buttons_change_the_text_size_in_steps() {
    let mut stage = stage();
    stage.button("More: Text size");
    stage.steps(3);
    assert!((stage.window.ctx.zoom_factor() - 1.1).abs() < 1e-3);
    stage.button("Less: Text size");
    stage.button("Less: Text size");
    stage.steps(3);
    assert!((saved(&stage).text_scale - 0.9).abs() < 1e-3);
}

/// Presses a place for a time, and shakes.
fn hold(stage: &mut Stage, at: egui::Pos2, steps: usize) {
    stage.window.hover_at(at);
    stage.window.drag_at(at);
    for step in 0..steps {
        let side = if step % 2 == 0 { 8.0 } else { -8.0 };
        stage.window.hover_at(at + egui::vec2(side, 1.0));
        stage.steps(1);
    }
    stage.window.drop_at(at + egui::vec2(8.0, 1.0));
    stage.steps(4);
}

#[test]
fn a_slow_click_of_a_shaking_hand_counts() {
    let mut stage = stage();
    let at = stage.window.get_by_label("Practice").rect().center();
    // A step is a quarter of a second.
    hold(&mut stage, at, 10);
    assert_eq!(stage.app().tab, Tab::Practice);
}

#[test]
fn a_held_enter_key_clicks_once() {
    let mut stage = stage();
    let file = stage.services.folder.path().join("users/me.toml");
    assert!(stage.tab_to("More: Slow keys"));
    for pressed in [true, true, true, false] {
        stage.window.event(egui::Event::Key {
            key: egui::Key::Enter,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers: egui::Modifiers::NONE,
        });
        stage.steps(2);
    }
    stage.steps(4);
    let text = std::fs::read_to_string(&file).expect("saved");
    assert_eq!(text, "slow_keys_ms = 10\n");
}

#[test]
fn a_slow_click_is_one_step_and_a_held_button_repeats() {
    let mut stage = stage();
    let file = stage.services.folder.path().join("users/me.toml");
    let saved_ms = || {
        let text = std::fs::read_to_string(&file).expect("saved");
        let number = text.trim().trim_start_matches("slow_keys_ms = ");
        number.parse::<f64>().expect("a number")
    };
    let more = stage.button_rect("More: Slow keys").center();
    hold(&mut stage, more, 4);
    assert_eq!(saved_ms(), 10.0);
    hold(&mut stage, more, 16);
    let held_ms = saved_ms();
    assert!((100.0..=160.0).contains(&held_ms), "{held_ms} ms after 4 s");
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

#[test]
fn sticky_keys_are_switched_for_a_person() {
    let mut stage = Stage::with_view(Tab::Comfort, [1240.0, 1600.0]);
    stage.click(Role::CheckBox, "Sticky keys");
    let own = stage.services.folder.path().join("users/me.toml");
    let text = std::fs::read_to_string(own).expect("a file");
    assert_eq!(text, "sticky_keys = true\n");
}

#[test]
fn the_wheel_turns_a_slider_only_after_a_click() {
    let mut stage = Stage::with_view(Tab::Comfort, WIDE);
    let slider = stage
        .window
        .get_by_role_and_label(Role::Slider, "Slow keys");
    let at = slider.rect().left_center() + egui::vec2(2.0, 0.0);
    turn_the_wheel(&mut stage, at);
    let folder = stage.services.folder.path().join("users");
    assert!(!folder.exists(), "the page scrolls past it");
    stage.window.drag_at(at);
    stage.steps(2);
    stage.window.drop_at(at);
    stage.steps(2);
    turn_the_wheel(&mut stage, at);
    stage.wait_for_start();
    let text = std::fs::read_to_string(folder.join("me.toml")).expect("a file");
    assert!(
        text.starts_with("slow_keys_ms = 2"),
        "two steps of ten: {text}"
    );
}

fn turn_the_wheel(stage: &mut Stage, at: egui::Pos2) {
    stage.window.hover_at(at);
    stage.steps(2);
    stage.window.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: egui::vec2(0.0, 2.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Unknown,
        modifiers: egui::Modifiers::NONE,
    });
    stage.steps(3);
}

#[test]
fn a_press_without_a_flash_does_not_keep_repainting() {
    let mut stage = Stage::with_view(Tab::Play, WIDE);
    stage.steps(8);
    let delay_after_press = |stage: &mut Stage| {
        stage.update_view(|view| view.held.clear());
        stage.update_view(|view| {
            view.held = vec!["key:f".parse().expect("a key")];
            view.events_so_far += 1;
        });
        stage.window.output().viewport_output[&egui::ViewportId::ROOT].repaint_delay
    };
    let plain = delay_after_press(&mut stage);
    assert!(plain.as_millis() > 500, "{plain:?} until the next repaint");
    stage.app().comfort.preferences.flash = true;
    let flashing = delay_after_press(&mut stage);
    assert!((20..=40).contains(&flashing.as_millis()), "{flashing:?}");
}
