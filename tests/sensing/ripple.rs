//! A source that goes up and down with the mains: read a hundred times a second, a ripple of 50.07 Hz changes its sign with each frame,
//! and one of 60.03 Hz takes five values in turn. And a gain that steps once.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use gelpad::cache;
use gelpad::eit::{Press, SharedNoiseEstimator};
use gelpad::pad::{Pad, shipped_pad};
use gelpad::source::{Noise, SimulatedPad};
use gelpad::types::Method;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Uniform};

use crate::bench::{Bench, FRAME_NS, finger};

/// Frequencies of the mains, Hz.
const MAINS_HZ: [f64; 2] = [50.07, 60.03];
/// Share of each reading by which it goes up and down.
const SHARE: f64 = 0.003;

/// A source that wavers, and how its board reads.
#[derive(Clone, Copy, Debug)]
struct Ripple {
    mains_hz: f64,
    order: Order,
}

/// The order in which a board reads.
#[derive(Clone, Copy, Debug)]
enum Order {
    AllAtOnce,
    DriveAfterDrive,
}

/// Plays on the solid pad and on the lattice, on boards that read in either order, with noise of each seed and the mains of Europe and America
/// in turn. `play` also gets the name of the case.
fn on_each_board(seeds: RangeInclusive<u64>, play: impl Fn(&mut Bench, Ripple, &str)) {
    let text = shipped_pad("edinburgh-solid").expect("shipped").toml;
    let solid = Pad::from_toml("edinburgh-solid", text).expect("valid");
    let builder = cache::sensing_builder(&solid, Method::Tikhonov, |_, _| ()).expect("solvable");
    for (seed, mains_hz) in seeds.zip(MAINS_HZ.into_iter().cycle()) {
        for order in [Order::AllAtOnce, Order::DriveAfterDrive] {
            let ripple = Ripple { mains_hz, order };
            let solid = Bench::of_pad(solid.clone(), builder.clone(), 60.0, seed);
            for mut bench in [solid, Bench::located(60.0, seed)] {
                let case = format!("{}, {ripple:?}, seed {seed}", bench.pad.name);
                play(&mut bench, ripple, &case);
            }
        }
    }
}

/// Seconds from the start of a frame to the reading of each channel: drives share nine tenths of the frame.
fn read_s(pad: &Pad, order: Order) -> Vec<f64> {
    let drives = pad.protocol.drives();
    let count = drives.iter().max().map_or(1, |last| last + 1);
    let drive_s = match order {
        Order::AllAtOnce => 0.0,
        Order::DriveAfterDrive => 0.9e-9 * FRAME_NS as f64 / f64::from(count),
    };
    drives
        .iter()
        .map(|drive| drive_s * f64::from(*drive))
        .collect()
}

/// From the next frame on, and from `phase` (in turns) on, the source wavers.
fn waver(bench: &mut Bench, ripple: Ripple, phase: f64) {
    let read_s = read_s(&bench.pad, ripple.order);
    let from = bench.frame;
    bench.board = Box::new(move |channel, volt, frame| {
        let t_s = ((frame - from) * FRAME_NS) as f64 * 1e-9 + read_s[channel];
        let turns = ripple.mains_hz * t_s + phase;
        (f64::from(volt) * (1.0 + SHARE * (TAU * turns).sin())) as f32
    });
}

fn a_press_is_seen(bench: &mut Bench, case: &str) {
    let press = [finger([40.0, 60.0], 7.0, 1.2)];
    assert_eq!(bench.play(&press, 15), (1, 0), "{case}: pressed");
    assert_eq!(bench.play(&[], 100), (0, 1), "{case}: lifted");
}

/// From a moment on in which it is nothing. That of 50.07 Hz grows for three seconds: each frame alone looks like a pad that bends further.
#[test]
fn a_ripple_that_grows_makes_no_touch() {
    on_each_board(1..=4, |bench, ripple, case| {
        waver(bench, ripple, 0.0);
        assert_eq!(bench.play(&[], 1000), (0, 0), "{case}");
        a_press_is_seen(bench, case);
    });
}

/// A charger is plugged in while nobody touches the pad.
#[test]
fn a_ripple_that_begins_at_once_makes_no_touch() {
    on_each_board(5..=8, |bench, ripple, case| {
        bench.play(&[], 300);
        waver(bench, ripple, 0.25);
        assert_eq!(bench.play(&[], 400), (0, 0), "{case}");
        a_press_is_seen(bench, case);
    });
}

