//! Touches found in the frames of an independent simulator (tests/data/lattice-presses), 60 dB noise added.

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use gelpad::eit::{Method, REFERENCE_FRAMES, Reconstruction};
use gelpad::pad::{DEFAULT_PAD, Pad, shipped_pad};
use gelpad::source::Noise;
use gelpad::touch::Detector;
use gelpad::types::Frame;
use serde::Deserialize;

const SNR_DB: f64 = 60.0;
const FOUND_MM: f64 = 10.0;
const SEEDS: [u64; 3] = [1, 2, 3];

#[derive(Deserialize)]
struct Truth {
    touches: Vec<TrueTouch>,
}

#[derive(Deserialize)]
struct TrueTouch {
    x_mm: f64,
    y_mm: f64,
}

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/lattice-presses")
        .join(name)
}

fn frames() -> Vec<Vec<f64>> {
    csv::Reader::from_path(data("static.csv"))
        .expect("static.csv")
        .deserialize()
        .map(|row| {
            let row: Vec<f64> = row.expect("numbers");
            row[1..].to_vec()
        })
        .collect()
}

fn truths() -> Vec<Truth> {
    fs::read_to_string(data("static.truth.jsonl"))
        .expect("truth")
        .lines()
        .map(|line| serde_json::from_str(line).expect("a truth a line"))
        .collect()
}

/// What a method made of all frames with a number of touches.
#[derive(Default)]
struct Score {
    frames: usize,
    /// Every true touch has a contact within [`FOUND_MM`].
    found: usize,
    /// As many contacts as touches.
    counted_right: usize,
    errors_mm: Vec<f64>,
}

impl Score {
    fn mean_mm(&self) -> f64 {
        self.errors_mm.iter().sum::<f64>() / self.errors_mm.len() as f64
    }
}

/// Scores for one, two and three touches. Errors are taken where the count is right.
fn scores(method: Method, seed: u64) -> [Score; 3] {
    let pad = shipped_pad(DEFAULT_PAD).expect("shipped");
    let pad = Pad::from_toml(pad.name, pad.toml).expect("sound");
    let matrix = Arc::new(Reconstruction::of_pad(&pad, method).expect("a matrix"));
    let frames = frames();
    let mut noise = Noise::new(SNR_DB, seed);
    let mut rested = Detector::new(matrix);
    let mut none = Vec::new();
    for _ in 0..REFERENCE_FRAMES {
        let volts = noise.read(&frames[0]);
        rested.frame(&Frame { t_ns: 0, volts }, &mut none);
    }
    let mut scores: [Score; 3] = Default::default();
    for (volts, truth) in frames.iter().zip(truths()).skip(1) {
        let mut detector = rested.clone();
        let volts = noise.read(volts);
        detector.frame(&Frame { t_ns: 0, volts }, &mut none);
        let score = &mut scores[truth.touches.len() - 1];
        score.frames += 1;
        let contacts = detector.state().down;
        let errors_mm = truth.touches.iter().map(|touch| {
            contacts
                .iter()
                .map(|c| (c.contact.centre_mm[0] - touch.x_mm).hypot(c.contact.centre_mm[1] - touch.y_mm))
                .fold(f64::INFINITY, f64::min)
        });
        let errors_mm: Vec<f64> = errors_mm.collect();
        score.found += usize::from(errors_mm.iter().all(|error| *error < FOUND_MM));
        if contacts.len() == truth.touches.len() {
            score.counted_right += 1;
            score.errors_mm.extend(errors_mm);
        }
    }
    scores
}

fn report(method: Method, seed: u64) -> [Score; 3] {
    let scores = scores(method, seed);
    for (touches, score) in scores.iter().enumerate() {
        println!(
            "{} seed {seed}, {} touches: found {}, counted right {} of {}, mean error {:.2} mm",
            method.name(),
            touches + 1,
            score.found,
            score.counted_right,
            score.frames,
            score.mean_mm()
        );
    }
    scores
}

#[test]
fn tikhonov_finds_every_single_touch_within_two_millimetres() {
    for seed in SEEDS {
        let [one, _, _] = report(Method::Tikhonov, seed);
        assert_eq!((one.found, one.frames), (100, 100));
        assert!(one.mean_mm() <= 2.0);
    }
}

#[test]
fn noser_finds_every_single_touch_within_one_and_a_half_and_counts_two() {
    for seed in SEEDS {
        let [one, two, _] = report(Method::Noser, seed);
        assert_eq!((one.found, one.frames), (100, 100));
        assert!(one.mean_mm() <= 1.5);
        assert!(two.counted_right >= 95 && two.frames == 100);
    }
}
