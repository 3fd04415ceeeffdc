//! The wizard from port to play.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::gui::Tab;
use gelpad::gui::desk::{From, To};
use gelpad::gui::setup::Step;
use gelpad::gui::still::touch;
use gelpad::runtime::Command;

use crate::{Stage, WIDE};

fn stage() -> Stage {
    Stage::of(Tab::SetUp, WIDE)
}

fn at(step: Step) -> Stage {
    let mut stage = stage();
    stage.app().set_up.step = step;
    stage.steps(3);
    stage
}

#[test]
fn the_keyboard_alone_walks_through_all_of_it_and_plays() {
    let mut stage = stage();
    for (nth, step) in Step::ALL.into_iter().enumerate() {
        assert_eq!(stage.app().set_up.step, step);
        let last = nth + 1 == Step::ALL.len();
        // The rail has a `Play` too: the wizard's is a button.
        let found = (0..150).any(|_| {
            stage.key(egui::Key::Tab);
            let label = if last { "Play" } else { "Next ▶" };
            stage
                .window
                .query_by_role_and_label(Role::Button, label)
                .is_some_and(|node| node.is_focused())
        });
        assert!(found, "{step:?}: no way on by keyboard");
        stage.key(egui::Key::Enter);
    }
    assert_eq!(stage.app().tab, Tab::Play);
}

#[test]
fn back_and_next_turn_its_pages() {
    let mut stage = stage();
    stage.button("Next ▶");
    assert_eq!(stage.app().set_up.step, Step::WayRound);
    stage.button("◀ Back");
    assert_eq!(stage.app().set_up.step, Step::Board);
}

#[test]
fn each_step_is_gone_to_by_its_name() {
    let mut stage = stage();
    for (nth, step) in Step::ALL.into_iter().enumerate().skip(1) {
        stage.button(&format!("{} {}", nth + 1, step.name()));
        assert_eq!(stage.app().set_up.step, step);
    }
}

#[test]
fn without_a_port_it_says_what_to_look_at_and_finds_one_that_is_plugged_in() {
    let mut stage = stage();
    assert!(stage.tells("No serial port is there"));
    stage
        .desk
        .ports
        .lock()
        .expect("no panic")
        .push("/dev/ttyUSB3".to_owned());
    stage.button("⟲ Look again");
    stage.click(Role::RadioButton, "/dev/ttyUSB3");
    let last = stage.desk.last().expect("a start");
    assert_eq!(last.from, From::Serial("/dev/ttyUSB3".to_owned()));
}

#[test]
fn another_pad_is_chosen() {
    let mut stage = stage();
    stage.click(Role::ComboBox, "Pad");
    stage.window.get_by_label("round-tank").click();
    stage.settle();
    assert_eq!(stage.desk.last().expect("a start").pad, "round-tank");
}

#[test]
fn the_board_s_figures_are_told() {
    let mut stage = stage();
    stage.see(|view| {
        view.frames_per_s = 98.0;
        view.signals.volts = vec![1.0; 208];
        view.signals.noise = vec![1e-3; 208];
    });
    for words in ["98 frames/s", "208", "60 dB"] {
        assert!(stage.tells(words), "{words}");
    }
}

#[test]
fn zero_is_asked_for_and_a_hand_on_the_pad_is_told() {
    let mut stage = at(Step::Zero);
    assert!(stage.tells("nothing touches it"));
    stage.button("Zero now");
    assert!(matches!(stage.app().playing.asked[..], [Command::Rezero]));
    stage.see(|view| view.touches = vec![touch(1, [50.0, 50.0], 0.5)]);
    assert!(stage.tells("is the pad free?"));
}

