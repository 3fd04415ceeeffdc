//! Touches found in the frames of an independent simulator (tests/data/lattice-presses), 60 dB noise added.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::sync::Arc;

use gelpad::eit::{REFERENCE_FRAMES, Reconstruction};
use gelpad::pad::{DEFAULT_PAD, Pad, shipped_pad};
use gelpad::source::Noise;
use gelpad::touch::Detector;
use gelpad::types::{Frame, Method};
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
                .map(|c| {
                    (c.contact.centre_mm[0] - touch.x_mm).hypot(c.contact.centre_mm[1] - touch.y_mm)
                })
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

/// A press of the session's truth, s and mm.
#[derive(Deserialize)]
struct Press {
    t0: f64,
    t1: f64,
    x: f64,
    y: f64,
    kind: String,
}

#[derive(Deserialize)]
struct Line {
    t_ms: f64,
    touches: Vec<Seen>,
}

#[derive(Deserialize)]
struct Seen {
    id: u64,
    x_mm: f64,
    y_mm: f64,
}

/// A touch as the command prints it, from its first frame to its last.
struct Track {
    first_ms: f64,
    last_ms: f64,
    seen: usize,
    sum_mm: [f64; 2],
}

const FRAME_MS: f64 = 10.0;

/// What `gelpad replay session.csv --print touches` tells, by touch.
fn tracks() -> BTreeMap<u64, Track> {
    let output = Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .args(["replay", "--pad", DEFAULT_PAD, "--print", "touches"])
        .arg(data("session.csv"))
        .output()
        .expect("started");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let mut tracks = BTreeMap::new();
    for line in String::from_utf8(output.stdout).expect("text").lines() {
        let line: Line = serde_json::from_str(line).expect("a JSON line");
        for seen in line.touches {
            let track = tracks.entry(seen.id).or_insert(Track {
                first_ms: line.t_ms,
                last_ms: line.t_ms,
                seen: 0,
                sum_mm: [0.0; 2],
            });
            track.last_ms = line.t_ms;
            track.seen += 1;
            track.sum_mm[0] += seen.x_mm;
            track.sum_mm[1] += seen.y_mm;
        }
    }
    tracks
}

#[test]
fn every_press_of_the_session_is_one_touch_and_nothing_else_is() {
    let presses: Vec<Press> = fs::read_to_string(data("session.truth.jsonl"))
        .expect("truth")
        .lines()
        .map(|line| serde_json::from_str(line).expect("a press a line"))
        .collect();
    let mut tracks = tracks();
    assert_eq!(tracks.len(), presses.len(), "as many touches as presses");
    let (mut worst_down_ms, mut worst_length_ms, mut worst_mm) = (0.0f64, 0.0f64, 0.0f64);
    for press in &presses {
        let (t0_ms, t1_ms) = (press.t0 * 1e3, press.t1 * 1e3);
        let error_mm = |track: &Track| {
            let [x, y] = track.sum_mm.map(|sum| sum / track.seen as f64);
            (x - press.x).hypot(y - press.y)
        };
        let id = tracks
            .iter()
            .filter(|(_, track)| {
                (track.first_ms - t0_ms).abs() <= 50.0 && error_mm(track) < FOUND_MM
            })
            .map(|(id, _)| *id)
            .next();
        let id =
            id.unwrap_or_else(|| panic!("the {} press at {t0_ms} ms is not found", press.kind));
        let track = tracks.remove(&id).expect("just found");
        let frames = ((track.last_ms - track.first_ms) / FRAME_MS).round() as usize + 1;
        assert_eq!(track.seen, frames, "the touch at {t0_ms} ms has no hole");
        let down_ms = track.first_ms - t0_ms;
        let length_ms = track.last_ms + FRAME_MS - track.first_ms - (t1_ms - t0_ms);
        assert!(
            (0.0..=30.0).contains(&down_ms),
            "down {down_ms} ms after {t0_ms}"
        );
        assert!(
            length_ms.abs() <= 30.0,
            "{length_ms} ms too long at {t0_ms}"
        );
        worst_down_ms = worst_down_ms.max(down_ms);
        worst_length_ms = worst_length_ms.max(length_ms.abs());
        worst_mm = worst_mm.max(error_mm(&track));
    }
    println!(
        "{} presses; at worst down {worst_down_ms:.0} ms late, {worst_length_ms:.0} ms off in length, {worst_mm:.1} mm off",
        presses.len()
    );
}
