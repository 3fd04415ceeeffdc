//! The play view.

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use gelpad::app::services::{OutputChoice, SourceChoice};
use gelpad::gui::Tab;
use gelpad::gui::still::touch;
use gelpad::runtime::PlayCommand;
use gelpad::types::{Action, Event};

use crate::services::NO_START;
use crate::{SMALL, Stage, WIDE};

fn stage() -> Stage {
    Stage::with_view(Tab::Play, WIDE)
}

fn press(stage: &mut Stage, key: &str) {
    let output = key.parse().expect("an output");
    stage.update_view(|view| {
        view.held = vec![output];
        view.events.push_back(Event {
            t_ns: view.t_ns,
            action: Action::Press(output),
        });
        view.events_so_far += 1;
    });
}

#[test]
fn a_trial_is_announced_and_its_button_sends_to_the_game() {
    let mut stage = stage();
    assert!(stage.shows("Trial: no keys are sent"));
    stage.button("Send to my game");
    assert_eq!(
        stage.services.last_request().map(|request| request.output),
        Some(OutputChoice::Auto)
    );
}

#[test]
fn a_failed_start_says_why_and_can_be_retried() {
    let mut stage = stage();
    stage.button("Send to my game");
    stage.steps(40);
    std::thread::sleep(std::time::Duration::from_millis(50));
    stage.steps(3);
    assert!(stage.shows(NO_START), "{:?}", stage.window);
    stage.button("Try again");
    std::thread::sleep(std::time::Duration::from_millis(50));
    let started = stage.services.started.lock().expect("no panic").len();
    assert_eq!(started, 2);
}

#[test]
fn pause_and_zero_are_sent_to_the_game() {
    let mut stage = stage();
    stage.button("Pause");
    stage.button("Zero");
    let asked = &stage.app().playing.unsent_commands;
    assert!(
        matches!(asked[..], [PlayCommand::Pause, PlayCommand::Rezero]),
        "{asked:?}"
    );
}

#[test]
fn a_pause_is_announced_and_ended_by_its_button() {
    let mut stage = stage();
    stage.update_view(|view| view.paused = true);
    assert!(stage.shows("Paused: all keys are released"));
    // One beside the announcement, one in its usual place.
    let buttons = stage
        .window
        .get_all_by_role_and_label(Role::Button, "Resume");
    let buttons: Vec<_> = buttons.collect();
    assert_eq!(buttons.len(), 2);
    buttons[0].click();
    drop(buttons);
    stage.steps(1);
    assert!(matches!(
        stage.app().playing.unsent_commands[..],
        [PlayCommand::Pause]
    ));
}

#[test]
fn a_profile_is_chosen_by_name() {
    let mut stage = stage();
    stage.click(Role::ComboBox, "Profile");
    // It may be below the visible part of the list; accessibility clicks work there too.
    stage.window.get_by_label("racing").click_accesskit();
    stage.wait_for_start();
    let last = stage.services.last_request().expect("a start");
    assert_eq!(last.profile, "racing");
    assert_eq!(last.output, OutputChoice::Nothing, "nothing else changes");
}

#[test]
fn a_port_is_chosen_as_source() {
    let services = crate::services::TestServices::new();
    services
        .ports
        .lock()
        .expect("no panic")
        .push("/dev/ttyACM7".to_owned());
    let mut stage = Stage::with_services(std::sync::Arc::new(services), Tab::Play, WIDE);
    stage.click(Role::ComboBox, "Source");
    stage.window.get_by_label("/dev/ttyACM7").click();
    stage.wait_for_start();
    let last = stage.services.last_request().expect("a start");
    assert_eq!(last.source, SourceChoice::Serial("/dev/ttyACM7".to_owned()));
}

#[test]
fn the_mouse_presses_the_pad_and_lifts() {
    let mut stage = stage();
    let rect = stage.canvas().rect();
    let at = rect.left_bottom() + egui::vec2(rect.width() * 0.8, -rect.height() * 0.3);
    stage.window.drag_at(at);
    stage.steps(2);
    let fingers = stage.app().playing.fingers.for_pad();
    let [finger] = fingers.as_slice() else {
        panic!("{fingers:?}");
    };
    let [x, y] = finger.press.centre_mm;
    assert!((x - 80.0).abs() < 0.6 && (y - 30.0).abs() < 0.6, "{x} {y}");
    stage.window.drop_at(at);
    stage.steps(2);
    assert!(!stage.app().playing.fingers.any_down());
}

