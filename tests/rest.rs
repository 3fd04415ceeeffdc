//! A forearm resting on a third of the pad: taps beside it are found, and it presses nothing.
//!
//! Uses the simulated pad at 60 dB and the whole engine. The forearm is a chain of overlapping discs along the left edge.

use std::sync::{Arc, Mutex, PoisonError};

use gelpad::eit::Press;
use gelpad::engine::{Engine, Input};
use gelpad::pad::{DEFAULT_PAD, Pad, shipped_pad};
use gelpad::profile::Profile;
use gelpad::source::{Noise, SimulatedPad};
use gelpad::touch::SensingBuilder;
use gelpad::types::{Action, Event, Frame, Method, NANOS_PER_MS, Nanos};

const FRAME_NS: Nanos = 10 * NANOS_PER_MS;
const SNR_DB: f64 = 60.0;
const TAPS: usize = 20;
/// Frames of a tap, and between two taps.
const TAP_FRAMES: u64 = 12;
const GAP_FRAMES: u64 = 15;
/// Half the width of the forearm, and its discs, close enough for an even ridge.
const FOREARM_RADIUS_MM: f64 = 17.0;
const FOREARM_DISCS: u32 = 12;
const FOREARM_STEP_MM: f64 = 8.0;
/// Rise of each disc; overlapping, they multiply to about 1.6 along the ridge.
const DISC_RISE: f64 = 0.15;

/// Every part of the pad is bound, so a false press shows.
const PROFILE: &str = r#"
schema = 1
name = "rest"
rest_area_mm2 = 500
region = [{ name = "left", x = 0, y = 0, w = 0.5, h = 1 }, { name = "right", x = 0.5, y = 0, w = 0.5, h = 1 }]
binding = [{ region = "left", output = "key:l" }, { region = "right", output = "key:r" }]
"#;

/// Discs along the left edge, slightly oblique.
fn forearm() -> Vec<Press> {
    (0..FOREARM_DISCS)
        .map(|index| Press {
            centre_mm: [
                15.0 + 0.3 * f64::from(index),
                6.0 + FOREARM_STEP_MM * f64::from(index),
            ],
            radius_mm: FOREARM_RADIUS_MM,
            rise: DISC_RISE,
        })
        .collect()
}

/// Noise-free readings, solved once for all seeds.
static SOLVED: Mutex<Vec<(Vec<Press>, Vec<f64>)>> = Mutex::new(Vec::new());

struct Bench {
    pad: SimulatedPad,
    engine: Engine,
    builder: SensingBuilder,
    noise: Noise,
    frame: u64,
    events: Vec<Event>,
}

impl Bench {
    fn new(seed: u64) -> Self {
        let shipped = shipped_pad(DEFAULT_PAD).expect("shipped");
        let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
        let table = gelpad::cache::load_or_solve(&pad, &|_, _| ()).expect("solvable");
        let builder = SensingBuilder::new(&pad, Method::default()).expect("sound");
        let builder = builder.with_table(Arc::new(table));
        let sensing = builder.build_initial().expect("a matrix");
        let profile = Profile::from_toml("rest", PROFILE).expect("sound");
        Self {
            pad: SimulatedPad::new(&pad).expect("solvable"),
            engine: Engine::new(&pad, Arc::new(sensing), Arc::new(profile)),
            builder,
            noise: Noise::new(SNR_DB, seed),
            frame: 0,
            events: Vec::new(),
        }
    }

    fn play(&mut self, fingers: &[Press], frames: u64) {
        let volts = self.volts(fingers);
        for _ in 0..frames {
            let frame = Frame {
                t_ns: self.frame * FRAME_NS,
                volts: self.noise.read(&volts),
            };
            self.engine.input(&Input::Frame(frame), &mut self.events);
            if let Some(deviations) = self.engine.wanted() {
                let sensing = self.builder.build(deviations).expect("a matrix");
                let input = Input::Matrix(Arc::new(sensing));
                self.engine.input(&input, &mut self.events);
            }
            self.frame += 1;
        }
    }

    fn volts(&self, fingers: &[Press]) -> Vec<f64> {
        let known = |solved: &[(Vec<Press>, Vec<f64>)]| {
            let found = solved.iter().find(|(of, _)| of == fingers);
            found.map(|(_, volts)| volts.clone())
        };
        let lock = || SOLVED.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(volts) = known(&lock()) {
            return volts;
        }
        let volts = self.pad.volts(fingers).expect("solved");
        lock().push((fingers.to_vec(), volts.clone()));
        volts
    }

    /// Taps on the right half beside resting fingers; returns the presses of each half.
    fn tap_beside(&mut self, lying: &[Press]) -> (usize, usize) {
        let before = self.events.len();
        for tap in 0..TAPS {
            let mut fingers = lying.to_vec();
            fingers.push(Press {
                centre_mm: [
                    68.0 + 6.0 * (tap % 5) as f64,
                    20.0 + 20.0 * (tap / 5) as f64,
                ],
                radius_mm: 7.0,
                rise: 1.2,
            });
            self.play(&fingers, TAP_FRAMES);
            self.play(lying, GAP_FRAMES);
        }
        let pressed = |name: &str| {
            let key = name.parse().expect("a key");
            let presses = self.events[before..].iter();
            presses
                .filter(|event| event.action == Action::Press(key))
                .count()
        };
        (pressed("key:r"), pressed("key:l"))
    }
}

#[test]
fn the_forearm_covers_a_third_of_the_pad() {
    let inside = (0..10_000)
        .filter(|i| {
            let [x, y] = [f64::from(i % 100) + 0.5, f64::from(i / 100) + 0.5];
            forearm().iter().any(|disc| {
                (x - disc.centre_mm[0]).hypot(y - disc.centre_mm[1]) <= FOREARM_RADIUS_MM
            })
        })
        .count();
    assert!((3000..3600).contains(&inside), "{inside} of 10000");
}

#[test]
fn only_the_taps_beside_a_forearm_press() {
    for seed in [1, 2, 3] {
        let mut bench = Bench::new(seed);
        bench.play(&[], 50);
        bench.play(&forearm(), 100);
        let (taps, false_presses) = bench.tap_beside(&forearm());
        println!("forearm added later, seed {seed}: {taps} of {TAPS} taps, {false_presses} false");
        assert_eq!((taps, false_presses), (TAPS, 0), "seed {seed}");
        let left = bench
            .events
            .iter()
            .filter(|event| matches!(event.action, Action::Press(_)))
            .count();
        assert_eq!(left, TAPS, "the forearm pressed something, seed {seed}");
    }
}

#[test]
fn a_forearm_that_rests_there_from_the_start_is_no_different() {
    for seed in [1, 2, 3] {
        let mut bench = Bench::new(seed);
        bench.play(&forearm(), 100);
        let (taps, false_presses) = bench.tap_beside(&forearm());
        println!(
            "forearm from the start, seed {seed}: {taps} of {TAPS} taps, {false_presses} false"
        );
        assert_eq!((taps, false_presses), (TAPS, 0), "seed {seed}");
        bench.play(&[], 200);
        let (taps, false_presses) = bench.tap_beside(&[]);
        println!("  after it has gone: {taps} of {TAPS} taps, {false_presses} false");
        assert_eq!(
            (taps, false_presses),
            (TAPS, 0),
            "seed {seed}, after it left"
        );
    }
}