#[test]
fn presses_at_the_shown_places_become_a_calibration_that_is_used() {
    let mut stage = at(Step::Calibrate);
    stage
        .window
        .get_by_role_and_label(Role::Slider, "places")
        .set_value_accesskit(12.0);
    stage.steps(2);
    stage.button("Begin");
    for press in 0..12 {
        assert!(stage.tells(&format!("{press} of 12")), "press {press}");
        for _ in 0..10 {
            stage.see(|view| {
                view.touches = vec![touch(press, [50.0, 50.0], 0.5)];
                view.signals.changes = vec![0.01; 208];
            });
        }
        stage.see(|view| view.touches.clear());
    }
    assert_eq!(*stage.desk.calibrated.lock().expect("no panic"), 12);
    assert!(stage.tells("now by 1.0 mm"));
    stage.button("Use it");
    let last = stage.desk.last().expect("a start");
    assert!(last.calibration.is_some());
}

#[test]
fn a_press_that_is_too_short_is_asked_for_again() {
    let mut stage = at(Step::Calibrate);
    stage.button("Begin");
    stage.see(|view| view.touches = vec![touch(1, [50.0, 50.0], 0.5)]);
    stage.see(|view| view.touches.clear());
    assert!(stage.tells("press a little longer"));
    assert!(stage.tells("0 of 25"));
}

#[test]
#[ignore = "searches for longer than a minute in an unoptimised build; tests/recommend.rs tests the search itself"]
fn presses_that_are_asked_for_become_settings_of_this_person() {
    let mut stage = at(Step::Recommend);
    stage
        .window
        .get_by_role_and_label(Role::TextInput, "Your name")
        .focus();
    stage.steps(1);
    stage.window.event(egui::Event::Text("anna".to_owned()));
    stage.steps(2);
    stage.button("Begin");
    let mut id = 0;
    for _ in 0..40 {
        if !stage.tells(" of ") {
            break;
        }
        let profile = stage.app().playing.view.profile.clone();
        let words = |name: &str| {
            stage.tells(&format!("tap {name},")) || stage.tells(&format!("press {name} and"))
        };
        let twice = |name: &str| stage.tells(&format!("tap {name} twice"));
        let asked = profile
            .regions
            .iter()
            .find(|r| words(&r.name) || twice(&r.name));
        let Some(region) = asked else { break };
        let long = stage.tells("hold it a second");
        let times = if twice(&region.name) { 2 } else { 1 };
        let place = region
            .placed([100.0, 100.0], &profile.settings.area)
            .centre_mm();
        for _ in 0..times {
            id += 1;
            for _ in 0..(if long { 100 } else { 10 }) {
                stage.quick(|view| view.touches = vec![touch(id, place, 0.5)]);
            }
            for _ in 0..12 {
                stage.quick(|view| view.touches.clear());
            }
        }
        for _ in 0..125 {
            stage.quick(|_| {});
        }
        stage.steps(2);
    }
    for _ in 0..1200 {
        if stage.tells("right presses") {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
        stage.steps(1);
    }
    assert!(stage.tells("right presses"), "{:?}", stage.window);
    stage.button("Save and use");
    let path = stage.desk.folder.path().join("users/anna.toml");
    assert!(path.exists());
    let user = stage.desk.last().expect("a start").user;
    assert_eq!(user, Some(path.display().to_string()));
}

#[test]
fn a_profile_is_chosen() {
    let mut stage = at(Step::Profile);
    stage.click(Role::RadioButton, "falling-blocks");
    assert_eq!(
        stage.desk.last().expect("a start").profile,
        "falling-blocks"
    );
}

#[test]
fn the_output_is_switched_on_and_checked_key_by_key() {
    let mut stage = at(Step::Check);
    stage.button("Send to this desktop");
    assert_eq!(stage.desk.last().expect("a start").to, To::Auto);
    stage.app().playing.choice.to = To::Auto;
    stage.steps(2);
    stage.button("Check: press the pad");
    stage.key(egui::Key::F);
    assert!(stage.tells("the system saw F"), "{:?}", stage.window);
    assert!(!stage.tells("the system saw D"));
    // A key that is looked at does nothing else here.
    stage.key(egui::Key::F1);
    assert_eq!(stage.app().tab, Tab::SetUp);
}

#[test]
fn which_way_round_solves_the_pad_first() {
    let mut stage = at(Step::WayRound);
    stage.button("Begin");
    assert!(stage.tells("solving the pad"));
}