/// A charger is plugged in while a finger is held.
#[test]
fn a_ripple_that_begins_under_a_finger_neither_lifts_it_nor_adds_others() {
    on_each_board(9..=12, |bench, ripple, case| {
        bench.play(&[], 200);
        let press = [finger([62.0, 35.0], 7.0, 1.2)];
        assert_eq!(bench.play(&press, 50), (1, 0), "{case}: pressed");
        waver(bench, ripple, 0.25);
        assert_eq!(bench.play(&press, 400), (0, 0), "{case}: held");
        assert_eq!(bench.play(&[], 300), (0, 1), "{case}: lifted");
        a_press_is_seen(bench, case);
    });
}

/// The gain of the board steps, too little to be taken for another board, and stays there; a finger lands soon after, or is held meanwhile.
#[test]
fn a_small_step_of_the_gain_makes_no_touch_and_hides_none() {
    on_each_board(13..=14, |bench, _, case| {
        for (step, frames) in [(0.003, 1), (-0.006, 5), (0.01, 30), (-0.01, 200)] {
            bench.board = Box::new(|_, volt, _| volt);
            bench.play(&[], 600);
            bench.board = Box::new(move |_, volt, _| volt * (1.0 + step));
            let case = format!("{case}, step {step}, pressed after {frames} frames");
            assert_eq!(bench.play(&[], frames), (0, 0), "{case}");
            a_press_is_seen(bench, &case);
        }
        let press = [finger([62.0, 35.0], 7.0, 1.2)];
        assert_eq!(bench.play(&press, 50), (1, 0), "{case}: pressed");
        bench.board = Box::new(|_, volt, _| volt);
        assert_eq!(bench.play(&press, 50), (0, 0), "{case}: held");
        assert_eq!(bench.play(&[], 100), (0, 1), "{case}: lifted");
    });
}

/// A wide, light finger in the middle of a pad with opposite drives, or over the width of a strip, changes all readings alike.
#[test]
fn a_finger_that_looks_like_a_gain_is_seen() {
    let openeit = shipped_pad("openeit-lattice").expect("shipped").toml;
    let strip = include_str!("../data/recordings/strip-pad.toml");
    for (name, text) in [("openeit-lattice", openeit), ("strip", strip)] {
        let pad = Pad::from_toml(name, text).expect("valid");
        let middle_mm = pad.outline.size_mm().map(|side| side / 2.0);
        let builder = cache::sensing_builder(&pad, Method::Tikhonov, |_, _| ()).expect("solvable");
        let mut bench = Bench::of_pad(pad, builder, 60.0, 13);
        assert_eq!(bench.play(&[], 100), (0, 0), "{name}: rest");
        let press = [finger(middle_mm, 9.0, 0.3)];
        assert_eq!(bench.play(&press, 20), (1, 0), "{name}: pressed");
        assert_eq!(bench.play(&[], 60), (0, 1), "{name}: lifted");
    }
}

/// Elsewhere what fingers change is not taken for gains of the source, of the whole board or of its drives.
#[test]
fn gains_explain_no_touch() {
    const DEVIATION: f64 = 1e-3;
    let draws = match std::env::var_os("GELPAD_FULL") {
        Some(_) => 400,
        None => 60,
    };
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let mut between = |least: f64, most: f64| {
        Uniform::new(least, most)
            .expect("a range")
            .sample(&mut random)
    };
    for name in ["edinburgh-lattice", "edinburgh-solid", "round-tank"] {
        let text = shipped_pad(name).expect("shipped").toml;
        let pad = Pad::from_toml(name, text).expect("valid");
        let [width_mm, height_mm] = pad.outline.size_mm();
        let simulated = SimulatedPad::new(&pad).expect("solvable");
        let mut estimator = SharedNoiseEstimator::new(pad.protocol.drives());
        let rest = simulated.volts(&[]).expect("solvable");
        let mut noise = Noise::new(60.0, 11);
        for draw in 0..draws {
            let presses: Vec<Press> = (0..=draw % 3)
                .map(|_| {
                    let centre_mm = [between(0.0, width_mm), between(0.0, height_mm)];
                    finger(centre_mm, between(3.0, 15.0), between(-2.5, 0.7).exp())
                })
                .collect();
            let read = noise.read(&simulated.volts(&presses).expect("solvable"));
            let change = |channel: usize| f64::from(read[channel]) / rest[channel] - 1.0;
            let is_explained = estimator.explains_frame(
                |channel| Some((change(channel), DEVIATION * DEVIATION)),
                false,
            );
            assert!(!is_explained, "{name}: {presses:?}");
        }
    }
}
