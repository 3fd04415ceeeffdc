//! Ways through the window from an empty home, counted in actions: a click, a text that is typed, a key. Presses of the pad that the
//! window asks for are not actions. The way of a gamer into a real game is that of `tests/game`: three clicks.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::app::services::{OutputChoice, SourceChoice};
use gelpad::gui::Tab;

use crate::record::{timeline, write_recording};
use crate::set_up::make_the_presses;
use crate::{Stage, WIDE};

/// A window and the actions that were taken in it.
struct Walk {
    stage: Stage,
    actions: usize,
}

impl Walk {
    fn start() -> Self {
        Self {
            stage: Stage::with_view(Tab::Play, WIDE),
            actions: 0,
        }
    }

    fn click(&mut self, role: Role, label: &str) {
        self.actions += 1;
        let control = self.stage.window.get_by_role_and_label(role, label);
        control.click_accesskit();
        self.stage.wait_for_start();
        self.stage.steps(12);
    }

    /// Types into a field, which is chosen by the same action.
    fn type_into(&mut self, label: &str, text: &str) {
        self.actions += 1;
        let field = self
            .stage
            .window
            .get_by_role_and_label(Role::TextInput, label);
        field.focus();
        self.stage.steps(2);
        self.stage.window.event(egui::Event::Text(text.to_owned()));
        self.stage.steps(3);
    }

    fn played(&self) -> gelpad::app::services::PlayRequest {
        self.stage.services.last_request().expect("a start")
    }

    /// Waits until frames of the board are shown.
    fn wait_for_frames(&mut self) {
        self.stage
            .wait_until(|stage| stage.app().playing.view.frames > 0);
    }
}

/// `gelpad device`, a board on a pseudo-terminal.
struct Board {
    process: Child,
    port: PathBuf,
    _folder: tempfile::TempDir,
}

