//! Electrodes that fail, a board that hangs, and one that is plugged in another way.

use gelpad::eit::Press;
use gelpad::pad::{Direction, Numbering, Renumbered, TouchSign};
use gelpad::types::{Contact, Frame, Phase, distance_mm};

use crate::bench::{Bench, FRAME_NS, finger, wild};

/// Hands that are played.
const HANDS: u64 = 80;

#[test]
fn an_electrode_that_is_off_at_the_start_is_excluded_and_reported() {
    let mut bench = Bench::located(60.0, 1);
    bench.board(
        7,
        |uses, channel, volt, frame| if uses { wild(channel, frame) } else { volt },
    );
    assert_eq!(bench.play(&[], 50), (0, 0));
    assert_eq!(bench.detector.lost_electrodes(), [7]);
    assert_eq!(bench.play(&[finger([60.0, 60.0], 7.0, 1.0)], 20), (1, 0));
    let [x, y] = bench.down()[0].contact.centre_mm;
    assert!((x - 60.0).hypot(y - 60.0) < 1.5, "({x:.1}, {y:.1})");
}

#[test]
fn an_electrode_that_is_off_at_the_start_counts_once_it_is_plugged_in() {
    type Read = fn(usize, u64) -> f32;
    let reads: [(&str, Read); 3] = [
        ("wild", wild),
        ("zero", |_, _| 0.0),
        ("the end of its range", |channel, frame| match frame {
            0..30 => wild(channel, frame),
            _ => 2.5,
        }),
    ];
    for (name, read) in reads {
        for lost in [&[7][..], &[0], &[3, 4], &[2, 13], &[3, 7], &[0, 8]] {
            let mut bench = Bench::located(60.0, 1);
            let protocol = bench.pad.protocol.clone();
            let uses = |channel: &gelpad::pad::Channel| {
                let pairs = [channel.drive, channel.measure];
                pairs
                    .iter()
                    .any(|pair| lost.contains(&pair.0) || lost.contains(&pair.1))
            };
            let is_lost: Vec<bool> = protocol.channels.iter().map(uses).collect();
            bench.board = Box::new(move |channel, volt, frame| match is_lost[channel] {
                true => read(channel, frame),
                false => volt,
            });
            bench.play(&[], 50);
            assert_eq!(bench.detector.lost_electrodes(), lost, "{name}");
            assert_eq!(bench.play(&[], 300), (0, 0), "{name}, {lost:?}");
            assert_eq!(bench.detector.lost_electrodes(), lost, "{name}: still off");
            bench.board = Box::new(|_, volt, _| volt);
            bench.play(&[], 250);
            let now = bench.detector.lost_electrodes();
            assert!(now.is_empty(), "{name}, {lost:?}: {now:?} stay lost");
            assert!(bench.detector.muted_channels().is_empty());
            // A finger beside the electrode that was lost.
            assert_eq!(bench.play(&[finger([12.0, 60.0], 7.0, 1.0)], 40), (1, 0));
            let [x, y] = bench.down()[0].contact.centre_mm;
            assert!((x - 12.0).hypot(y - 60.0) < 1.0, "({x:.1}, {y:.1})");
            assert_eq!(bench.play(&[], 60), (0, 1), "{name}, {lost:?}");
        }
    }
}

#[test]
fn a_loose_electrode_is_excluded_during_a_touch_and_recovers() {
    for electrode in [0, 5, 10, 15] {
        let mut bench = Bench::located(60.0, 2);
        assert_eq!(bench.play(&[], 100), (0, 0));
        let held = finger([35.0, 45.0], 7.0, 1.0);
        assert_eq!(bench.play(&[held], 50), (1, 0));
        bench.board(
            electrode,
            |uses, channel, volt, frame| {
                if uses { wild(channel, frame) } else { volt }
            },
        );
        assert_eq!(
            bench.play(&[held], 100),
            (0, 0),
            "electrode {electrode}: play goes on"
        );
        assert_eq!(bench.detector.lost_electrodes(), [electrode]);
        bench.board = Box::new(|_, volt, _| volt);
        assert_eq!(bench.play(&[held], 100), (0, 0));
        assert!(
            bench.detector.lost_electrodes().is_empty(),
            "electrode {electrode} recovered"
        );
        assert_eq!(bench.play(&[], 100), (0, 1));
    }
}

