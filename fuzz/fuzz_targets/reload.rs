//! A profile's text is saved while keys are held: whatever it contains, play continues, with it or with the old profile, and every
//! key that went down comes up.
//!
//! `cargo fuzz run -s none reload fuzz/corpus/reload profiles users` (with RUSTC_BOOTSTRAP=1 without a nightly compiler).

#![no_main]

mod common;

use std::sync::{Arc, OnceLock};

use common::{FRAME_NS, down, engine, pad, readings, tick};
use gelpad::engine::{Engine, Input};
use gelpad::profile::{Source, find_shipped, read};
use gelpad::types::{Event, Frame};
use libfuzzer_sys::fuzz_target;

/// Frames of rest (the reference) and with a finger on a key of the profile, before the reload.
const BEFORE: [usize; 2] = [15, 5];
/// Whether the finger is down in each frame after it: it stays, lifts, and comes again.
const AFTER: [bool; 11] = [
    true, true, false, false, false, false, true, true, true, false, false,
];
/// An engine that holds a key, the events so far, and the frames that follow.
struct Held {
    engine: Engine,
    events: Vec<Event>,
    frames: Vec<Frame>,
}

fn held() -> &'static Held {
    static HELD: OnceLock<Held> = OnceLock::new();
    HELD.get_or_init(|| {
        let pad = pad();
        let mut engine = engine(&pad);
        let mut frames = frames(&pad);
        let after = frames.split_off(BEFORE.iter().sum());
        let mut events = Vec::new();
        for frame in frames {
            engine.input(&Input::Frame(frame), &mut events);
        }
        assert!(engine.held_outputs().count() > 0, "a key is held");
        Held {
            engine,
            events,
            frames: after,
        }
    })
}

/// All frames.
fn frames(pad: &gelpad::pad::Pad) -> Vec<Frame> {
    let before = (0..BEFORE.iter().sum()).map(|frame: usize| frame >= BEFORE[0]);
    let readings = readings(pad, before.chain(AFTER)).into_iter().enumerate();
    let frame = |(index, volts)| Frame {
        t_ns: index as u64 * FRAME_NS,
        volts,
    };
    readings.map(frame).collect()
}

fuzz_target!(|text: &str| {
    let source = Source {
        name: "fuzzed".to_owned(),
        toml: text.to_owned(),
    };
    let Ok(checked) = read(source, None, &find_shipped) else {
        return;
    };
    let start = held();
    let (mut engine, mut events) = (start.engine.clone(), start.events.clone());
    let mut t_ns = start.frames[0].t_ns;
    let profile = Arc::new(checked.profile);
    engine.input(&Input::Profile { t_ns, profile }, &mut events);
    for frame in &start.frames {
        t_ns = frame.t_ns;
        tick(&mut engine, t_ns, &mut events);
        engine.input(&Input::Frame(frame.clone()), &mut events);
    }
    // A reload that waits for held outputs has waited long enough.
    t_ns += 1_500_000_000;
    tick(&mut engine, t_ns, &mut events);
    engine.input(&Input::End { t_ns }, &mut events);
    assert_eq!(engine.held_outputs().count(), 0);
    assert_eq!(down(&events), []);
});