#[test]
fn a_dragged_finger_stays_on_the_pad() {
    let mut stage = stage();
    let rect = stage.canvas().rect();
    stage.window.drag_at(rect.center());
    stage
        .window
        .hover_at(rect.right_top() + egui::vec2(90.0, -90.0));
    stage.steps(2);
    let [x, y] = stage.app().playing.fingers.for_pad()[0].press.centre_mm;
    assert_eq!((x, y), (100.0, 100.0));
}

#[test]
fn the_wheel_changes_the_force() {
    let mut stage = stage();
    let rect = stage.canvas().rect();
    stage.window.drag_at(rect.center());
    stage.steps(2);
    let before = stage.app().playing.fingers.for_pad()[0].press.rise;
    stage.window.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: egui::vec2(0.0, 2.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: egui::Modifiers::NONE,
    });
    stage.steps(2);
    let after = stage.app().playing.fingers.for_pad()[0].press.rise;
    assert!((after - before - 0.32).abs() < 1e-9, "{before} {after}");
}

#[test]
fn space_pins_a_finger_and_escape_lifts_all() {
    let mut stage = stage();
    let rect = stage.canvas().rect();
    stage.window.drag_at(rect.center());
    stage.steps(2);
    stage.key(egui::Key::Space);
    stage.window.drop_at(rect.center());
    stage.steps(2);
    assert_eq!(stage.app().playing.fingers.pinned_mm().count(), 1);
    stage.key(egui::Key::Escape);
    assert!(!stage.app().playing.fingers.any_down());
}

#[test]
fn a_touch_screen_presses_with_two_fingers() {
    let mut stage = stage();
    let rect = stage.canvas().rect();
    for (id, share) in [(1, 0.25), (2, 0.75)] {
        stage.window.event(egui::Event::Touch {
            device_id: egui::TouchDeviceId(1),
            id: egui::TouchId(id),
            phase: egui::TouchPhase::Start,
            pos: rect.left_center() + egui::vec2(rect.width() * share, 0.0),
            force: None,
        });
    }
    stage.steps(3);
    assert_eq!(stage.app().playing.fingers.for_pad().len(), 2);
}

#[test]
fn digits_press_regions_while_the_pad_has_the_focus() {
    let mut stage = stage();
    assert!(stage.tab_to("Pad: no touch"));
    stage.window.key_down(egui::Key::Num5);
    stage.steps(2);
    let finger = stage.app().playing.fingers.for_pad()[0];
    // Region 5 of super-mario is `jump`; its middle is at 81, 52 mm.
    let [x, y] = finger.press.centre_mm;
    assert!(
        (x - 81.0).abs() < 0.01 && (y - 52.0).abs() < 0.01,
        "{x} {y}"
    );
    stage.window.key_up(egui::Key::Num5);
    stage.steps(2);
    assert!(!stage.app().playing.fingers.any_down());
}

#[test]
fn screen_readers_get_touches_and_held_keys() {
    let mut stage = stage();
    press(&mut stage, "key:f");
    stage.update_view(|view| view.touches = vec![touch(1, [80.0, 50.0], 0.6)]);
    assert!(
        stage.has_label("Pad: 1 touch, holding F"),
        "{:?}",
        stage.window
    );
    assert!(stage.has_label("key:f, held"));
    assert!(stage.has_label("key:d, up"));
}

#[test]
fn a_lost_electrode_is_named_and_its_button_shows_the_signals() {
    let mut stage = stage();
    stage.update_view(|view| view.lost_electrodes = vec![4]);
    assert!(stage.shows("Electrode 5 is loose"));
    stage.button("Show signals");
    assert_eq!(stage.app().tab, Tab::Signals);
}

#[test]
fn a_slow_board_announces_the_shortest_press() {
    let mut stage = stage();
    stage.update_view(|view| view.frames_per_s = 10.0);
    assert!(stage.shows("presses shorter than 200 ms may be missed"));
}

