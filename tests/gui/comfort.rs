//! The view for comfort, and what it keeps.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::gui::Tab;
use gelpad::gui::comfort::look::Look;

use crate::{Stage, WIDE};

fn stage() -> Stage {
    Stage::of(Tab::Feedback, WIDE)
}

fn kept(stage: &Stage) -> Look {
    let file = stage.desk.folder.path().join("window.toml");
    Look::read(&std::fs::read_to_string(file).expect("kept"))
}

#[test]
fn the_theme_is_chosen_and_kept() {
    let mut stage = stage();
    stage.click(Role::RadioButton, "Light");
    assert!(!stage.window.ctx.global_style().visuals.dark_mode);
    assert_eq!(kept(&stage).theme, egui::ThemePreference::Light);
    stage.click(Role::RadioButton, "Dark");
    assert!(stage.window.ctx.global_style().visuals.dark_mode);
}

#[test]
fn text_is_made_larger_and_kept() {
    let mut stage = stage();
    stage
        .window
        .get_by_role_and_label(Role::Slider, "Size of text")
        .set_value_accesskit(150.0);
    stage.steps(4);
    assert!((stage.window.ctx.zoom_factor() - 1.5).abs() < 1e-3);
    assert!((kept(&stage).text - 1.5).abs() < 1e-3);
}

#[test]
fn each_kind_of_feedback_is_switched_and_kept() {
    let mut stage = stage();
    for label in [
        "The window's edge lights up with every accepted press",
        "The terminal's bell rings",
        "Paused, another profile and a lost source are written large",
    ] {
        stage.click(Role::CheckBox, label);
    }
    let look = kept(&stage);
    assert!(look.flash && look.bell && !look.words);
}

#[test]
fn a_second_window_looks_as_the_first_was_left() {
    let mut stage = stage();
    stage.click(Role::RadioButton, "Light");
    let desk = std::sync::Arc::clone(&stage.desk);
    let again = Stage::on(desk, Tab::Play, WIDE);
    assert!(!again.window.ctx.global_style().visuals.dark_mode);
}

#[test]
fn what_holds_now_is_told() {
    let mut stage = stage();
    assert!(stage.tells("a touch counts after: off"));
    let mut profile = (*stage.app().playing.view.profile).clone();
    profile.settings.slow_keys_ns = 250_000_000;
    stage.see(|view| view.profile = std::sync::Arc::new(profile));
    assert!(stage.tells("a touch counts after: 250 ms"));
}
