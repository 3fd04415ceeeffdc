//! Presses on the simulated pad over time, detected in images and in the voltages.
//!
//! Ten minutes of drift are played at the worst rate; with `GELPAD_FULL=1` at other rates too.

#[path = "sensing/bench.rs"]
mod bench;
#[path = "sensing/bending.rs"]
mod bending;
#[path = "sensing/damage.rs"]
mod damage;
#[path = "sensing/faults.rs"]
mod faults;
#[path = "sensing/held.rs"]
mod held;
mod lattice;
#[path = "sensing/ripple.rs"]
mod ripple;

use bench::{Bench, FRAMES_PER_MINUTE, finger};
use gelpad::pad::{Pad, TouchSign};
use gelpad::source::SimulatedPad;

#[test]
fn a_press_held_for_a_minute_after_the_start_stays_one_press_in_images() {
    for seed in [1, 7] {
        let mut bench = Bench::by_image(60.0, seed);
        assert_eq!(bench.play(&[], 20), (0, 0));
        let press = finger([80.0, 50.0], 7.0, 1.2);
        assert_eq!(
            bench.play(&[press], FRAMES_PER_MINUTE),
            (1, 0),
            "seed {seed}"
        );
        let after = bench.play(&[], 500);
        assert_eq!(after, (0, 1), "seed {seed}: no ghost");
    }
}

#[test]
fn a_press_held_for_ten_minutes_of_drift_stays_a_press_in_its_place() {
    let rates: &[f32] = match std::env::var_os("GELPAD_FULL") {
        Some(_) => &[-2.0, 0.0, 1.0],
        None => &[-2.0],
    };
    for &percent_per_minute in rates {
        let mut bench = Bench::located(60.0, 3);
        bench.board = Box::new(move |_, volt, frame| {
            let minutes = frame as f32 / FRAMES_PER_MINUTE as f32;
            volt * (1.0 + 0.01 * percent_per_minute * minutes)
        });
        assert_eq!(bench.play(&[], 200), (0, 0));
        let press = finger([70.0, 40.0], 7.0, 1.0);
        let (downs, ups) = bench.play(&[press], 10 * FRAMES_PER_MINUTE);
        assert_eq!((downs, ups), (1, 0), "{percent_per_minute} % per minute");
        let [x, y] = bench.down()[0].contact.centre_mm;
        let off_mm = (x - 70.0).hypot(y - 40.0);
        println!("{percent_per_minute} % per minute: {off_mm:.2} mm off after ten minutes");
        assert!(
            off_mm < 3.0,
            "{percent_per_minute} % per minute: ({x:.1}, {y:.1})"
        );
        let after = bench.play(&[], 500);
        assert_eq!(after, (0, 1), "{percent_per_minute} % per minute: no ghost");
    }
}

#[test]
fn a_finger_that_was_down_at_the_start_leaves_no_ghost() {
    for seed in [1, 2, 3] {
        for mut bench in [Bench::by_image(60.0, seed), Bench::located(60.0, seed)] {
            let early = finger([80.0, 30.0], 7.0, 1.2);
            bench.play(&[early], 30);
            assert_eq!(bench.play(&[], 300), (0, 0), "seed {seed}");
            assert_eq!(bench.detector.references_retaken(), 1);
            let press = finger([20.0, 50.0], 7.0, 1.2);
            assert_eq!(bench.play(&[press], 20), (1, 0));
            assert_eq!(bench.play(&[], 300), (0, 1));
        }
    }
}

