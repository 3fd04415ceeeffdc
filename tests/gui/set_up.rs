//! The setup wizard.

use std::time::Duration;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::app::services::{OutputChoice, SourceChoice};
use gelpad::gui::Tab;
use gelpad::gui::setup::Step;
use gelpad::gui::still::touch;
use gelpad::runtime::PlayCommand;
use gelpad::types::Contact;

use crate::services::{NO_OUTPUT, NO_START};
use crate::{Stage, WIDE};

/// Steps that the window waits for what runs beside it.
const MOST_STEPS: usize = 10_000;

fn stage() -> Stage {
    Stage::with_view(Tab::SetUp, WIDE)
}

pub fn at(step: Step) -> Stage {
    let mut stage = stage();
    stage.app().set_up.step = step;
    stage.steps(3);
    stage
}

#[test]
fn the_keyboard_alone_reaches_the_end() {
    let mut stage = stage();
    for (nth, step) in Step::ALL.into_iter().enumerate() {
        assert_eq!(stage.app().set_up.step, step);
        let last = nth + 1 == Step::ALL.len();
        // The navigation has a `Play` tab too: the wizard's is a button.
        let found = (0..150).any(|_| {
            stage.key(egui::Key::Tab);
            let label = if last { "Play" } else { "Next" };
            stage
                .window
                .query_by_role_and_label(Role::Button, label)
                .is_some_and(|node| node.is_focused())
        });
        assert!(found, "{step:?}: the keyboard does not reach the next step");
        stage.key(egui::Key::Enter);
    }
    assert_eq!(stage.app().tab, Tab::Play);
}

#[test]
fn back_and_next_change_the_step() {
    let mut stage = stage();
    stage.button("Next");
    assert_eq!(stage.app().set_up.step, Step::Orientation);
    stage.button("Back");
    assert_eq!(stage.app().set_up.step, Step::Board);
}

#[test]
fn each_step_is_opened_by_its_tab() {
    let mut stage = stage();
    for (nth, step) in Step::ALL.into_iter().enumerate().skip(1) {
        stage.button(&format!("{} {}", nth + 1, step.title()));
        assert_eq!(stage.app().set_up.step, step);
    }
}

#[test]
fn a_search_finds_a_port_that_is_plugged_in() {
    let mut stage = stage();
    assert!(stage.shows("No serial port found"));
    stage
        .services
        .ports
        .lock()
        .expect("no panic")
        .push("/dev/ttyUSB3".to_owned());
    stage.button("Search again");
    stage.click(Role::RadioButton, "/dev/ttyUSB3");
    let last = stage.services.last_request().expect("a start");
    assert_eq!(last.source, SourceChoice::Serial("/dev/ttyUSB3".to_owned()));
}

#[test]
fn another_pad_can_be_chosen() {
    let mut stage = stage();
    stage.click(Role::ComboBox, "Pad");
    stage.window.get_by_label("round-tank").click();
    stage.wait_for_start();
    assert_eq!(
        stage.services.last_request().expect("a start").pad,
        "round-tank"
    );
}

#[test]
fn the_quality_of_the_readings_is_shown() {
    let mut stage = stage();
    stage.update_view(|view| {
        view.frames_per_s = 98.0;
        view.signals.volts = vec![1.0; 208];
        view.signals.noise = vec![1e-3; 208];
    });
    for words in ["98 frames/s", "208", "60 dB"] {
        assert!(stage.shows(words), "{words}");
    }
}

#[test]
fn zero_warns_while_the_pad_is_touched() {
    let mut stage = at(Step::Zero);
    assert!(stage.shows("no touches"));
    stage.button("Set to zero");
    assert!(matches!(
        stage.app().playing.unsent_commands[..],
        [PlayCommand::Rezero]
    ));
    stage.update_view(|view| view.touches = vec![touch(1, [50.0, 50.0], 0.5)]);
    assert!(stage.shows("is the pad free?"));
}

/// Makes a press at the place that is shown, long enough to count.
fn press_the_shown_place(stage: &mut Stage, press: u64) {
    for _ in 0..10 {
        stage.update_view(|view| {
            view.touches = vec![touch(press, [50.0, 50.0], 0.5)];
            view.signals.changes = vec![0.01; 208];
        });
    }
    stage.update_view(|view| view.touches.clear());
}

