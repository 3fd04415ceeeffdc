//! Orientation of a pad, found from three presses of the simulated pad whose board numbers the electrodes differently.

use gelpad::calibrate::orientation::{
    GuidedPressRecorder, Orientation, OrientationError, OrientationSolver, Progress, shown_places,
    with_numbering,
};
use gelpad::eit::Press;
use gelpad::pad::{Direction, Numbering, Pad, shipped_pad};
use gelpad::source::{Noise, SimulatedPad};
use gelpad::types::Frame;

const FRAME_NS: u64 = 10_000_000;
/// Radius, mm, and rise of the conductivity: a light, a normal and a hard press.
const PRESSES: [(f64, f64); 3] = [(6.0, 0.6), (7.0, 1.2), (8.0, 2.5)];

fn text(name: &str) -> &'static str {
    shipped_pad(name).expect("shipped").toml
}

fn pad(text: &str) -> Pad {
    Pad::from_toml("pad", text).expect("sound")
}

/// The readings of presses that miss their targets by some millimetres, as the board numbers them.
struct Wired {
    pad: Pad,
    rest: Vec<f64>,
    /// By force, then by target.
    pressed: Vec<[Vec<f64>; 3]>,
}

impl Wired {
    fn new(text: &str, numbering: Numbering, scale: f64) -> Self {
        let pad = pad(&with_numbering(text, numbering).expect("a pad"));
        let simulated = SimulatedPad::new(&pad).expect("solvable");
        let places = shown_places(&pad.outline);
        let misses = [[3.0, -2.0], [-4.0, 1.0], [2.0, 4.0]];
        let press = |place: usize, (radius_mm, rise): (f64, f64)| {
            let centre_mm = [0, 1].map(|axis| places[place][axis] + scale * misses[place][axis]);
            let press = Press {
                centre_mm,
                radius_mm: scale * radius_mm,
                rise,
            };
            simulated.volts(&[press]).expect("solved")
        };
        Self {
            rest: simulated.volts(&[]).expect("solved"),
            pressed: PRESSES
                .iter()
                .map(|force| [0, 1, 2].map(|place| press(place, *force)))
                .collect(),
            pad,
        }
    }

    /// Frames of three presses of one force, recorded as in the wizard.
    fn take(
        &self,
        mut presses: GuidedPressRecorder,
        force: usize,
        snr_db: f64,
        seed: u64,
    ) -> Result<Orientation, OrientationError> {
        let mut noise = Noise::new(snr_db, seed);
        let mut t_ns = 0;
        let mut play = |volts: &Vec<f64>, frames: u64| {
            let mut last = Progress::Resting;
            for _ in 0..frames {
                last = presses.take_frame(&Frame {
                    t_ns,
                    volts: noise.read(volts),
                });
                t_ns += FRAME_NS;
            }
            last
        };
        play(&self.rest, 60);
        for volts in &self.pressed[force] {
            play(volts, 35);
            play(&self.rest, 40);
        }
        match play(&self.rest, 1) {
            Progress::Done(done) => done,
            other => panic!(
                "not done: {other:?} ({}, {snr_db} dB, force {force})",
                self.pad.name
            ),
        }
    }
}

/// Every numbering is found at every noise, force and seed.
fn all_found(
    text: &str,
    declared: Numbering,
    numberings: &[Numbering],
    snrs: &[f64],
    scale: f64,
) -> (f64, f64) {
    let orienter = OrientationSolver::new(&pad(&with_numbering(text, declared).expect("a pad")))
        .expect("solvable");
    let (mut least_fit, mut least_ratio) = (f64::INFINITY, f64::INFINITY);
    for numbering in numberings {
        let wired = Wired::new(text, *numbering, scale);
        for snr_db in snrs {
            for force in 0..PRESSES.len() {
                for seed in 1..=3 {
                    let found = wired
                        .take(
                            GuidedPressRecorder::new(orienter.clone()),
                            force,
                            *snr_db,
                            seed,
                        )
                        .unwrap_or_else(|error| {
                            panic!("{numbering:?}, {snr_db} dB, force {force}: {error}")
                        });
                    assert_eq!(found.numbering, *numbering, "{snr_db} dB, force {force}");
                    least_fit = least_fit.min(found.fit);
                    least_ratio = least_ratio.min((1.0 - found.next) / (1.0 - found.fit));
                }
            }
        }
    }
    println!(
        "{} numberings: fit at least {least_fit:.2}, next best leaves {least_ratio:.1} x as much",
        numberings.len()
    );
    (least_fit, least_ratio)
}

/// The rotations and reflections that map a square with four electrodes per side onto itself.
fn turns_and_mirrors() -> Vec<Numbering> {
    let of = |direction, first| Numbering { first, direction };
    [0, 4, 8, 12]
        .into_iter()
        .flat_map(|turn| {
            [
                of(Direction::CounterClockwise, turn),
                of(Direction::Clockwise, turn + 3),
            ]
        })
        .collect()
}

#[test]
fn four_rotations_and_two_reflections_of_the_papers_pad_are_found() {
    let text = text("edinburgh-lattice");
    all_found(
        text,
        Numbering::default(),
        &turns_and_mirrors(),
        &[60.0, 50.0, 40.0],
        1.0,
    );
}

#[test]
fn a_board_that_starts_in_the_middle_of_a_side_is_found() {
    let numberings = [
        Numbering {
            first: 1,
            direction: Direction::CounterClockwise,
        },
        Numbering {
            first: 6,
            direction: Direction::Clockwise,
        },
    ];
    all_found(
        text("edinburgh-lattice"),
        Numbering::default(),
        &numberings,
        &[50.0],
        1.0,
    );
}

#[test]
fn a_pad_set_up_for_another_board_is_corrected() {
    let declared = Numbering {
        first: 7,
        direction: Direction::Clockwise,
    };
    let wired = Numbering {
        first: 4,
        direction: Direction::CounterClockwise,
    };
    all_found(text("edinburgh-lattice"), declared, &[wired], &[60.0], 1.0);
}

#[test]
fn every_numbering_of_a_round_tank_is_found() {
    let numberings: Vec<Numbering> = Numbering::all(16).step_by(3).collect();
    all_found(
        text("round-tank"),
        Numbering::default(),
        &numberings,
        &[60.0],
        2.0,
    );
}

#[test]
fn opposite_drives_and_half_readings_work_too() {
    all_found(
        text("openeit-lattice"),
        Numbering::default(),
        &turns_and_mirrors()[2..6],
        &[60.0],
        1.0,
    );
    let half = text("edinburgh-lattice").replace("\"full\"", "\"half\"");
    all_found(
        &half,
        Numbering::default(),
        &turns_and_mirrors()[2..6],
        &[60.0],
        1.0,
    );
}

#[test]
fn presses_in_one_place_are_refused() {
    let text = text("edinburgh-lattice");
    let mut wired = Wired::new(text, Numbering::default(), 1.0);
    let orienter = OrientationSolver::new(&wired.pad).expect("solvable");
    let first = wired.pressed[1][0].clone();
    wired.pressed[1] = [first.clone(), first.clone(), first];
    let refused = wired.take(GuidedPressRecorder::new(orienter), 1, 60.0, 1);
    assert!(refused.is_err(), "{refused:?}");
}
