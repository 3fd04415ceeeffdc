//! What the next window takes over from the last one, and how it goes on.

use std::sync::Arc;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::app::services::OutputChoice;
use gelpad::gui::Tab;

use crate::services::{TestBoard, TestServices};
use crate::{Stage, WIDE};

#[test]
fn the_chosen_output_and_the_open_pad_window_come_back_with_continue() {
    let services = TestServices::new();
    *services.board.lock().expect("no panic") = Some(TestBoard::Silent);
    let mut stage = Stage::with_services(Arc::new(services), Tab::Play, WIDE);
    stage.click(Role::ComboBox, "Output");
    stage.window.get_by_label("keyboard").click_accesskit();
    stage.wait_for_start();
    stage.button("Pad window");
    stage.steps(2);
    stage.app().close(None);

    let services = Arc::clone(&stage.services);
    let mut again = Stage::with_services(services, Tab::Play, WIDE);
    assert!(
        !again.app().pad_window.open,
        "not before the player goes on"
    );
    assert!(again.shows("Last output: keyboard"), "{:?}", again.window);
    again.button("Continue in my game");
    let last = again.services.last_request().expect("a start");
    assert_eq!(last.output, OutputChoice::Keyboard);
    assert!(again.app().pad_window.open);
}

#[test]
fn an_output_that_did_not_open_is_kept_too() {
    let mut stage = Stage::with_view(Tab::Play, WIDE);
    stage.click(Role::ComboBox, "Output");
    stage.window.get_by_label("gamepad").click_accesskit();
    stage.wait_for_start();
    stage.app().close(None);
    let services = Arc::clone(&stage.services);
    let again = Stage::with_services(services, Tab::Play, WIDE);
    assert!(again.shows("Last output: gamepad"), "{:?}", again.window);
}

#[test]
fn every_view_shows_the_way_on_with_the_last_game() {
    for tab in Tab::ALL {
        let mut stage = Stage::with_view(tab, WIDE);
        assert!(!stage.has_label("Continue in my game"), "no game before");
        stage.app().comfort.preferences.last_game.was_sent = true;
        stage.steps(2);
        stage.button("Continue in my game");
        let last = stage.services.last_request().expect("a start");
        assert_eq!(last.output, OutputChoice::Auto, "{tab:?}");
    }
}

#[test]
fn the_pad_window_is_not_offered_while_it_is_open() {
    let mut stage = Stage::with_view(Tab::Play, WIDE);
    stage.app().playing.request.output = OutputChoice::Auto;
    stage.steps(2);
    stage.button("Open the pad window");
    stage.steps(2);
    assert!(stage.app().pad_window.open);
    assert!(!stage.has_label("Open the pad window"));
    stage.button("Close the pad window");
    assert!(!stage.app().pad_window.open);
    assert!(
        stage.has_label("Open the pad window"),
        "no other way to press"
    );
}

#[test]
fn the_focus_goes_on_when_a_button_of_the_problem_line_goes() {
    let mut stage = Stage::with_view(Tab::Play, WIDE);
    assert!(stage.tab_to("Send to my game"));
    stage.key(egui::Key::Enter);
    stage.wait_for_start();
    let next = stage
        .window
        .get_by_role_and_label(Role::Button, "Try again");
    assert!(next.is_focused(), "{:?}", stage.window);
    // A line without a button keeps the focus too.
    stage.app().failed = None;
    stage.app().playing.request.output = OutputChoice::Auto;
    stage.app().pad_window.open = true;
    stage.steps(3);
    assert!(stage.window.get_by_label("No problems").is_focused());
}

#[test]
fn the_keyboard_reaches_and_shows_the_times() {
    let mut stage = Stage::with_view(Tab::Play, [800.0, 500.0]);
    let focused = |stage: &Stage| {
        let mut times = stage.window.query_all_by_label_contains("Timing: median");
        times.find(|node| node.is_focused()).map(|node| node.rect())
    };
    for _ in 0..60 {
        stage.key(egui::Key::Tab);
        if focused(&stage).is_some() {
            break;
        }
    }
    stage.steps(30);
    let rect = focused(&stage).expect("reached");
    assert!(rect.top() > 0.0 && rect.bottom() < 500.0, "{rect:?}");
}
