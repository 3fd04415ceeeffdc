//! The view to record and replay in, on a tape of a small pad.

use std::sync::{Arc, OnceLock};

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::engine::{Engine, Input};
use gelpad::gui::Tab;
use gelpad::gui::record::tape::Tape;
use gelpad::gui::still;
use gelpad::pad::{Pad, shipped_pad};
use gelpad::source::{Noise, Reading, Script, SimulatedSource, Source as _};
use gelpad::touch::{Sensing, SensingBuilder};
use gelpad::types::{Frame, Method};

use crate::{Stage, WIDE};

/// Frames of the script at 100 a second, and the one in which the finger goes down.
const FRAMES: usize = 121;
const DOWN: usize = 50;

fn pad() -> Pad {
    let shipped = shipped_pad("openeit-lattice").expect("shipped");
    Pad::from_toml(shipped.name, shipped.toml).expect("sound")
}

/// Half a second of the untouched pad, 300 ms of a finger on it, the rest.
fn tape() -> Tape {
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
        while let Reading::Frame(frame) = source.read().expect("a reading") {
            frames.push(frame);
        }
        let builder = SensingBuilder::new(&pad, Method::default()).expect("solvable");
        (Arc::new(builder.first().expect("a matrix")), frames)
    });
    let engine = Engine::new(&pad(), Arc::clone(sensing), still::profile());
    let mut tape = Tape::new(pad(), engine);
    for frame in frames {
        assert!(tape.take(&Input::Frame(frame.clone())));
    }
    tape
}

fn stage() -> Stage {
    let mut stage = Stage::of(Tab::Record, WIDE);
    let file = stage.desk.folder.path().join("session.mcap");
    stage.app().record.show(&file, tape());
    stage.steps(3);
    stage
}

#[test]
fn recording_begins_with_the_game_anew_and_ends_with_the_file_at_hand() {
    let mut stage = Stage::of(Tab::Record, WIDE);
    stage.button("⏺ Record");
    let file = stage.desk.last().and_then(|c| c.record).expect("a file");
    assert!(file.starts_with(stage.desk.folder.path()));
    stage.app().playing.choice.record = Some(file.clone());
    stage.steps(2);
    stage.button("⏹ Stop recording");
    assert_eq!(stage.desk.last().expect("a start").record, None);
}

#[test]
fn a_file_that_is_none_says_so() {
    let mut stage = Stage::of(Tab::Record, WIDE);
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
    for _ in 0..100 {
        std::thread::sleep(std::time::Duration::from_millis(10));
        stage.steps(1);
        if stage.tells("this is no recording") {
            return;
        }
    }
    panic!("{:?}", stage.window);
}

#[test]
fn a_tape_is_stepped_through_frame_by_frame() {
    let mut stage = stage();
    assert!(
        stage.tells(&format!("frame 1 of {FRAMES}")),
        "{:?}",
        stage.window
    );
    stage.button("Step on ▶");
    assert!(stage.tells("frame 2 of"));
    stage.key(egui::Key::Period);
    assert!(stage.tells("frame 3 of"));
    stage.key(egui::Key::Comma);
    stage.button("◀ Step back");
    assert!(stage.tells("frame 1 of"));
}

#[test]
fn it_is_scrubbed_and_the_touch_is_there_where_it_was() {
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
    assert!(!stage.tells("frame 1 of"));
}

#[test]
fn it_plays_to_its_end_and_loops_if_wanted() {
    let mut stage = stage();
    stage.button("▶ Play");
    stage.steps(120);
    assert!(
        stage.tells(&format!("frame {FRAMES} of {FRAMES}")),
        "{:?}",
        stage.window
    );
    assert!(stage.has("▶ Play"), "it has stopped");
    stage.click(Role::CheckBox, "Loop");
    stage.button("▶ Play");
    stage.steps(150);
    assert!(stage.has("⏸ Pause"), "it goes on");
}

#[test]
fn a_piece_is_marked_and_exported_and_replay_reads_it() {
    let mut stage = stage();
    stage.button("Mark begin");
    for _ in 0..9 {
        stage.button("Step on ▶");
    }
    stage.button("Mark end");
    stage.button("Export piece");
    let file = stage.desk.folder.path().join("session-0-9.csv");
    let channels = pad().channels();
    let mut frames = gelpad::source::FramesCsv::open(&file, channels).expect("frames");
    let mut count = 0;
    while let Reading::Frame(_) = frames.read().expect("a reading") {
        count += 1;
    }
    assert_eq!(count, 10);
    stage.button("Clear marks");
}

#[test]
fn a_tape_knows_when_it_was_touched() {
    let tape = tape();
    assert_eq!(tape.len(), FRAMES);
    let view = |frame| tape.view(frame, still::view_of(&tape.pad, still::profile()));
    assert!(view(DOWN - 5).touches.is_empty());
    assert_eq!(view(DOWN + 10).touches.len(), 1);
    assert!((tape.seconds(FRAMES - 1) - 1.2).abs() < 1e-9);
    assert_eq!(tape.frame_at(0.5), DOWN);
}