#[test]
fn guided_presses_become_a_calibration() {
    let mut stage = at(Step::Calibrate);
    stage
        .window
        .get_by_role_and_label(Role::Slider, "places")
        .set_value_accesskit(12.0);
    stage.steps(2);
    stage.button("Begin");
    press_the_shown_place(&mut stage, 0);
    assert!(stage.shows("1 of 12"));
    // An accident.
    stage.button("Take back the last press");
    for press in 0..12 {
        assert!(stage.shows(&format!("{press} of 12")), "press {press}");
        press_the_shown_place(&mut stage, press);
    }
    assert_eq!(*stage.services.calibrated.lock().expect("no panic"), 12);
    assert!(stage.shows("now by 1.0 mm"));
    stage.button("Use the calibration");
    let last = stage.services.last_request().expect("a start");
    assert!(last.calibration.is_some());
}

#[test]
fn guided_presses_find_the_pad_as_it_is() {
    let mut stage = at(Step::Calibrate);
    stage.button("Begin");
    for _ in 0..20 {
        stage.update_view(|view| view.signals.volts = vec![1.0; 208]);
    }
    for press in 0..9 {
        press_the_shown_place(&mut stage, press);
    }
    stage.button("That is enough: learn from these");
    stage.steps(2);
    assert!(
        stage.shows("9 presses and some untouched frames"),
        "{:?}",
        stage.window
    );
    stage.button("Play with the pad as it is");
    let last = stage.services.last_request().expect("a start");
    assert!(last.pad.ends_with("pad-found.toml"), "{}", last.pad);
    assert!(last.calibration.is_none());
}

#[test]
fn presses_that_teach_nothing_are_kept_and_more_places_follow() {
    let mut stage = at(Step::Calibrate);
    *stage.services.calibration_error.lock().expect("no panic") = Some("they disagree".to_owned());
    stage
        .window
        .get_by_role_and_label(Role::Slider, "places")
        .set_value_accesskit(12.0);
    stage.steps(2);
    stage.button("Begin");
    for press in 0..9 {
        press_the_shown_place(&mut stage, press);
    }
    stage.button("That is enough: learn from these");
    assert!(stage.shows("they disagree") && stage.shows("9 of 12"));
    for press in 9..12 {
        press_the_shown_place(&mut stage, press);
    }
    assert!(stage.shows("they disagree") && stage.shows("12 of 20"));
    *stage.services.calibration_error.lock().expect("no panic") = None;
    stage.button("That is enough: learn from these");
    assert_eq!(*stage.services.calibrated.lock().expect("no panic"), 12);
}

