//! Personal settings from guided presses: step 5 of the setup.

use std::sync::Arc;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::gui::Tab;
use gelpad::gui::setup::Step;
use gelpad::gui::still::touch;
use gelpad::gui::theme::palette;

use crate::services::{Found, TestServices};
use crate::set_up::{at, make_presses, make_the_presses, wait_for_recommendation};
use crate::{Stage, WIDE};

/// The step *Personal settings* after all presses, with settings that score as given.
fn after_the_presses(found: Found) -> Stage {
    let services = TestServices::new();
    *services.found.lock().expect("no panic") = found;
    let mut stage = Stage::with_services(Arc::new(services), Tab::SetUp, WIDE);
    stage.app().set_up.step = Step::Recommend;
    stage.steps(3);
    stage.button("Start");
    make_the_presses(&mut stage);
    stage
}

#[test]
fn settings_that_make_presses_worse_are_a_warning_and_not_the_way_on() {
    let mut stage = after_the_presses(Found::Worse);
    assert!(
        stage.shows("warning: 100 % of your presses were right before, 0 % with"),
        "{:?}",
        stage.window
    );
    assert!(!stage.has_label("Save and use"), "only anyway");
    assert!(stage.has_label("Save and use anyway"));
    stage.button("Keep what you have");
    assert!(stage.shows("your settings are as they were"));
    assert!(stage.services.last_request().is_none(), "nothing is played");
    assert!(!stage.services.folder.path().join("users").exists());
}

#[test]
fn settings_with_fewer_unintended_presses_are_not_called_worse() {
    let stage = after_the_presses(Found::FewerUnintended);
    let words = "100 % of your presses were right before, 83 % with the new settings; unintended: 6 before, 0 with the new ones";
    assert!(stage.shows(words), "{:?}", stage.window);
    assert!(stage.has_label("Save and use"));
    assert!(!stage.has_label("Keep what you have"));
}

#[test]
fn settings_that_help_nothing_are_not_the_way_on() {
    let mut stage = after_the_presses(Found::NoHelp);
    assert!(stage.shows("would not help"), "{:?}", stage.window);
    let on_accent = palette(true).on_accent;
    assert_ne!(stage.colour_of("Save and use"), Some(on_accent));
    stage.button("Keep what you have");
    assert!(stage.shows("your settings are as they were"));
}

#[test]
fn the_orange_button_is_the_way_on() {
    let on_accent = palette(true).on_accent;
    let mut stage = at(Step::Recommend);
    assert_eq!(stage.colour_of("Start"), Some(on_accent));
    assert_ne!(stage.colour_of("Next ▶"), Some(on_accent));
    stage.button("Start");
    make_the_presses(&mut stage);
    assert_eq!(stage.colour_of("Save and use"), Some(on_accent));
    assert_ne!(stage.colour_of("Next ▶"), Some(on_accent));
    stage.button("Save and use");
    assert_eq!(stage.colour_of("Next ▶"), Some(on_accent));
    assert_eq!(stage.colour_of("✔ saved: "), Some(palette(true).good));
}

#[test]
fn settings_of_the_same_name_are_mentioned_before_saving() {
    let mut stage = at(Step::Recommend);
    let users = stage.services.folder.path().join("users");
    std::fs::create_dir_all(&users).expect("a folder");
    std::fs::write(users.join("me.toml"), "").expect("written");
    stage.button("Start");
    make_the_presses(&mut stage);
    assert!(stage.shows("these are saved as me-2"), "{:?}", stage.window);
}

#[test]
fn escape_and_another_view_stop_the_presses() {
    let mut stage = at(Step::Recommend);
    stage.button("Start");
    assert!(stage.shows("0 of 24"), "{:?}", stage.window);
    stage.key(egui::Key::Escape);
    assert!(!stage.shows("0 of 24"), "{:?}", stage.window);
    stage.button("Start");
    stage.key(egui::Key::F1);
    stage.key(egui::Key::F4);
    assert!(!stage.shows("0 of 24"), "another view");
    stage.button("Start");
    stage.button("Back");
    stage.button("Next");
    assert!(!stage.shows("0 of 24"), "another step");
}

#[test]
fn escape_lifts_pinned_fingers_and_leaves_the_field_before_it_stops_the_presses() {
    let mut stage = at(Step::Recommend);
    stage.button("Start");
    assert!(stage.app().playing.fingers.toggle_pin([20.0, 20.0]));
    stage.steps(2);
    stage.key(egui::Key::Escape);
    assert!(!stage.app().playing.fingers.any_down());
    assert!(stage.shows("0 of 24"), "{:?}", stage.window);
    stage
        .window
        .get_by_role_and_label(Role::TextInput, "Your name")
        .focus();
    stage.steps(2);
    stage.key(egui::Key::Escape);
    assert!(stage.shows("0 of 24"), "{:?}", stage.window);
    stage.key(egui::Key::Escape);
    assert!(!stage.shows("0 of 24"), "{:?}", stage.window);
}

#[test]
fn twelve_presses_may_be_enough() {
    let mut stage = at(Step::Recommend);
    stage.button("Start");
    make_presses(&mut stage, 11);
    assert!(!stage.has_label("That is enough"), "too few");
    make_presses(&mut stage, 1);
    stage.button("That is enough");
    wait_for_recommendation(&mut stage);
    assert!(!stage.has_label("Stop") && !stage.shows("stopped"));
    assert!(stage.shows("of your presses"), "{:?}", stage.window);
}

#[test]
fn a_press_is_counted_when_it_lifts() {
    let mut stage = at(Step::Recommend);
    stage.button("Start");
    for _ in 0..5 {
        stage.update_view_once(|view| view.touches = vec![touch(1, [80.0, 50.0], 0.5)]);
    }
    assert!(stage.shows("0 of 24"));
    stage.update_view(|view| view.touches.clear());
    assert!(stage.shows("press 1 of 24 seen"), "{:?}", stage.window);
    assert!(stage.has_label("1 of 24") || stage.shows("1 of 24"));
}
