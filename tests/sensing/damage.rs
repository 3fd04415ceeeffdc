//! Frames that a board damages: they are neither touches nor a lift, and nothing is learned from them.

use crate::bench::{Bench, finger};

const PLACES_MM: [[f64; 2]; 3] = [[40.0, 60.0], [62.0, 35.0], [75.0, 60.0]];

/// Each press is one press, at the place of the finger, and nothing else is seen.
fn each_press_is_one(bench: &mut Bench, case: &str) {
    for place in PLACES_MM {
        let press = [finger(place, 7.0, 1.2)];
        assert_eq!(bench.play(&press, 15), (1, 0), "{case}: {place:?} pressed");
        let [x, y] = bench.down()[0].contact.centre_mm;
        let off_mm = (x - place[0]).hypot(y - place[1]);
        assert!(off_mm < 1.0, "{case}: {place:?} found {off_mm:.2} mm off");
        assert_eq!(bench.play(&[], 50), (0, 1), "{case}: {place:?} lifted");
    }
}

/// For some frames from now on, each channel shows the reading of the channel `by` places further on.
fn slip(bench: &mut Bench, by: usize, frames: u64, rest: &[f64]) {
    let from = bench.frame;
    let count = rest.len();
    let ratios: Vec<f32> = (0..count)
        .map(|channel| (rest[(channel + by) % count] / rest[channel]) as f32)
        .collect();
    bench.board = Box::new(move |channel, volt, frame| {
        let is_slipped = (from..from + frames).contains(&frame);
        volt * if is_slipped { ratios[channel] } else { 1.0 }
    });
}

/// When a byte is lost on the way, every reading arrives one channel too early or too late, until the board starts its next frame. Before the
/// first touch of a session, such frames look a little like a finger that lifts, and the sound frames after them like its return.
#[test]
fn readings_that_slip_by_a_channel_decide_nothing() {
    for by in [1, 13, 207] {
        for frames in [5, 100] {
            for is_held in [false, true] {
                let case = format!("slipped by {by} for {frames} frames, held {is_held}");
                let mut bench = Bench::located(60.0, 5);
                bench.play(&[], 200);
                let press = [finger(PLACES_MM[0], 7.0, 1.2)];
                let fingers: &[_] = if is_held { &press } else { &[] };
                let (downs, _) = bench.play(fingers, 30);
                assert_eq!(downs, usize::from(is_held), "{case}");
                let volts = bench.simulated.volts(fingers).expect("solvable");
                slip(&mut bench, by, frames, &volts);
                let (more, _) = bench.play(fingers, frames);
                let (late, _) = bench.play(&[], 50);
                assert_eq!((more, late), (0, 0), "{case}: nothing new");
                assert!(bench.down().is_empty(), "{case}: nothing stays down");
                each_press_is_one(&mut bench, &case);
            }
        }
    }
}

/// A gain that is set too high: the largest readings do not follow a touch beside their electrodes.
#[test]
fn readings_at_the_end_of_the_converters_range_make_no_second_touch() {
    for step in [0.0, 1.0 / 2048.0] {
        for share in [0.95, 0.8, 0.5] {
            let case = format!("cut at {share} of the largest, in steps of {step}");
            let mut bench = Bench::located(60.0, 1);
            let rest = bench.simulated.volts(&[]).expect("solvable");
            let largest = rest.iter().fold(0.0_f64, |most, volt| most.max(volt.abs()));
            let (most, step) = ((share * largest) as f32, (step * largest) as f32);
            bench.board = Box::new(move |_, volt, _| {
                let cut = volt.clamp(-most, most);
                if step > 0.0 {
                    (cut / step).round() * step
                } else {
                    cut
                }
            });
            assert_eq!(bench.play(&[], 300), (0, 0), "{case}: at rest");
            assert!(!bench.detector.muted_channels().is_empty(), "{case}");
            each_press_is_one(&mut bench, &case);
        }
    }
}
