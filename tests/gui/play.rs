//! The view to play in.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::gui::Tab;
use gelpad::gui::desk::{From, To};
use gelpad::gui::still::touch;
use gelpad::runtime::Command;
use gelpad::types::{Action, Event};

use crate::desk::NO_START;
use crate::{SMALL, Stage, WIDE};

fn stage() -> Stage {
    Stage::of(Tab::Play, WIDE)
}

fn press(stage: &mut Stage, key: &str) {
    let output = key.parse().expect("an output");
    stage.see(|view| {
        view.held = vec![output];
        view.events.push_back(Event {
            t_ns: view.t_ns,
            action: Action::Press(output),
        });
        view.events_so_far += 1;
    });
}

#[test]
fn a_try_out_says_so_and_its_button_sends_to_the_game() {
    let mut stage = stage();
    assert!(stage.tells("nothing leaves this window"));
    stage.button("Send to my game");
    assert_eq!(stage.desk.last().map(|choice| choice.to), Some(To::Auto));
}

#[test]
fn a_start_that_fails_says_why_and_is_tried_again() {
    let mut stage = stage();
    stage.button("Send to my game");
    stage.steps(40);
    std::thread::sleep(std::time::Duration::from_millis(50));
    stage.steps(3);
    assert!(stage.tells(NO_START), "{:?}", stage.window);
    stage.button("Try again");
    std::thread::sleep(std::time::Duration::from_millis(50));
    let started = stage.desk.started.lock().expect("no panic").len();
    assert_eq!(started, 2);
}

#[test]
fn pause_and_zero_are_asked_of_the_game() {
    let mut stage = stage();
    stage.button("⏸ Pause");
    stage.button("Zero");
    let asked = &stage.app().playing.asked;
    assert!(
        matches!(asked[..], [Command::Pause, Command::Rezero]),
        "{asked:?}"
    );
}

#[test]
fn a_pause_is_told_and_ended_by_its_button() {
    let mut stage = stage();
    stage.see(|view| view.paused = true);
    assert!(stage.tells("Paused: everything is up"));
    stage.button("Go on");
    assert!(matches!(stage.app().playing.asked[..], [Command::Pause]));
}

#[test]
fn another_profile_is_chosen_by_its_name() {
    let mut stage = stage();
    stage.click(Role::ComboBox, "Profile");
    // It may lie beneath the list's edge: a screen reader clicks it there too.
    stage.window.get_by_label("racing").click_accesskit();
    stage.settle();
    let last = stage.desk.last().expect("a start");
    assert_eq!(last.profile, "racing");
    assert_eq!(last.to, To::Nothing, "the rest stays");
}

#[test]
fn a_port_is_chosen_as_source() {
    let desk = crate::desk::TestDesk::new();
    desk.ports
        .lock()
        .expect("no panic")
        .push("/dev/ttyACM7".to_owned());
    let mut stage = Stage::on(std::sync::Arc::new(desk), Tab::Play, WIDE);
    stage.click(Role::ComboBox, "From");
    stage.window.get_by_label("/dev/ttyACM7").click();
    stage.settle();
    let last = stage.desk.last().expect("a start");
    assert_eq!(last.from, From::Serial("/dev/ttyACM7".to_owned()));
}

#[test]
fn the_mouse_presses_the_pad_where_it_is_and_lifts() {
    let mut stage = stage();
    let rect = stage.canvas().rect();
    let at = rect.left_bottom() + egui::vec2(rect.width() * 0.8, -rect.height() * 0.3);
    stage.window.drag_at(at);
    stage.steps(2);
    let fingers = stage.app().playing.fingers.for_pad();
    let [finger] = fingers.as_slice() else {
        panic!("{fingers:?}");
    };
    let [x, y] = finger.centre_mm;
    assert!((x - 80.0).abs() < 0.6 && (y - 30.0).abs() < 0.6, "{x} {y}");
    stage.window.drop_at(at);
    stage.steps(2);
    assert!(!stage.app().playing.fingers.any());
}

#[test]
fn a_slide_takes_the_finger_along_and_stays_on_the_pad() {
    let mut stage = stage();
    let rect = stage.canvas().rect();
    stage.window.drag_at(rect.center());
    stage
        .window
        .hover_at(rect.right_top() + egui::vec2(90.0, -90.0));
    stage.steps(2);
    let [x, y] = stage.app().playing.fingers.for_pad()[0].centre_mm;
    assert_eq!((x, y), (100.0, 100.0));
}

#[test]
fn the_wheel_presses_harder() {
    let mut stage = stage();
    let rect = stage.canvas().rect();
    stage.window.drag_at(rect.center());
    stage.steps(2);
    let before = stage.app().playing.fingers.for_pad()[0].rise;
    stage.window.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: egui::vec2(0.0, 2.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: egui::Modifiers::NONE,
    });
    stage.steps(2);
    let after = stage.app().playing.fingers.for_pad()[0].rise;
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
    assert!(!stage.app().playing.fingers.any());
}

#[test]
fn two_fingers_of_a_touch_screen_are_two_on_the_pad() {
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
    let [x, y] = finger.centre_mm;
    assert!(
        (x - 81.0).abs() < 0.01 && (y - 52.0).abs() < 0.01,
        "{x} {y}"
    );
    stage.window.key_up(egui::Key::Num5);
    stage.steps(2);
    assert!(!stage.app().playing.fingers.any());
}

#[test]
fn touches_and_what_is_held_are_told_to_those_who_do_not_see() {
    let mut stage = stage();
    press(&mut stage, "key:f");
    stage.see(|view| view.touches = vec![touch(1, [80.0, 50.0], 0.6)]);
    assert!(stage.has("Pad: 1 touch, holding F"), "{:?}", stage.window);
    assert!(stage.has("key:f, held"));
    assert!(stage.has("key:d, up"));
}

#[test]
fn a_lost_electrode_is_named_and_its_button_shows_the_signals() {
    let mut stage = stage();
    stage.see(|view| view.lost_electrodes = vec![4]);
    assert!(stage.tells("Electrode 5 is loose"));
    stage.button("Show signals");
    assert_eq!(stage.app().tab, Tab::Signals);
}

#[test]
fn a_slow_board_says_what_it_may_miss() {
    let mut stage = stage();
    stage.see(|view| view.frames_per_s = 10.0);
    assert!(stage.tells("a press under 200 ms may be missed"));
}

#[test]
fn a_notice_goes_when_it_has_been_read() {
    let mut stage = stage();
    stage.app().playing.notice = Some("the profile is odd".to_owned());
    stage.steps(2);
    assert!(stage.tells("the profile is odd"));
    stage.button("All right");
    assert!(!stage.tells("the profile is odd"));
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
fn the_pad_is_pressed_in_the_smallest_window_too() {
    let mut stage = Stage::of(Tab::Play, SMALL);
    let rect = stage.canvas().rect();
    assert!(rect.width() > 200.0, "{rect:?}");
    stage.window.drag_at(rect.center());
    stage.steps(2);
    assert!(stage.app().playing.fingers.any());
}

#[test]
fn the_pad_window_opens_beside() {
    let mut stage = stage();
    stage.button("🗖 Pad window");
    assert!(stage.app().pad_window.open);
}