impl Board {
    fn start(format: &str, pad: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let port = folder.path().join("board");
        let process = Command::new(env!("CARGO_BIN_EXE_gelpad"))
            .args(["device", "--format", format, "--pad", pad, "--port"])
            .arg(&port)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("gelpad starts");
        for _ in 0..1500 {
            if port.exists() {
                break;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        assert!(port.exists(), "the board did not start within 30 s");
        Self {
            process,
            port,
            _folder: folder,
        }
    }

    fn port(&self) -> &str {
        self.port.to_str().expect("UTF-8")
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

#[test]
fn a_gamer_without_a_pad_sends_keys_in_two_clicks_and_jumps_with_the_third() {
    let mut walk = Walk::start();
    walk.click(Role::Button, "Send to my game");
    assert_eq!(walk.played().output, OutputChoice::Auto);
    walk.click(Role::Button, "Pad window");
    assert!(walk.stage.app().pad_window.open);
    assert!(walk.actions < 3);
}

#[test]
fn a_board_on_a_typed_port_plays_after_three_actions() {
    let board = Board::start("openeit", "openeit-lattice");
    let mut walk = Walk::start();
    walk.stage.app().playing.request.pad = "openeit-lattice".to_owned();
    walk.click(Role::Tab, "Set up");
    walk.type_into("Other port", board.port());
    walk.click(Role::Button, "Use");
    assert_eq!(
        walk.played().source,
        SourceChoice::Serial(board.port().to_owned())
    );
    walk.wait_for_frames();
    assert!(walk.actions <= 4, "{}", walk.actions);
    diagnose(&mut walk);
}

/// The diagnosis of a board that plays: format, values and order; one more click plays it again.
fn diagnose(walk: &mut Walk) {
    walk.click(Role::Button, "Diagnose this port");
    walk.stage.wait_until(|stage| stage.shows("frames arrive"));
    for words in ["--format openeit", "values a frame", "192", "order"] {
        assert!(walk.stage.shows(words), "{words}: {:?}", walk.stage.window);
    }
    walk.click(Role::Button, "Play it");
    walk.wait_for_frames();
}

#[test]
fn a_builder_sees_a_pad_of_32_electrodes_after_seven_actions() {
    let mut walk = Walk::start();
    walk.click(Role::Tab, "Set up");
    walk.stage
        .window
        .get_by_label("Make a pad of your own")
        .click_accesskit();
    walk.actions += 1;
    walk.stage.steps(20);
    let field = walk
        .stage
        .window
        .get_by_role_and_label(Role::SpinButton, "Electrodes");
    field.set_value_accesskit(32.0);
    walk.actions += 1;
    walk.stage.steps(3);
    walk.click(Role::Button, "Save and use this pad");
    let pad = walk.played().pad;
    let board = Board::start("lines", &pad);
    walk.type_into("Other port", board.port());
    walk.click(Role::Button, "Use");
    walk.wait_for_frames();
    assert_eq!(walk.stage.app().playing.view.signals.volts.len(), 928);
    assert!(walk.actions <= 8, "{}", walk.actions);
    a_board_of_another_pad(&pad);
}

/// A board of a pad that is not shipped: the window says what it sends, and fills in the form.
fn a_board_of_another_pad(pad: &str) {
    let board = Board::start("lines", pad);
    let mut walk = Walk::start();
    walk.click(Role::Tab, "Set up");
    walk.type_into("Other port", board.port());
    walk.click(Role::Button, "Use");
    let reason = "928 values instead of 208: is this another pad?";
    let told = |stage: &mut Stage| {
        let problem = stage.app().problem();
        problem.is_some_and(|problem| problem.text.contains(reason))
    };
    walk.stage.wait_until(told);
    walk.click(Role::Button, "Diagnose this port");
    walk.stage.wait_until(|stage| stage.shows("frames arrive"));
    assert!(!walk.stage.has_label("Play it"));
    walk.click(Role::Button, "Make a pad with 32 electrodes");
    walk.stage.steps(20);
    walk.click(Role::Button, "Save and use this pad");
    walk.wait_for_frames();
    assert_eq!(walk.stage.app().playing.view.signals.volts.len(), 928);
}

#[test]
fn a_shaking_hand_gets_large_buttons_and_its_own_settings_in_eight_clicks() {
    let mut walk = Walk::start();
    walk.click(Role::Tab, "Set up");
    walk.click(Role::Button, "5 Personal settings");
    walk.click(Role::Button, "Start");
    make_the_presses(&mut walk.stage);
    walk.click(Role::Button, "Save and use");
    let person = walk.played().user.expect("a person");
    assert!(person.ends_with("users/me.toml"), "{person}");
    walk.click(Role::Tab, "Play");
    walk.click(Role::ComboBox, "Profile");
    let entry = walk.stage.window.get_by_label("large-buttons");
    entry.click_accesskit();
    walk.actions += 1;
    walk.stage.wait_for_start();
    let played = walk.played();
    assert_eq!(
        (played.profile.as_str(), played.user),
        ("large-buttons", Some(person))
    );
    assert!(walk.actions <= 12, "{}", walk.actions);
}

#[test]
fn a_tester_records_replays_and_checks_in_six_clicks() {
    let mut walk = Walk::start();
    walk.click(Role::Tab, "Record");
    walk.click(Role::Button, "Record");
    let file = walk.played().record.expect("a file");
    write_recording(&file);
    *walk.stage.services.tape.lock().expect("no panic") = Some(timeline());
    walk.stage.app().playing.request.record = Some(file.clone());
    walk.stage.steps(2);
    walk.click(Role::Button, "recording: stop");
    assert_eq!(walk.played().record, None);
    walk.click(Role::Button, "session-001");
    walk.stage
        .wait_until(|stage| stage.has_label("Save expected events"));
    walk.click(Role::Button, "Save expected events");
    assert!(is_event_file(&file.with_extension("events")));
    walk.click(Role::Button, "Check events");
    assert!(
        walk.stage.shows("events are as expected"),
        "{:?}",
        walk.stage.window
    );
    assert!(walk.actions <= 6, "{}", walk.actions);
}

/// Whether a file holds a press and a release, a line each.
fn is_event_file(file: &Path) -> bool {
    let text = std::fs::read_to_string(file).unwrap_or_default();
    let words: Vec<&str> = text
        .lines()
        .filter_map(|line| line.split(' ').nth(1))
        .collect();
    words.contains(&"press") && words.contains(&"release")
}
