//! A fast slide on a board whose drives are read in turn: the touch is where the finger is, not where its frame began.

use gelpad::eit::Press;
use gelpad::engine::Input;
use gelpad::source::{Noise, SimulatedPad};
use gelpad::types::{Nanos, Part, PointMm, Touch};

use super::board::pad;
use super::play::{builder, engine};

const DRIVES: usize = 16;
/// 100 frames a second.
const PART_NS: Nanos = 625_000;
const MM_PER_S: f64 = 300.0;
/// Parts before the finger lands, while it slides and after it has lifted.
const PARTS: [usize; 3] = [480, 280, 160];
/// A finger lands at rest: its velocity is known some frames later.
const SETTLED_PARTS: usize = 80;

/// Lag along the way at each part, mm, and the touches that were seen.
fn slide(seed: u64, from_mm: PointMm, direction: [f64; 2]) -> (Vec<f64>, Vec<u64>) {
    let pad = pad("edinburgh-lattice");
    let simulated = SimulatedPad::new(&pad).expect("solvable");
    let untouched = simulated.volts(&[]).expect("solvable");
    let builder = builder(&pad);
    let mut engine = engine(&pad, &builder);
    let mut noise = Noise::new(60.0, seed);
    let per_drive = pad.channels() / DRIVES;
    let (mut lags_mm, mut ids) = (Vec::new(), Vec::new());
    for index in 0..PARTS.iter().sum() {
        let pressed = index.checked_sub(PARTS[0]).filter(|part| *part < PARTS[1]);
        let at_mm = |part: usize| {
            let way_mm = MM_PER_S * part as f64 * PART_NS as f64 * 1e-9;
            [0, 1].map(|k| from_mm[k] + way_mm * direction[k])
        };
        let volts = pressed.map(|part| {
            let centre_mm = at_mm(part);
            let press = Press {
                centre_mm,
                radius_mm: 7.0,
                rise: 1.2,
            };
            simulated.volts(&[press]).expect("solvable")
        });
        let volts = volts.as_ref().unwrap_or(&untouched);
        let first = index % DRIVES * per_drive;
        let part = Part {
            t_ns: (index as Nanos + 1) * PART_NS,
            first,
            volts: noise.read(&volts[first..first + per_drive]),
        };
        engine.input(&Input::Part(part), &mut Vec::new());
        let down: &[Touch] = engine.touches_down();
        for touch in down {
            if !ids.contains(&touch.id.0) {
                ids.push(touch.id.0);
            }
        }
        if let (Some(part), Some(touch)) = (pressed, down.first())
            && part > SETTLED_PARTS
        {
            let finger_mm = at_mm(part);
            let [x, y] = touch.contact.centre_mm;
            lags_mm.push(direction[0] * (finger_mm[0] - x) + direction[1] * (finger_mm[1] - y));
        }
    }
    assert!(engine.touches_down().is_empty(), "it has lifted");
    (lags_mm, ids)
}

#[test]
fn slides_at_300_mm_per_s_hardly_lag() {
    let mut all_mm = Vec::new();
    for (seed, from_mm, direction) in [
        (1, [20.0, 30.0], [1.0, 0.0]),
        (2, [75.0, 80.0], [0.0, -1.0]),
        (3, [75.0, 25.0], [-0.6, 0.8]),
    ] {
        let (lags_mm, ids) = slide(seed, from_mm, direction);
        let held = PARTS[1] - SETTLED_PARTS - 1;
        assert_eq!(lags_mm.len(), held, "held all the way");
        assert_eq!(ids.len(), 1, "one finger is one touch: {ids:?}");
        let furthest_mm = lags_mm.iter().fold(0.0f64, |most, lag| most.max(lag.abs()));
        assert!(furthest_mm < 3.0, "{furthest_mm:.1} mm off");
        all_mm.extend(lags_mm);
    }
    let mean_mm = all_mm.iter().sum::<f64>() / all_mm.len() as f64;
    assert!(mean_mm.abs() < 0.3, "{mean_mm:.2} mm behind");
}