/// The pad's text says that touches conduct better, and they conduct worse.
#[test]
fn touches_of_the_other_sign_are_seen_from_the_first_on_and_leave_no_ghost() {
    let mut bench = Bench::located(60.0, 5);
    let falling = Pad {
        touch_sign: TouchSign::Fall,
        ..bench.pad.clone()
    };
    bench.simulated = SimulatedPad::new(&falling).expect("solvable");
    bench.play(&[], 300);
    for place in [[30.0, 62.0], [71.0, 33.0], [50.0, 50.0], [99.0, 40.0]] {
        assert_eq!(
            bench.play(&[finger(place, 7.0, 1.0)], 30),
            (1, 0),
            "{place:?}"
        );
        let [x, y] = bench.down()[0].contact.centre_mm;
        assert!((x - place[0]).hypot(y - place[1]) < 2.0, "{x} {y}");
        assert_eq!(bench.play(&[], 60), (0, 1), "{place:?}");
    }
    // Now the sign is known: a finger that lay on the pad is a lift, not a touch.
    bench.detector.rezero(&mut Vec::new());
    bench.play(&[finger([40.0, 40.0], 7.0, 1.0)], 50);
    assert_eq!(bench.play(&[], 60), (0, 0));
}

/// A finger that lay there, one of either sign, at any time: no touch is left when nothing is on the pad.
#[test]
fn a_lift_before_the_first_touch_leaves_no_ghost() {
    for (seed, frames) in [(1, 60), (2, 150), (3, 400), (4, 1000)] {
        let mut bench = Bench::located(60.0, seed);
        bench.play(&[finger([34.0, 57.0], 7.5, 1.2)], frames);
        bench.play(&[], 100);
        bench.play(&[finger([70.0, 30.0], 7.0, 1.0)], 20);
        let [x, y] = bench.down()[0].contact.centre_mm;
        assert!((x - 70.0).hypot(y - 30.0) < 2.0, "{x} {y}");
        assert_eq!(bench.down().len(), 1, "after {frames} frames");
        bench.play(&[], 60);
        assert_eq!(bench.down(), [], "after {frames} frames");
    }
}

#[test]
fn a_finger_at_the_edge_is_placed_and_leaves_no_ghost() {
    let mut bench = Bench::located(60.0, 6);
    bench.play(&[], 200);
    for place in [
        [0.5, 62.0],
        [99.5, 33.0],
        [57.0, 0.0],
        [44.0, 99.0],
        [1.5, 98.5],
    ] {
        assert_eq!(
            bench.play(&[finger(place, 7.0, 1.2)], 30),
            (1, 0),
            "{place:?}"
        );
        let [x, y] = bench.down()[0].contact.centre_mm;
        assert!((x - place[0]).hypot(y - place[1]) < 2.5, "{x} {y}");
        assert_eq!(bench.play(&[], 60), (0, 1), "{place:?}");
    }
}

#[test]
fn five_fingers_are_five_and_no_palm() {
    let mut bench = Bench::located(60.0, 7);
    bench.play(&[], 200);
    let places = [
        [20.0, 30.0],
        [38.0, 62.0],
        [55.0, 78.0],
        [78.0, 62.0],
        [60.0, 25.0],
    ];
    let hand = places.map(|place| finger(place, 6.5, 1.0));
    // No two fingers land at the same time.
    for count in 1..=hand.len() {
        assert_eq!(bench.play(&hand[..count], 3), (1, 0), "finger {count}");
    }
    assert_eq!(bench.play(&hand, 100), (0, 0));
    assert_eq!(bench.play(&[], 60), (0, 5));
}

#[test]
fn a_hard_press_does_not_lift_a_light_one() {
    for mut bench in [Bench::by_image(60.0, 1), Bench::located(60.0, 1)] {
        bench.play(&[], 50);
        let light = finger([13.0, 57.0], 6.0, 0.3);
        let hard = finger([80.0, 50.0], 9.0, 3.0);
        assert_eq!(bench.play(&[light], 50), (1, 0));
        assert_eq!(bench.play(&[light, hard], 50), (1, 0));
        assert_eq!(bench.play(&[light], 50), (0, 1));
        assert_eq!(bench.play(&[], 50), (0, 1));
    }
}

#[test]
fn force_grows_with_the_press() {
    let mut bench = Bench::located(60.0, 1);
    bench.play(&[], 50);
    let mut last = 0.0;
    for rise in [0.3, 0.6, 1.0, 1.5] {
        bench.play(&[finger([40.0, 60.0], 7.0, rise)], 20);
        let force = bench.down()[0].contact.force;
        assert!(force > 1.2 * last, "{force} after {last}");
        last = force;
    }
}

