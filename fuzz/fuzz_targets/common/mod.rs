//! What targets that play an engine share: the shipped pad and profile, readings with and without a finger, ticks, and the check that
//! presses and releases alternate.

use std::sync::Arc;

use gelpad::eit::Press;
use gelpad::engine::{Engine, Input};
use gelpad::pad::{DEFAULT_PAD, Pad, shipped_pad};
use gelpad::profile::{Profile, shipped_profile};
use gelpad::source::{Noise, SimulatedPad};
use gelpad::touch::SensingBuilder;
use gelpad::types::{Action, Event, Method, Output};

pub const FRAME_NS: u64 = 10_000_000;
/// More ticks than any profile needs in the time that is played: the engine is in a loop.
const MOST_TICKS: usize = 10_000;

pub fn pad() -> Pad {
    let text = shipped_pad(DEFAULT_PAD).expect("shipped").toml;
    Pad::from_toml(DEFAULT_PAD, text).expect("sound")
}

/// An engine of the pad that plays `super-mario`.
pub fn engine(pad: &Pad) -> Engine {
    let profile = shipped_profile("super-mario").expect("shipped");
    let profile = Profile::from_toml(profile.name, profile.toml).expect("sound");
    let sensing = SensingBuilder::new(pad, Method::default())
        .and_then(|builder| builder.build_initial())
        .expect("solvable");
    Engine::new(pad, Arc::new(sensing), Arc::new(profile))
}

/// A frame's noisy readings for each entry: with a finger on `jump`, or untouched.
pub fn readings(pad: &Pad, is_pressed: impl Iterator<Item = bool>) -> Vec<Vec<f32>> {
    let simulated = SimulatedPad::new(pad).expect("solvable");
    let finger = Press {
        centre_mm: [80.0, 50.0],
        radius_mm: 7.0,
        rise: 1.2,
    };
    let [rest, pressed] =
        [vec![], vec![finger]].map(|presses| simulated.volts(&presses).expect("solvable"));
    let mut noise = Noise::new(60.0, 1);
    is_pressed
        .map(|is_pressed| noise.read(if is_pressed { &pressed } else { &rest }))
        .collect()
}

/// Plays every tick up to a time.
pub fn tick(engine: &mut Engine, until_ns: u64, events: &mut Vec<Event>) {
    for _ in 0..MOST_TICKS {
        match engine.next_due() {
            Some(due_ns) if due_ns <= until_ns => engine.input(&Input::Tick { due_ns }, events),
            _ => return,
        }
    }
    panic!("more than {MOST_TICKS} ticks");
}

/// Outputs that the events leave down. Panics unless presses and releases alternate.
pub fn down(events: &[Event]) -> Vec<Output> {
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
