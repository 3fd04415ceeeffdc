//! Fingers that are held, or nearly: they are placed by the mean of their frames, which must not outlive what it was made of.

use crate::bench::{Bench, finger, wild};

/// How far the touch that is down is from a place, mm.
fn off_mm(bench: &Bench, [x, y]: [f64; 2]) -> f64 {
    let at = bench.down()[0].contact.centre_mm;
    (at[0] - x).hypot(at[1] - y)
}

/// How far a finger that slides at a speed is found behind its place, mm: the mean over slides, without their first frames.
fn lag_mm(mm_per_s: f64, snr_db: f64) -> f64 {
    const FRAMES: usize = 30;
    const FIRST: usize = 8;
    let mut bench = Bench::located(snr_db, 14);
    bench.play(&[], 200);
    let starts = [[30.0, 35.0], [62.0, 44.0], [48.0, 61.0], [55.0, 25.0]];
    let mut behind_mm = 0.0;
    for (index, start) in starts.iter().enumerate() {
        let angle = 0.7 + 1.6 * index as f64;
        let direction = [angle.cos(), angle.sin()];
        for frame in 0..FRAMES {
            let along_mm = 0.01 * mm_per_s * frame as f64;
            let place = [0, 1].map(|k| start[k] + along_mm * direction[k]);
            bench.play(&[finger(place, 7.0, 1.2)], 1);
            if frame >= FIRST {
                let [x, y] = bench.down()[0].contact.centre_mm;
                behind_mm += (place[0] - x) * direction[0] + (place[1] - y) * direction[1];
            }
        }
        bench.play(&[], 60);
    }
    behind_mm / (starts.len() * (FRAMES - FIRST)) as f64
}

#[test]
fn a_slow_finger_is_not_found_behind_its_place() {
    for (mm_per_s, snr_db, most_mm) in [
        (5.0, 60.0, 0.25),
        (10.0, 60.0, 0.25),
        (20.0, 60.0, 0.25),
        (40.0, 60.0, 0.25),
        (20.0, 40.0, 1.0),
        (60.0, 40.0, 1.0),
    ] {
        let behind_mm = lag_mm(mm_per_s, snr_db);
        println!("{mm_per_s} mm/s at {snr_db} dB: {behind_mm:.2} mm behind");
        assert!(behind_mm < most_mm, "{mm_per_s} mm/s: {behind_mm} mm");
    }
}

#[test]
fn an_electrode_that_is_lost_does_not_move_a_held_finger() {
    let place = [35.0, 45.0];
    for electrode in [0, 5, 10, 15] {
        let mut bench = Bench::located(60.0, 2);
        bench.play(&[], 100);
        let held = finger(place, 7.0, 1.0);
        bench.play(&[held], 50);
        bench.board(
            electrode,
            |uses, channel, volt, frame| {
                if uses { wild(channel, frame) } else { volt }
            },
        );
        for frame in 0..30 {
            bench.play(&[held], 1);
            let off_mm = off_mm(&bench, place);
            assert!(
                off_mm < 1.0,
                "electrode {electrode}, frame {frame}: {off_mm} mm"
            );
        }
    }
}

#[test]
fn a_damaged_frame_does_not_move_a_held_finger() {
    let place = [62.0, 44.0];
    for size in [0.02, 0.1, 0.3, 1.0, 5.0] {
        let mut bench = Bench::located(60.0, 3);
        bench.play(&[], 200);
        let held = finger(place, 7.0, 1.0);
        bench.play(&[held], 20);
        let damaged = bench.frame;
        bench.board = Box::new(move |channel, volt, frame| match frame == damaged {
            true => volt * (1.0 + size * wild(channel, frame)),
            false => volt,
        });
        for frame in 0..15 {
            bench.play(&[held], 1);
            let off_mm = off_mm(&bench, place);
            assert!(
                frame == 0 || off_mm < 0.5,
                "{size}, {frame} frames after it: {off_mm} mm"
            );
        }
    }
}