#[test]
fn a_pad_without_a_table_excludes_a_lost_electrode_and_takes_it_back() {
    let mut bench = Bench::without_table(60.0, 2);
    assert_eq!(bench.play(&[], 100), (0, 0));
    let held = finger([35.0, 45.0], 7.0, 1.0);
    assert_eq!(bench.play(&[held], 50), (1, 0));
    bench.board(
        5,
        |uses, channel, volt, frame| if uses { wild(channel, frame) } else { volt },
    );
    assert_eq!(bench.play(&[held], 100), (0, 0), "play goes on");
    assert_eq!(bench.detector.lost_electrodes(), [5]);
    assert_eq!(bench.play(&[], 50), (0, 1));
    bench.board = Box::new(|_, volt, _| volt);
    assert_eq!(bench.play(&[], 100), (0, 0));
    assert!(bench.detector.lost_electrodes().is_empty(), "recovered");
    assert_eq!(bench.play(&[held], 50), (1, 0));
}

#[test]
fn a_noisy_electrode_makes_no_touch() {
    let mut bench = Bench::located(60.0, 2);
    assert_eq!(bench.play(&[], 100), (0, 0));
    // Thirty times the noise of the others.
    bench.board(4, |uses, channel, volt, frame| {
        volt * if uses {
            1.0 + 0.05 * wild(channel, frame)
        } else {
            1.0
        }
    });
    assert_eq!(bench.play(&[], 1000), (0, 0));
    assert_eq!(bench.play(&[finger([60.0, 30.0], 7.0, 1.0)], 50), (1, 0));
    assert_eq!(bench.play(&[], 50), (0, 1));
}

#[test]
fn a_short_between_neighbours_makes_no_touch_and_play_goes_on() {
    let mut bench = Bench::located(60.0, 2);
    assert_eq!(bench.play(&[], 100), (0, 0));
    let protocol = bench.pad.protocol.clone();
    // Drives and measurements between 8 and 9 read almost zero.
    bench.board = Box::new(move |channel, volt, _| {
        let pairs = [
            protocol.channels[channel].drive,
            protocol.channels[channel].measure,
        ];
        if pairs.iter().any(|pair| [pair.0, pair.1] == [8, 9]) {
            1e-4 * volt
        } else {
            volt
        }
    });
    assert_eq!(bench.play(&[], 300), (0, 0));
    let lost = bench.detector.lost_electrodes();
    assert!(
        !lost.is_empty() && lost.iter().all(|e| [8, 9].contains(e)),
        "{lost:?}"
    );
    assert_eq!(bench.play(&[finger([30.0, 50.0], 7.0, 1.0)], 50), (1, 0));
}

#[test]
fn a_pad_that_bends_is_followed_while_two_electrodes_are_lost() {
    const SEEDS: u64 = 8;
    let mut all = 0;
    for seed in 1..=SEEDS {
        let mut bench = Bench::located(60.0, seed);
        assert_eq!(bench.play(&[], 100), (0, 0));
        // Wider than any finger.
        let volts = |fingers: &[Press]| bench.simulated.volts(fingers).expect("solvable");
        let bent = volts(&[finger([20.0, 90.0], 90.0, 0.01)]);
        let bends: Vec<f32> = bent
            .iter()
            .zip(volts(&[]))
            .map(|(bent, rest)| (bent / rest - 1.0) as f32)
            .collect();
        let is_lost: Vec<bool> = bench
            .pad
            .protocol
            .channels
            .iter()
            .map(|channel| {
                let pairs = [channel.drive, channel.measure];
                pairs
                    .iter()
                    .any(|pair| [8, 9].contains(&pair.0) || [8, 9].contains(&pair.1))
            })
            .collect();
        bench.board = Box::new(move |channel, volt, frame| {
            // Back and forth in three seconds.
            let share = (std::f32::consts::TAU * frame as f32 / 300.0).sin();
            match is_lost[channel] {
                true => wild(channel, frame),
                false => volt * (1.0 + share * bends[channel]),
            }
        });
        all += bench.play(&[], 3000).0;
    }
    // Some five in half a minute; a bend that is not followed makes dozens.
    assert!(all <= 8 * SEEDS as usize, "{all} touches");
}