#[test]
fn presses_promise_an_error_and_are_enough_before_the_last() {
    let mut stage = at(Step::Calibrate);
    stage.button("Begin");
    for press in 0..10 {
        assert!(!stage.has_label("That is enough: learn from these") || press >= 8);
        for _ in 0..10 {
            stage.update_view(|view| {
                view.touches = vec![touch(press, [50.0, 50.0], 0.5)];
                view.signals.contacts = vec![Contact {
                    centre_mm: [10.0 + 3.0 * press as f64, 30.0 + 20.0 * (press % 3) as f64],
                    area_mm2: 100.0,
                    force: 0.5,
                    confidence: 1.0,
                }];
                view.signals.changes = (0..208)
                    .map(|c| 0.01 * (1.0 + press as f32 + (c % 7) as f32 * (press % 3) as f32))
                    .collect();
            });
        }
        stage.update_view(|view| {
            view.touches.clear();
            view.signals.contacts.clear();
        });
    }
    assert!(stage.shows("10 of 25"));
    // It is estimated beside the window.
    let promise = "expected error with 10 presses: ";
    for _ in 0..MOST_STEPS {
        if stage.shows(promise) {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
        stage.steps(1);
    }
    assert!(stage.shows(promise), "{:?}", stage.window);
    stage.button("That is enough: learn from these");
    assert_eq!(*stage.services.calibrated.lock().expect("no panic"), 10);
    assert!(stage.shows("now by 1.0 mm"));
}

#[test]
fn a_short_press_has_to_be_repeated() {
    let mut stage = at(Step::Calibrate);
    stage.button("Begin");
    stage.update_view(|view| view.touches = vec![touch(1, [50.0, 50.0], 0.5)]);
    stage.update_view(|view| view.touches.clear());
    assert!(stage.shows("press a little longer"));
    assert!(stage.shows("0 of 25"));
}

/// Makes the presses that the window asks for, and waits for the recommendation.
pub fn make_the_presses(stage: &mut Stage) {
    make_presses(stage, 40);
    wait_for_recommendation(stage);
}

/// Makes at most so many of the requested presses.
pub fn make_presses(stage: &mut Stage, most: usize) {
    let mut id = 0;
    for _ in 0..most {
        if !stage.shows(" of ") {
            break;
        }
        let profile = stage.app().playing.view.profile.clone();
        // The outputs of the region follow its name.
        let is_asked = |name: &str| {
            stage.shows(&format!("tap {name} (")) || stage.shows(&format!("press {name} ("))
        };
        let asked = profile.regions.iter().find(|r| is_asked(&r.name));
        let Some(region) = asked else { break };
        let long = stage.shows("hold it a second");
        let times = if stage.shows("twice") { 2 } else { 1 };
        let place = region
            .placed([100.0, 100.0], &profile.settings.area)
            .centre_mm();
        for _ in 0..times {
            id += 1;
            for _ in 0..(if long { 100 } else { 10 }) {
                stage.update_view_once(|view| view.touches = vec![touch(id, place, 0.5)]);
            }
            for _ in 0..12 {
                stage.update_view_once(|view| view.touches.clear());
            }
        }
        for _ in 0..205 {
            stage.update_view_once(|_| {});
        }
        stage.steps(2);
    }
}

/// Waits until settings are recommended.
pub fn wait_for_recommendation(stage: &mut Stage) {
    for _ in 0..1200 {
        if stage.shows("of your presses were right") {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
        stage.steps(1);
    }
}

#[test]
fn guided_presses_become_personal_settings() {
    let mut stage = at(Step::Recommend);
    stage
        .window
        .get_by_role_and_label(Role::TextInput, "Your name")
        .focus();
    stage.steps(1);
    stage.window.event(egui::Event::Text("anna".to_owned()));
    stage.steps(2);
    stage.button("Start");
    make_the_presses(&mut stage);
    assert!(
        stage.shows("of your presses were right"),
        "{:?}",
        stage.window
    );
    stage.button("Save and use");
    let path = stage.services.folder.path().join("users/anna.toml");
    assert!(path.exists());
    let user = stage.services.last_request().expect("a start").user;
    assert_eq!(user, Some(path.display().to_string()));
}

#[test]
fn a_profile_can_be_chosen() {
    let mut stage = at(Step::Profile);
    stage.click(Role::RadioButton, "falling-blocks");
    assert_eq!(
        stage.services.last_request().expect("a start").profile,
        "falling-blocks"
    );
}

#[test]
fn the_output_check_shows_received_keys() {
    let mut stage = at(Step::Check);
    stage.button("Send to this desktop");
    assert_eq!(
        stage.services.last_request().expect("a start").output,
        OutputChoice::Auto
    );
    stage.app().playing.request.output = OutputChoice::Auto;
    stage.app().failed = None;
    stage.steps(2);
    stage.button("Start the check");
    stage.key(egui::Key::F);
    assert!(stage.shows("received F"), "{:?}", stage.window);
    assert!(!stage.shows("received D"));
    // A key that the game sends does not act on the window: here it would choose a control. Others lead on.
    let focused = stage.window.ctx.memory(|memory| memory.focused());
    stage.key(egui::Key::ArrowLeft);
    assert!(stage.shows("received ←"), "{:?}", stage.window);
    assert_eq!(stage.window.ctx.memory(|memory| memory.focused()), focused);
    stage.key(egui::Key::F1);
    assert_eq!(stage.app().tab, Tab::Play);
}

#[test]
fn a_gamepad_is_offered_with_what_it_needs_and_its_command() {
    let mut stage = at(Step::Check);
    assert!(stage.shows("gamepads as a source"), "{:?}", stage.window);
    stage.button("Send to a virtual gamepad");
    let last = stage.services.last_request().expect("a start");
    assert_eq!(last.output, OutputChoice::Gamepad);
    let mut stage = at(Step::Board);
    stage.click(Role::RadioButton, "Gamepad or switches");
    let last = stage.services.last_request().expect("a start");
    assert_eq!(last.source, SourceChoice::Gamepad);
    assert!(stage.shows("/dev/uinput"), "{:?}", stage.window);
}

#[test]
fn an_output_that_does_not_open_is_named_with_its_help() {
    let mut stage = at(Step::Check);
    *stage.services.broken_output.lock().expect("no panic") = Some(OutputChoice::Gamepad);
    stage.app().playing.output = "keyboard and mouse of the X11 display".to_owned();
    stage.button("Send to a virtual gamepad");
    let words = format!("The chosen output, gamepad, gets no keys: {NO_OUTPUT}");
    assert!(stage.shows(&words), "{:?}", stage.window);
    assert!(stage.shows("gamepads as a source"), "the help");
    assert!(stage.shows("to gamepad"), "the status line");
    assert!(!stage.shows("X11"));
    assert!(!stage.has_label("Start the check"));
    stage.button("Try again");
    let last = stage.services.last_request().expect("a start");
    assert_eq!(last.output, OutputChoice::Gamepad);
    *stage.services.broken_output.lock().expect("no panic") = Some(OutputChoice::Auto);
    stage.button("Send to this desktop");
    let last = stage.services.last_request().expect("a start");
    assert_eq!(last.output, OutputChoice::Auto);
    // A computer without a desktop may still have a gamepad.
    assert!(stage.shows(NO_OUTPUT), "{:?}", stage.window);
    stage.button("Send to a virtual gamepad");
    let last = stage.services.last_request().expect("a start");
    assert_eq!(last.output, OutputChoice::Gamepad);
}

#[test]
fn a_port_that_is_gone_is_no_fault_of_the_output() {
    let mut stage = at(Step::Check);
    stage.button("Send to this desktop");
    let words = format!("The game does not start: {NO_START}");
    assert!(stage.shows(&words), "{:?}", stage.window);
    assert!(!stage.shows("gets no keys"), "{:?}", stage.window);
    assert!(!stage.has_label("Start the check"));
    let before = stage.services.started.lock().expect("no panic").len();
    stage.button("Try again");
    let after = stage.services.started.lock().expect("no panic").len();
    assert_eq!(after, before + 1);
}

#[test]
fn the_way_on_is_in_view_at_the_first_size() {
    let stage = Stage::with_view(Tab::SetUp, [1240.0, 730.0]);
    for label in ["Back", "Next"] {
        let rect = stage.button_rect(label);
        assert!(rect.bottom() < 700.0 && rect.height() > 24.0, "{rect:?}");
    }
}

#[test]
fn a_port_that_cannot_be_opened_is_explained() {
    let mut stage = at(Step::Board);
    stage.app().playing.request.source = SourceChoice::Serial("/dev/none".to_owned());
    stage.steps(2);
    stage.button("Diagnose this port");
    stage.wait_until(|stage| !stage.shows("listening to"));
    assert!(stage.shows("/dev/none: "), "{:?}", stage.window);
}

#[test]
fn orientation_starts_by_solving_the_pad() {
    let mut stage = at(Step::Orientation);
    stage.button("Begin");
    assert!(stage.shows("solving the pad"));
}

#[test]
fn a_pad_with_32_electrodes_is_made_from_a_form() {
    let mut stage = Stage::with_view(Tab::SetUp, WIDE);
    stage
        .window
        .get_by_label("Make a pad of your own")
        .click_accesskit();
    stage.steps(20);
    let field = stage
        .window
        .get_by_role_and_label(Role::SpinButton, "Electrodes");
    field.set_value_accesskit(32.0);
    stage.steps(3);
    assert!(stage.shows("928 readings per frame"), "{:?}", stage.window);
    let save = stage
        .window
        .get_by_role_and_label(Role::Button, "Save and use this pad");
    save.click_accesskit();
    stage.wait_for_start();
    let path = stage.services.folder.path().join("pads/my-pad.toml");
    let text = std::fs::read_to_string(&path).expect("a file");
    assert!(text.contains("count = 32"), "{text}");
    let played = stage.services.last_request().expect("a start").pad;
    assert_eq!(played, path.display().to_string());
}

#[test]
fn a_board_that_does_not_fit_the_pad_says_so_where_it_is_chosen() {
    let mut stage = Stage::with_view(Tab::SetUp, WIDE);
    let playing = &mut stage.app().playing;
    playing.request.source = SourceChoice::Serial("/dev/ttyACM0".to_owned());
    playing.ended = Some("the board sends 192 voltages".to_owned());
    stage.steps(2);
    assert!(
        stage.shows("the board sends 192 voltages"),
        "{:?}",
        stage.window
    );
    assert!(stage.shows("Diagnose this port finds out what it sends"));
}
