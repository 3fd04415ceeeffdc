//! The editor's text, its bindings with gesture and mode, and the buttons beside sliders.

use std::sync::Arc;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::gui::Tab;

use crate::edit::{replace_text, stage, wait_until};
use crate::services::TestServices;
use crate::{Stage, WIDE};

#[test]
fn a_file_that_is_no_toml_is_corrected_in_the_window() {
    let services = Arc::new(TestServices::new());
    let path = services.copy_profile("super-mario");
    let sound = std::fs::read_to_string(&path).expect("a file");
    std::fs::write(&path, sound.replacen("[[region]]", "[[region]", 1)).expect("written");
    let mut stage = Stage::with_services(services, Tab::Edit, WIDE);
    stage.app().playing.request.profile = path.display().to_string();
    wait_until(&mut stage, |stage| stage.has_label("Text of the profile"));
    let line = sound
        .lines()
        .position(|line| line == "[[region]]")
        .expect("a region")
        + 1;
    assert!(stage.shows(&format!("line {line}:")), "{:?}", stage.window);
    replace_text(&mut stage, "Text of the profile", &sound);
    stage.button("Save");
    assert_eq!(std::fs::read_to_string(&path).expect("a file"), sound);
}

#[test]
fn a_text_with_a_mistake_is_marked_and_not_saved() {
    let (mut stage, path) = stage();
    let before = std::fs::read_to_string(&path).expect("a file");
    stage.button("Edit as text");
    replace_text(
        &mut stage,
        "Text of the profile",
        "name = \"p\"\n[[region]\n",
    );
    assert!(stage.shows("error: line 2"), "{:?}", stage.window);
    stage.app().edit.select_region("jump");
    stage
        .window
        .key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::S);
    stage.steps(2);
    assert_eq!(std::fs::read_to_string(&path).expect("a file"), before);
}

#[test]
fn gesture_and_mode_are_chosen_and_their_diagram_is_shown() {
    let (mut stage, path) = stage();
    stage.app().edit.select_region("jump");
    stage.steps(3);
    stage
        .window
        .get_by_label_contains("press to $a")
        .click_accesskit();
    stage.steps(20);
    for (list, entry, diagram) in [
        ("gesture", "double-tap", "double-tap  ____"),
        ("mode", "turbo", "turbo  "),
    ] {
        let list = stage.window.get_by_role_and_label(Role::ComboBox, list);
        list.click_accesskit();
        stage.steps(3);
        stage.window.get_by_label(entry).click();
        stage.steps(3);
        assert!(stage.shows(diagram), "{entry}: {:?}", stage.window);
    }
    let turbo = stage
        .window
        .get_by_role_and_label(Role::SpinButton, "turbo_hz");
    turbo.set_value_accesskit(10.0);
    stage.steps(3);
    stage.button("Save");
    let text = std::fs::read_to_string(&path).expect("a file");
    for line in [
        "gesture = \"double-tap\"",
        "mode = \"turbo\"",
        "turbo_hz = 10",
    ] {
        assert!(text.contains(line), "{text}");
    }
}

#[test]
fn a_button_beside_a_slider_moves_it_by_ten_steps() {
    let (mut stage, path) = stage();
    stage.button("More: Bounce keys");
    stage.button("More: Bounce keys");
    stage.button("Less: Bounce keys");
    stage.button("Save");
    let text = std::fs::read_to_string(&path).expect("a file");
    let profile = gelpad::profile::Profile::from_toml("p", &text).expect("valid");
    assert_eq!(profile.settings.bounce_keys_ns, 10_000_000);
}