#[test]
fn a_board_that_repeats_one_frame_holds_no_touch() {
    let mut bench = Bench::located(60.0, 8);
    bench.play(&[], 200);
    let press = [finger([40.0, 60.0], 7.0, 1.2)];
    assert_eq!(bench.play(&press, 30), (1, 0));
    // It hangs: the noise of one frame comes again and again.
    let volts = bench.simulated.volts(&press).expect("solvable");
    let volts = bench.noise.read(&volts);
    let mut changed = Vec::new();
    for _ in 0..27 {
        let t_ns = bench.frame * FRAME_NS;
        let frame = Frame {
            t_ns,
            volts: volts.clone(),
        };
        bench.detector.process_frame(&frame, &mut changed);
        bench.frame += 1;
    }
    assert!(changed.iter().any(|touch| touch.phase == Phase::Up));
    assert!(bench.down().is_empty(), "released within 270 ms");
    assert_eq!(bench.detector.hangs(), 1);
    // It wakes: the finger is still there, then lifts.
    assert_eq!(bench.play(&press, 20), (1, 0));
    assert_eq!(bench.play(&[], 50), (0, 1));
}

/// Plays frames of a pad that differs from its drawing by up to 2 % a reading, sent by a board with another numbering.
fn play_turned(bench: &mut Bench, numbering: Numbering, press: &[Press], frames: u64) -> usize {
    let order = Renumbered::new(&bench.pad.protocol, numbering).expect("a symmetric protocol");
    let mut changed = Vec::new();
    for _ in 0..frames {
        let mut volts = bench.simulated.volts(press).expect("solvable");
        for (channel, volt) in volts.iter_mut().enumerate() {
            *volt *= 1.0 + 0.02 * (channel as f64 * 1.7).sin();
        }
        let frame = Frame {
            t_ns: bench.frame * FRAME_NS,
            volts: order.apply(&bench.noise.read(&volts)),
        };
        bench.detector.process_frame(&frame, &mut changed);
        bench.frame += 1;
    }
    let downs = changed.iter().filter(|touch| touch.phase == Phase::Down);
    downs.count()
}

#[test]
fn a_board_that_is_plugged_in_turned_or_mirrored_is_recognised() {
    let press = [finger([30.0, 60.0], 7.0, 1.2)];
    let mut bench = Bench::located(60.0, 9);
    play_turned(&mut bench, Numbering::default(), &[], 100);
    let numberings = [
        (4, Direction::CounterClockwise),
        (0, Direction::Clockwise),
        (7, Direction::CounterClockwise),
        (0, Direction::CounterClockwise),
    ];
    for (changes, (first, direction)) in numberings.into_iter().enumerate() {
        let numbering = Numbering { first, direction };
        assert_eq!(
            play_turned(&mut bench, numbering, &[], 20),
            0,
            "{numbering}"
        );
        assert_eq!(bench.detector.board_numbering().1, changes as u64 + 1);
        // Play goes on at the places of the pad.
        assert_eq!(
            play_turned(&mut bench, numbering, &press, 10),
            1,
            "{numbering}"
        );
        let [x, y] = bench.down()[0].contact.centre_mm;
        assert!(
            (x - 30.0).hypot(y - 60.0) < 1.0,
            "{numbering}: ({x:.1}, {y:.1})"
        );
        play_turned(&mut bench, numbering, &[], 30);
        assert!(bench.down().is_empty(), "{numbering}");
    }
    assert_eq!(bench.detector.board_numbering().0, Numbering::default());
}

/// The finger under which the reference was taken is at about the mirrored place next, as if the board were plugged in mirrored.
#[test]
fn a_finger_that_jumps_to_a_mirrored_place_is_no_mirrored_board() {
    for off_mm in [1.0, 2.0, 3.0] {
        let mut bench = Bench::located(60.0, 10);
        bench.play(&[finger([30.0, 60.0], 7.0, 1.2)], 60);
        bench.play(&[finger([70.0, 60.0 + off_mm], 7.0, 1.2)], 60);
        bench.play(&[], 50);
        assert_eq!(bench.detector.board_numbering().1, 0, "{off_mm} mm off");
        play_once_more(&mut bench);
    }
}