#[test]
fn a_rezeroed_pad_counts_as_untouched_as_it_is() {
    let mut bench = Bench::located(60.0, 1);
    bench.play(&[], 50);
    let stuck = finger([30.0, 30.0], 7.0, 1.0);
    assert_eq!(bench.play(&[stuck], 50), (1, 0));
    let mut changed = Vec::new();
    bench.detector.rezero(&mut changed);
    assert_eq!(changed.len(), 1, "the touch goes up");
    assert_eq!(bench.play(&[stuck], 200), (0, 0));
    let other = finger([75.0, 60.0], 7.0, 1.0);
    assert_eq!(bench.play(&[stuck, other], 20), (1, 0));
}

#[test]
fn a_held_finger_is_placed_by_all_its_frames() {
    let mut bench = Bench::located(40.0, 9);
    bench.play(&[], 400);
    let (mut first, mut held) = (0.0, 0.0);
    let places = [[30.0, 35.0], [62.0, 44.0], [48.0, 71.0], [75.0, 25.0]];
    for round in 0..40 {
        let place = places[round % places.len()];
        let off_mm = |bench: &Bench| {
            let [x, y] = bench.down()[0].contact.centre_mm;
            (x - place[0]).hypot(y - place[1]) / 40.0
        };
        bench.play(&[finger(place, 7.0, 1.2)], 1);
        first += off_mm(&bench);
        bench.play(&[finger(place, 7.0, 1.2)], 9);
        held += off_mm(&bench);
        bench.play(&[], 20);
    }
    assert!(held < 0.65 * first, "{held:.2} of {first:.2} mm");
}

#[test]
fn a_fast_slide_is_one_touch_and_keeps_up() {
    let mut bench = Bench::located(60.0, 11);
    bench.play(&[], 200);
    let at = |frame: usize| [20.0 + 6.0 * frame as f64, 30.0 + 4.0 * frame as f64];
    let mut downs = 0;
    for frame in 0..10 {
        let (down, up) = bench.play(&[finger(at(frame), 7.0, 1.2)], 1);
        downs += down;
        assert_eq!(up, 0, "frame {frame}");
        let [x, y] = bench.down()[0].contact.centre_mm;
        let off_mm = (x - at(frame)[0]).hypot(y - at(frame)[1]);
        assert!(off_mm < 2.0, "frame {frame}: {off_mm} mm");
    }
    assert_eq!(downs, 1);
    assert_eq!(bench.play(&[], 60), (0, 1));
}

#[test]
fn a_finger_in_a_corner_has_a_place() {
    let mut bench = Bench::located(60.0, 12);
    bench.play(&[], 200);
    for place in [[0.5, 0.8], [99.4, 0.3], [1.0, 99.5], [99.0, 98.9]] {
        bench.play(&[finger(place, 8.0, 1.2)], 10);
        let [x, y] = bench.down()[0].contact.centre_mm;
        assert!((x - place[0]).hypot(y - place[1]) < 6.0, "{x} {y}");
        bench.play(&[], 60);
    }
}

#[test]
fn a_board_that_stalls_during_a_slide_keeps_the_finger_that_has_stopped() {
    let mut bench = Bench::located(60.0, 13);
    bench.play(&[], 200);
    let at = |frame: usize| [20.0 + 4.0 * frame as f64, 50.0];
    for frame in 0..8 {
        bench.play(&[finger(at(frame), 7.0, 1.2)], 1);
    }
    // Half a second without frames: at its speed the finger would have left the pad.
    bench.frame += 50;
    let rest = at(8);
    assert_eq!(bench.play(&[finger(rest, 7.0, 1.2)], 10), (0, 0));
    let [x, y] = bench.down()[0].contact.centre_mm;
    assert!((x - rest[0]).hypot(y - rest[1]) < 1.0, "{x} {y}");
    assert_eq!(bench.play(&[], 60), (0, 1));
}
