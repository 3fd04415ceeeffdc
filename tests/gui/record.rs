//! The record view, with a recording of a small pad.

use std::sync::{Arc, OnceLock};

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::app::timeline::RecordingTimeline;
use gelpad::engine::{Engine, Input};
use gelpad::gui::Tab;
use gelpad::gui::still;
use gelpad::pad::{Pad, shipped_pad};
use gelpad::source::{Noise, Script, SimulatedSource, Source as _, SourceReading};
use gelpad::touch::{Sensing, SensingBuilder};
use gelpad::types::{Frame, Method};

use crate::{Stage, WIDE};

/// Frames of the script at 100 frames/s, and the frame in which the finger goes down.
const FRAMES: usize = 121;
const DOWN: usize = 50;

fn pad() -> Pad {
    let shipped = shipped_pad("openeit-lattice").expect("shipped");
    Pad::from_toml(shipped.name, shipped.toml).expect("sound")
}

/// 500 ms of the untouched pad, 300 ms with a finger, 400 ms without.
pub fn timeline() -> RecordingTimeline {
    static MADE: OnceLock<(Arc<Sensing>, Vec<Frame>)> = OnceLock::new();
    let (sensing, frames) = MADE.get_or_init(|| {
        let pad = pad();
        let [w, h] = pad.outline.size_mm();
        let text = format!(
            "t:500 down 1 {} {}\nt:800 up 1\nt:1200 end",
            w * 0.8,
            h * 0.5
        );
        let script = Script::parse("s", &text).expect("sound");
        let mut source =
            SimulatedSource::new(&pad, &script, Noise::new(70.0, 1)).expect("solvable");
        let mut frames = Vec::new();
        while let SourceReading::Frame(frame) = source.read().expect("a reading") {
            frames.push(frame);
        }
        let builder = SensingBuilder::new(&pad, Method::default()).expect("solvable");
        (Arc::new(builder.build_initial().expect("a matrix")), frames)
    });
    let engine = Engine::new(&pad(), Arc::clone(sensing), still::profile());
    let mut timeline = RecordingTimeline::new(pad(), engine);
    for frame in frames {
        assert!(timeline.add_input(&Input::Frame(frame.clone())));
    }
    timeline
}

/// A file that the list of recordings shows; its content is that of [`timeline`].
pub fn write_recording(file: &std::path::Path) {
    std::fs::create_dir_all(file.parent().expect("a folder")).expect("created");
    std::fs::write(file, "not finished").expect("written");
}

fn stage() -> Stage {
    let mut stage = Stage::with_view(Tab::Record, WIDE);
    let file = stage.services.folder.path().join("session.mcap");
    stage.app().record.show(&file, timeline());
    stage.steps(3);
    stage
}

#[test]
fn the_record_button_restarts_the_game_and_stops_the_recording() {
    let mut stage = Stage::with_view(Tab::Record, WIDE);
    stage.button("Record");
    let file = stage
        .services
        .last_request()
        .and_then(|c| c.record)
        .expect("a file");
    assert!(file.starts_with(stage.services.folder.path()));
    stage.app().playing.request.record = Some(file.clone());
    stage.steps(2);
    stage.button("Stop recording");
    assert_eq!(stage.services.last_request().expect("a start").record, None);
}

#[test]
fn a_file_that_cannot_be_read_says_why() {
    let mut stage = Stage::with_view(Tab::Record, WIDE);
    stage
        .window
        .get_by_role_and_label(Role::TextInput, "File")
        .focus();
    stage.steps(1);
    stage
        .window
        .event(egui::Event::Text("nothing.mcap".to_owned()));
    stage.steps(2);
    stage.button("Open");
    stage.wait_until(|stage| stage.shows("this is not a recording"));
    assert!(
        !stage.shows("Save what can be read"),
        "nothing of gelpad's is in it"
    );
}

#[test]
fn space_presses_the_control_that_has_the_focus() {
    let mut stage = stage();
    assert!(stage.tab_to("Step forward"));
    stage.key(egui::Key::Space);
    assert!(stage.shows("frame 2 of"), "{:?}", stage.window);
    assert!(stage.tab_to("Position in the recording"));
    stage.key(egui::Key::End);
    assert!(stage.shows(&format!("frame {FRAMES} of")));
    stage.key(egui::Key::Home);
    assert!(stage.shows("frame 1 of"));
}

#[test]
fn what_can_be_read_of_a_damaged_recording_is_saved_and_shown() {
    let mut stage = Stage::with_view(Tab::Record, WIDE);
    let file = stage.services.folder.path().join("damaged.mcap");
    stage.app().record.suggest(&file);
    stage.steps(2);
    stage.button("Open");
    stage.wait_until(|stage| stage.shows("this is not a recording"));
    stage.button("Save what can be read of damaged.mcap");
    stage.wait_until(|stage| stage.shows("no room on the disk"));
    stage.button("Save what can be read of damaged.mcap");
    stage.wait_until(|stage| stage.shows(&format!("frame 1 of {FRAMES}")));
    assert!(stage.shows("Saved 121 frames; one place could not be read"));
    assert!(stage.shows("damaged-saved.mcap"));
    assert!(!stage.shows("Save what can be read"), "done");
}