#[test]
fn a_finger_that_lies_there_at_the_start_and_slides_away_leaves_no_ghost() {
    // At 450 and 75 mm/s.
    for (seed, steps) in (1..=20).flat_map(|seed| [(seed, 10), (seed, 60)]) {
        let mut bench = Bench::located(60.0, seed);
        bench.play(&[finger([30.0, 60.0], 7.0, 1.2)], 60);
        for step in 0..steps {
            let x_mm = 30.0 + 45.0 * f64::from(step) / f64::from(steps);
            bench.play(&[finger([x_mm, 60.0 - 0.3 * x_mm], 7.0, 1.2)], 1);
        }
        bench.play(&[], 50);
        assert_eq!(
            bench.detector.touches_down(),
            [],
            "seed {seed}, {steps} steps"
        );
        play_once_more(&mut bench);
    }
}

#[test]
fn a_press_right_after_the_lift_of_a_finger_that_lay_there_at_the_start_is_one_press() {
    for frames_between in [4, 6, 8, 10, 12] {
        for place_mm in [[13.0, 55.0], [67.0, 80.0], [80.0, 20.0]] {
            let mut bench = Bench::located(60.0, 11);
            let resting = finger([37.0, 55.0], 7.0, 1.2);
            // A press beside it shows the sign of touches.
            for fingers in [vec![], vec![finger([80.0, 48.0], 7.0, 1.2)], vec![]] {
                bench.play(&[vec![resting], fingers].concat(), 60);
            }
            bench.play(&[], frames_between);
            let press = bench.play(&[finger(place_mm, 7.0, 1.2)], 50);
            let after = bench.play(&[], 200);
            let what = format!("{frames_between} frames later at {place_mm:?}");
            assert_eq!((press, after), ((1, 0), (0, 1)), "{what}");
        }
    }
}

/// The first press of a session, which may look like the lift of a finger of the other sign: a very wide finger, two close together, or the
/// heel of a hand.
#[test]
fn a_first_press_that_looks_like_a_lift_leaves_no_ghost() {
    let mut retaken = 0;
    for x_mm in [30.0, 45.0, 60.0] {
        for y_mm in [35.0, 50.0, 70.0] {
            let wide = vec![finger([x_mm, y_mm], 15.0, 1.2)];
            let close = [-6.0, 6.0]
                .map(|off_mm| finger([x_mm + off_mm, y_mm], 7.0, 1.2))
                .to_vec();
            let heel = [-12.0, 12.0]
                .map(|off_mm| finger([x_mm + off_mm, y_mm], 14.0, 1.2))
                .to_vec();
            // The press ends before, while and after the new reference is taken.
            for (fingers, frames) in [
                (&wide, 12),
                (&wide, 10),
                (&wide, 11),
                (&close, 12),
                (&close, 10),
                (&close, 11),
                (&heel, 12),
                (&heel, 10),
                (&heel, 11),
            ] {
                let mut bench = Bench::located(60.0, 12);
                bench.play(&[], 400);
                bench.play(fingers, frames);
                bench.play(&[], 50);
                retaken += bench.detector.references_retaken();
                play_once_more(&mut bench);
            }
        }
    }
    assert!(retaken > 0, "some are taken for a lift at first");
}

/// Over a hole of the lattice a narrow finger touches little of the gel on either side, which looks like the lift of a long one of the
/// other sign.
#[test]
fn a_first_narrow_finger_does_not_turn_the_sign() {
    for x_mm in [21.0, 36.0, 50.0, 64.0, 79.0] {
        for off_mm in [-1.5, 0.0, 1.5] {
            let mut bench = Bench::located(60.0, 12);
            bench.play(&[], 400);
            let at_rest = bench.detector.references_retaken();
            bench.play(&[finger([x_mm + off_mm, 50.0], 3.0, 2.0)], 10);
            bench.play(&[], 20);
            let what = format!("at {} mm", x_mm + off_mm);
            assert_eq!(bench.detector.touch_sign(), TouchSign::Rise, "{what}");
            assert_eq!(bench.detector.references_retaken(), at_rest, "{what}");
            assert_eq!(bench.down(), [], "{what}");
        }
    }
}