#[test]
fn a_notice_is_dismissed_by_its_button() {
    let mut stage = stage();
    stage.app().playing.notice = Some("a warning".to_owned());
    stage.steps(2);
    assert!(stage.shows("a warning"));
    stage.button("OK");
    assert!(!stage.shows("a warning"));
}

#[test]
fn the_force_of_the_next_press_is_set_by_its_slider() {
    let mut stage = stage();
    stage
        .window
        .get_by_role_and_label(Role::Slider, "Force of the next press")
        .set_value_accesskit(0.9);
    stage.steps(3);
    assert!((stage.app().playing.fingers.force() - 0.9).abs() < 0.05);
}

#[test]
fn the_pad_can_be_pressed_in_a_small_window() {
    let mut stage = Stage::with_view(Tab::Play, SMALL);
    let rect = stage.canvas().rect();
    assert!(rect.width() > 200.0, "{rect:?}");
    stage.window.drag_at(rect.center());
    stage.steps(2);
    assert!(stage.app().playing.fingers.any_down());
}

#[test]
fn the_pad_window_opens() {
    let mut stage = stage();
    stage.button("Pad window");
    assert!(stage.app().pad_window.open);
}

#[test]
fn a_list_works_with_the_keyboard_alone() {
    let mut stage = stage();
    assert!(stage.tab_to("Profile"));
    stage.key(egui::Key::Enter);
    assert!(stage.tab_to("racing"));
    stage.key(egui::Key::Enter);
    stage.wait_for_start();
    let last = stage.services.last_request().expect("a start");
    assert_eq!(last.profile, "racing");
    assert!(!stage.has_label("large-buttons"), "the list is closed");
    let list = stage
        .window
        .get_by_role_and_label(Role::ComboBox, "Profile");
    assert!(list.is_focused(), "Tab goes on from the list");
}

#[test]
fn a_silent_board_is_reported_and_a_game_that_is_replaced_is_not_disconnected() {
    let services = crate::services::TestServices::new();
    *services.board.lock().expect("no panic") = Some(crate::services::TestBoard::Silent);
    let mut stage = Stage::with_services(std::sync::Arc::new(services), Tab::Play, WIDE);
    stage.button("Send to my game");
    assert!(stage.app().playing.is_running());
    assert!(stage.shows("Taking the first frames"), "{:?}", stage.window);
    stage.steps(8);
    assert!(stage.shows("No data from"), "{:?}", stage.window);
    assert!(stage.shows("no data"), "the status line too");
    stage.app().tab = Tab::Signals;
    stage.steps(2);
    assert!(stage.shows("not yet known"));
    stage.app().playing.stop();
    assert_eq!(stage.app().playing.ended, None, "stopped by the player");
}

#[test]
fn a_gamepad_that_rests_is_neither_silent_nor_awaited() {
    let services = crate::services::TestServices::new();
    *services.board.lock().expect("no panic") = Some(crate::services::TestBoard::Silent);
    let mut stage = Stage::with_services(std::sync::Arc::new(services), Tab::Play, WIDE);
    let mut request = stage.app().last_game();
    request.source = gelpad::app::services::SourceChoice::Gamepad;
    stage.app().play(request);
    stage.wait_for_start();
    stage.steps(8);
    assert!(stage.app().playing.is_running());
    assert!(stage.shows("playing"), "{:?}", stage.window);
    assert!(!stage.shows("No data from"));
    assert!(!stage.shows("Taking the first frames"));
}

#[test]
fn a_press_before_practice_opens_does_not_jump_there() {
    let mut stage = stage();
    press(&mut stage, "key:f");
    stage.key(egui::Key::F2);
    stage.steps(8);
    let practice = &stage.app().practice.practice;
    assert_eq!(practice.jumps().count(), 0);
    assert_eq!(practice.stage(), gelpad::gui::practice::RunStage::Ready);
}

#[test]
fn regions_are_children_of_the_pad_with_their_outputs_and_state() {
    let mut stage = stage();
    press(&mut stage, "key:f");
    let canvas = stage.canvas();
    let labels: Vec<String> = canvas
        .children_recursive()
        .filter_map(|child| child.value())
        .collect();
    assert!(
        labels.contains(&"jump, presses key f, held".to_owned()),
        "{labels:?}"
    );
    assert!(labels.contains(&"run, presses key d, up".to_owned()));
}