#[test]
fn a_recording_is_stepped_through_frame_by_frame() {
    let mut stage = stage();
    assert!(
        stage.shows(&format!("frame 1 of {FRAMES}")),
        "{:?}",
        stage.window
    );
    stage.button("Step forward");
    assert!(stage.shows("frame 2 of"));
    stage.key(egui::Key::Period);
    assert!(stage.shows("frame 3 of"));
    stage.key(egui::Key::Comma);
    stage.button("Step back");
    assert!(stage.shows("frame 1 of"));
}

#[test]
fn dragging_the_bar_changes_the_frame() {
    let mut stage = stage();
    let line = stage
        .window
        .get_by_role_and_label(Role::Slider, "Position in the recording")
        .rect();
    stage
        .window
        .drag_at(line.center() + egui::vec2(0.05 * line.width(), 0.0));
    stage.steps(3);
    let shown = stage.window.query_by_label_contains(" s   frame ");
    assert!(shown.is_some());
    assert!(!stage.shows("frame 1 of"));
}

#[test]
fn a_recording_plays_to_its_end_or_loops() {
    let mut stage = stage();
    stage.button("Play");
    stage.steps(120);
    assert!(
        stage.shows(&format!("frame {FRAMES} of {FRAMES}")),
        "{:?}",
        stage.window
    );
    assert!(!stage.has_label("Pause"), "stopped");
    stage.click(Role::CheckBox, "Loop");
    stage.button("Play");
    stage.steps(150);
    assert!(stage.has_label("Pause"), "still playing");
}

#[test]
fn a_marked_part_is_exported_and_can_be_read_back() {
    let mut stage = stage();
    stage.button("Mark start");
    for _ in 0..9 {
        stage.button("Step forward");
    }
    stage.button("Mark end");
    stage.button("Export part");
    let file = stage.services.folder.path().join("session-0-9.csv");
    let channels = pad().channels();
    let mut frames = gelpad::source::FramesCsv::open(&file, channels).expect("frames");
    let mut count = 0;
    while let SourceReading::Frame(_) = frames.read().expect("a reading") {
        count += 1;
    }
    assert_eq!(count, 10);
    stage.button("Clear marks");
}

#[test]
fn the_timeline_contains_the_touch() {
    let timeline = timeline();
    assert_eq!(timeline.len(), FRAMES);
    let view = |frame| timeline.view(frame, still::view_of_pad(&timeline.pad, still::profile()));
    assert!(view(DOWN - 5).touches.is_empty());
    assert_eq!(view(DOWN + 10).touches.len(), 1);
    assert!((timeline.seconds(FRAMES - 1) - 1.2).abs() < 1e-9);
    assert_eq!(timeline.frame_at(0.5), DOWN);
}

#[test]
fn recordings_are_listed_renamed_and_deleted() {
    let mut stage = Stage::with_view(Tab::Record, WIDE);
    let folder = stage.services.folder.path().join("recordings");
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("session-001.mcap"), vec![0; 2_000_000]).expect("written");
    // The folder is read again every two seconds.
    stage.steps(12);
    assert!(stage.shows("session-001"), "{:?}", stage.window);
    assert!(stage.shows("2.0 MB"));
    stage.button("Show folder");
    let shown = stage
        .services
        .shown_folders
        .lock()
        .expect("no panic")
        .clone();
    assert_eq!(shown, std::slice::from_ref(&folder));
    stage.button("Rename session-001");
    stage
        .window
        .get_by_role_and_label(Role::TextInput, "New name")
        .focus();
    stage.steps(1);
    stage
        .window
        .key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    stage.window.event(egui::Event::Text("level".to_owned()));
    stage.steps(2);
    stage.button("Rename");
    assert!(folder.join("level.mcap").exists());
    stage.steps(2);
    stage.button("Delete level");
    stage.steps(2);
    let cancel = stage.window.get_by_label("Cancel");
    assert!(cancel.is_focused(), "Enter keeps the file");
    stage.button("Delete");
    assert!(!folder.join("level.mcap").exists());
}

#[test]
fn the_recording_that_is_being_written_is_left_alone() {
    let mut stage = Stage::with_view(Tab::Record, WIDE);
    let folder = stage.services.folder.path().join("recordings");
    std::fs::create_dir_all(&folder).expect("a folder");
    for name in ["done", "running"] {
        std::fs::write(folder.join(format!("{name}.mcap")), b"frames").expect("written");
    }
    stage.app().playing.request.record = Some(folder.join("running.mcap"));
    stage.steps(12);
    assert!(stage.shows("recording now"), "{:?}", stage.window);
    assert!(stage.has_label("Delete done"));
    for button in ["▶ running", "Rename running", "Delete running"] {
        assert!(!stage.has_label(button), "{button}");
    }
}