/// A fist, or metal: far more than the table's strongest touch, which the fit must not run away from.
#[test]
fn presses_far_stronger_than_any_finger_are_touches_and_lift() {
    let mut bench = Bench::located(60.0, 4);
    bench.play(&[], 400);
    for place_mm in [[50.0, 50.0], [3.0, 60.0], [97.0, 96.0], [30.0, 79.0]] {
        for radius_mm in [3.0, 7.0, 15.0] {
            for rise in [8.0, 40.0, 1000.0] {
                bench.play(&[finger(place_mm, radius_mm, rise)], 12);
                for touch in bench.down() {
                    let Contact {
                        centre_mm: [x, y],
                        force,
                        ..
                    } = touch.contact;
                    let is_on_pad = [x, y].iter().all(|at| (0.0..=100.0).contains(at));
                    assert!(is_on_pad && (0.0..=1.0).contains(&force), "{touch:?}");
                }
                bench.play(&[], 50);
                let what = format!("{place_mm:?}, radius {radius_mm} mm, rise {rise}");
                assert_eq!(bench.down(), [], "{what}");
            }
        }
    }
    play_once_more(&mut bench);
}

/// Fingers that land together beside each other, in little noise, where each is fitted again from other sizes: none of them ends on
/// another.
#[test]
fn fingers_that_land_together_stay_apart() {
    const LEAST_MM: f64 = 12.5;
    for snr_db in [60.0, 80.0] {
        let mut bench = Bench::located(snr_db, 6);
        bench.play(&[], 400);
        for hand in 0..60 {
            let number = |index: usize| f64::from(wild(index, 900 + hand));
            let middle_mm = [0, 1].map(|axis| 50.0 + 28.0 * number(axis));
            let far_mm = 9.0 + 3.0 * number(2);
            let fingers: Vec<_> = (0..2 + hand as usize % 3)
                .map(|index| {
                    let angle = 2.1 * index as f64 + 3.0 * number(3);
                    let place_mm = [
                        middle_mm[0] + far_mm * angle.cos(),
                        middle_mm[1] + far_mm * angle.sin(),
                    ];
                    let radius_mm = 6.5 + 2.0 * number(4 + index);
                    finger(place_mm, radius_mm, 1.2 + 0.7 * number(8 + index))
                })
                .collect();
            bench.play(&fingers, 1);
            let down = bench.down();
            for (index, touch) in down.iter().enumerate() {
                for other in &down[..index] {
                    let [a, b] = [touch, other].map(|touch| touch.contact.centre_mm);
                    let apart_mm = distance_mm(a, b);
                    assert!(apart_mm > LEAST_MM - 0.5, "hand {hand}: {a:?}, {b:?}");
                }
            }
            bench.play(&fingers, 11);
            bench.play(&[], 50);
            assert_eq!(bench.down(), [], "hand {hand}: {fingers:?}");
        }
    }
}

/// Palms, heels, forearms: up to four wide fingers, which may overlap. Each search ends, and half a second after the lift nothing is down.
#[test]
fn hands_of_any_width_leave_nothing_down() {
    const SEED: u64 = 2;
    let mut bench = Bench::located(60.0, SEED);
    bench.play(&[], 400);
    for hand in 0..HANDS {
        let number = |index: usize| f64::from(wild(index, SEED * HANDS + hand));
        let fingers: Vec<_> = (0..1 + hand as usize % 4)
            .map(|index| {
                let centre_mm = [0, 1].map(|axis| 50.0 + 50.0 * number(4 * index + axis));
                let radius_mm = 15.0 + 7.0 * number(4 * index + 2);
                finger(centre_mm, radius_mm, 1.6 + 1.4 * number(4 * index + 3))
            })
            .collect();
        bench.play(&fingers, 12);
        bench.play(&[], 50);
        assert_eq!(bench.down(), [], "hand {hand}: {fingers:?}");
    }
}

/// Nothing is down, and another press is found in its place.
fn play_once_more(bench: &mut Bench) {
    assert_eq!(bench.down(), []);
    assert_eq!(bench.play(&[finger([40.0, 25.0], 7.0, 1.2)], 20).0, 1);
    let [x, y] = bench.down()[0].contact.centre_mm;
    assert!((x - 40.0).hypot(y - 25.0) < 1.0, "({x:.1}, {y:.1})");
    bench.play(&[], 50);
    assert_eq!(bench.down(), []);
}
