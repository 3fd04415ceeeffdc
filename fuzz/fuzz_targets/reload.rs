//! A profile's text is saved while keys are held: whatever it contains, play continues, with it or with the old profile, and every
//! key that went down comes up.
//!
//! `cargo fuzz run -s none reload fuzz/corpus/reload profiles users` (with RUSTC_BOOTSTRAP=1 without a nightly compiler).

#![no_main]

use std::sync::{Arc, OnceLock};

use gelpad::eit::Press;
use gelpad::engine::{Engine, Input};
use gelpad::pad::{DEFAULT_PAD, Pad, shipped_pad};
use gelpad::profile::{Profile, Source, find_shipped, read, shipped_profile};
use gelpad::source::{Noise, SimulatedPad};
use gelpad::touch::SensingBuilder;
use gelpad::types::{Action, Event, Frame, Method, Output};
use libfuzzer_sys::fuzz_target;

const FRAME_NS: u64 = 10_000_000;
/// Frames of rest (the reference) and with a finger on a key of the profile, before the reload.
const BEFORE: [usize; 2] = [15, 5];
/// Whether the finger is down in each frame after it: it stays, lifts, and comes again.
const AFTER: [bool; 11] = [
    true, true, false, false, false, false, true, true, true, false, false,
];
/// More ticks than any profile needs in the time that is played: the engine is in a loop.
const MOST_TICKS: usize = 10_000;

/// An engine that holds a key, the events so far, and the frames that follow.
struct Held {
    engine: Engine,
    events: Vec<Event>,
    frames: Vec<Frame>,
}

fn held() -> &'static Held {
    static HELD: OnceLock<Held> = OnceLock::new();
    HELD.get_or_init(|| {
        let text = shipped_pad(DEFAULT_PAD).expect("shipped").toml;
        let pad = Pad::from_toml(DEFAULT_PAD, text).expect("sound");
        let profile = shipped_profile("super-mario").expect("shipped");
        let profile = Profile::from_toml(profile.name, profile.toml).expect("sound");
        let sensing = SensingBuilder::new(&pad, Method::default())
            .and_then(|builder| builder.build_initial())
            .expect("solvable");
        let mut engine = Engine::new(&pad, Arc::new(sensing), Arc::new(profile));
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
fn frames(pad: &Pad) -> Vec<Frame> {
    let simulated = SimulatedPad::new(pad).expect("solvable");
    let finger = Press {
        centre_mm: [80.0, 50.0],
        radius_mm: 7.0,
        rise: 1.2,
    };
    let [rest, pressed] =
        [vec![], vec![finger]].map(|presses| simulated.volts(&presses).expect("solvable"));
    let mut noise = Noise::new(60.0, 1);
    let before = (0..BEFORE.iter().sum()).map(|frame: usize| frame >= BEFORE[0]);
    let frame = |(index, is_pressed)| Frame {
        t_ns: index as u64 * FRAME_NS,
        volts: noise.read(if is_pressed { &pressed } else { &rest }),
    };
    before.chain(AFTER).enumerate().map(frame).collect()
}

/// Plays every tick up to a time.
fn tick(engine: &mut Engine, until_ns: u64, events: &mut Vec<Event>) {
    for _ in 0..MOST_TICKS {
        match engine.next_due() {
            Some(due_ns) if due_ns <= until_ns => engine.input(&Input::Tick { due_ns }, events),
            _ => return,
        }
    }
    panic!("more than {MOST_TICKS} ticks");
}

/// Outputs that the events leave down.
fn down(events: &[Event]) -> Vec<Output> {
    let mut down = Vec::new();
    for event in events {
        match event.action {
            Action::Press(output) => {
                assert!(!down.contains(&output), "{output} is pressed twice");
                down.push(output);
            }
            Action::Release(output) => {
                let at = down.iter().position(|pressed| *pressed == output);
                down.remove(at.unwrap_or_else(|| panic!("{output} was not down")));
            }
            _ => {}
        }
    }
    down
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
