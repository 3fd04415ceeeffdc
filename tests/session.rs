//! super-mario on a recorded session (tests/data/lattice-presses): a left hand that holds, a right hand with
//! short and long presses. Every short press is a short jump, every long press a long jump, and there are no
//! others.

use std::fs;
use std::process::Command;

use serde::Deserialize;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/lattice-presses");
/// Longest delay from a press to its key: the touch grows for a frame or two.
const LATE_MS: f64 = 30.0;
/// Largest difference between the lengths of key and touch.
const OFF_MS: f64 = 30.0;
/// Separates the session's short presses (80 to 150 ms) from its long ones (400 to 700 ms).
const LONG_MS: f64 = 250.0;
/// Five and 32 frames of the NES: the lengths of the classified profile.
const SHORT_LATCH_MS: f64 = 83.196;
const LONG_LATCH_MS: f64 = 532.456;

#[derive(Deserialize)]
struct Truth {
    t0: f64,
    t1: f64,
    kind: String,
}

/// Right-hand presses: start and length, ms.
fn presses() -> Vec<(f64, f64)> {
    fs::read_to_string(format!("{DATA}/session.truth.jsonl"))
        .expect("truth")
        .lines()
        .map(|line| serde_json::from_str(line).expect("a press a line"))
        .filter(|truth: &Truth| truth.kind != "hold")
        .map(|truth| (truth.t0 * 1e3, (truth.t1 - truth.t0) * 1e3))
        .collect()
}

/// Presses of the jump key as the command prints them: start and length, ms.
fn jumps(profile: &str) -> Vec<(f64, f64)> {
    let output = Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .args(["replay", "--profile", profile])
        .arg(format!("{DATA}/session.csv"))
        .output()
        .expect("started");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let mut jumps: Vec<(f64, f64)> = Vec::new();
    for line in String::from_utf8(output.stdout).expect("text").lines() {
        let (t_ms, event) = line.split_once(' ').expect("a time");
        let t_ms: f64 = t_ms.parse().expect("a number");
        match event {
            "press key:f" => jumps.push((t_ms, f64::NAN)),
            "release key:f" => {
                let jump = jumps.last_mut().expect("a press before");
                jump.1 = t_ms - jump.0;
            }
            _ => {}
        }
    }
    jumps
}

/// Checks that each press has one jump, in time; returns the lengths of press and jump.
fn matched(profile: &str) -> Vec<(f64, f64)> {
    let (presses, jumps) = (presses(), jumps(profile));
    assert_eq!(jumps.len(), presses.len(), "{profile}: one jump a press");
    presses
        .iter()
        .zip(&jumps)
        .map(|((press_ms, press_length), (jump_ms, jump_length))| {
            let late = jump_ms - press_ms;
            assert!(
                (0.0..=LATE_MS).contains(&late),
                "{profile}: {late} ms late at {press_ms}"
            );
            (*press_length, *jump_length)
        })
        .collect()
}

#[test]
fn in_the_direct_mode_length_is_length() {
    let lengths = matched("super-mario");
    let worst = lengths
        .iter()
        .map(|(press, jump)| (press - jump).abs())
        .fold(0.0, f64::max);
    println!(
        "{} jumps, at worst {worst:.0} ms off in length",
        lengths.len()
    );
    assert!(worst <= OFF_MS, "{worst} ms off");
    assert!(
        lengths
            .iter()
            .all(|(press, jump)| (*press < LONG_MS) == (*jump < LONG_MS))
    );
}

#[test]
fn in_the_classified_mode_there_are_two_lengths() {
    for (press, jump) in matched("super-mario-classified") {
        if press < LONG_MS {
            assert!(
                (SHORT_LATCH_MS - 0.01..LONG_MS).contains(&jump),
                "a short press of {press} ms jumped {jump} ms"
            );
        } else {
            assert!(
                (jump - LONG_LATCH_MS).abs() < 0.01,
                "a long press of {press} ms jumped {jump} ms"
            );
        }
    }
}
