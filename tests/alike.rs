//! Noise that is the same on all channels, on a pad of many electrodes: the smallest of its 928 readings are below the noise. They once made
//! the detector take its reference again and again, in which every touch was missed.

use std::sync::Arc;

use gelpad::cache;
use gelpad::eit::Press;
use gelpad::pad::{Pad, Pair, shipped_pad};
use gelpad::source::SimulatedPad;
use gelpad::touch::Detector;
use gelpad::types::{Frame, Method, Nanos};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const FRAME_NS: Nanos = 10_000_000;
const REST_FRAMES: usize = 200;
/// Standard deviation of the noise, as a share of the largest reading: 60 dB.
const NOISE: f64 = 1e-3;
const WITHIN_MM: f64 = 3.0;

fn pad() -> Pad {
    let text = shipped_pad("edinburgh-solid").expect("shipped").toml;
    let text = text
        .replace("count = 16", "count = 32")
        .replace("width_mm = 3.0", "width_mm = 2.5");
    Pad::from_toml("solid with 32 electrodes", &text).expect("valid")
}

#[test]
fn touches_are_found_in_the_first_frame_and_rest_makes_none() {
    let pad = pad();
    let builder = cache::sensing_builder(&pad, Method::Noser, |_, _| ()).expect("solvable");
    let first = Arc::new(builder.build_initial().expect("a matrix"));
    let simulated = SimulatedPad::new(&pad).expect("solvable");
    let press = Press {
        centre_mm: [35.0, 60.0],
        radius_mm: 8.0,
        rise: 1.5,
    };
    let rest = simulated.volts(&[]).expect("solved");
    let pressed = simulated.volts(&[press]).expect("solved");
    let largest = rest.iter().fold(0.0f64, |most, volt| most.max(volt.abs()));
    for seed in 1..=10 {
        let mut draw = ChaCha8Rng::seed_from_u64(seed);
        let mut detector = Detector::for_pad(Arc::clone(&first), &pad.protocol);
        let mut changed = Vec::new();
        for index in 0..=REST_FRAMES {
            let volts = if index < REST_FRAMES { &rest } else { &pressed };
            let noisy = volts.iter().map(|volt| {
                let noise: f64 = StandardNormal.sample(&mut draw);
                (volt + NOISE * largest * noise) as f32
            });
            let frame = Frame {
                t_ns: index as Nanos * FRAME_NS,
                volts: noisy.collect(),
            };
            assert!(changed.is_empty(), "seed {seed}: {changed:?}");
            detector.process_frame(&frame, &mut changed);
            if let Some(wanted) = detector.wanted() {
                let sensing = builder.build(wanted).expect("a matrix");
                detector.set_sensing(Arc::new(sensing));
            }
        }
        assert_eq!(detector.references_retaken(), 0, "seed {seed}");
        assert!(detector.lost_electrodes().is_empty(), "seed {seed}");
        let [touch] = detector.touches_down() else {
            panic!("seed {seed}: {:?}", detector.touches_down());
        };
        let [x, y] = touch.contact.centre_mm;
        let off_mm = (x - press.centre_mm[0]).hypot(y - press.centre_mm[1]);
        assert!(off_mm < WITHIN_MM, "seed {seed}: {off_mm:.2} mm off");
    }
}

/// Readings that are left out as below the noise must not hide that an electrode is lost, nor make it look as if others were.
#[test]
fn an_electrode_that_is_lost_in_more_noise_is_found_and_makes_no_touch() {
    const LOST: usize = 5;
    let pad = pad();
    let builder = cache::sensing_builder(&pad, Method::Noser, |_, _| ()).expect("solvable");
    let first = Arc::new(builder.build_initial().expect("a matrix"));
    let rest = SimulatedPad::new(&pad)
        .expect("solvable")
        .volts(&[])
        .expect("solved");
    let largest = rest.iter().fold(0.0f64, |most, volt| most.max(volt.abs()));
    let lost = Pair(LOST, LOST);
    let is_open: Vec<bool> = pad
        .protocol
        .channels
        .iter()
        .map(|channel| {
            channel.drive.shares_electrode(lost) || channel.measure.shares_electrode(lost)
        })
        .collect();
    let mut draw = ChaCha8Rng::seed_from_u64(1);
    let mut detector = Detector::for_pad(first, &pad.protocol);
    let mut changed = Vec::new();
    for index in 0..REST_FRAMES {
        let is_lost = index >= REST_FRAMES / 2;
        let volts = rest.iter().zip(&is_open).map(|(volt, is_open)| {
            let noise: f64 = StandardNormal.sample(&mut draw);
            let volt = if is_lost && *is_open { 0.0 } else { *volt };
            (volt + 3.0 * NOISE * largest * noise) as f32
        });
        let frame = Frame {
            t_ns: index as Nanos * FRAME_NS,
            volts: volts.collect(),
        };
        detector.process_frame(&frame, &mut changed);
        if let Some(wanted) = detector.wanted() {
            let sensing = builder.build(wanted).expect("a matrix");
            detector.set_sensing(Arc::new(sensing));
        }
        assert!(changed.is_empty(), "frame {index}: {changed:?}");
        assert!(
            is_lost || detector.lost_electrodes().is_empty(),
            "frame {index}"
        );
    }
    assert_eq!(detector.lost_electrodes(), [LOST]);
}

/// A board whose cable is off, or with far too little gain: nearly all readings are below the noise.
#[test]
fn a_board_that_reads_little_but_noise_makes_no_touch() {
    let pad = pad();
    let builder = cache::sensing_builder(&pad, Method::Noser, |_, _| ()).expect("solvable");
    let first = Arc::new(builder.build_initial().expect("a matrix"));
    let simulated = SimulatedPad::new(&pad).expect("solvable");
    let rest = simulated.volts(&[]).expect("solved");
    let largest = rest.iter().fold(0.0f64, |most, volt| most.max(volt.abs()));
    for share in [0.03, 1.0] {
        let mut draw = ChaCha8Rng::seed_from_u64(1);
        let mut detector = Detector::for_pad(Arc::clone(&first), &pad.protocol);
        let mut changed = Vec::new();
        for index in 0..REST_FRAMES {
            let volts = rest.iter().map(|volt| {
                let noise: f64 = StandardNormal.sample(&mut draw);
                (volt + share * largest * noise) as f32
            });
            let frame = Frame {
                t_ns: index as Nanos * FRAME_NS,
                volts: volts.collect(),
            };
            detector.process_frame(&frame, &mut changed);
            // Without any channel there is no matrix; as in play, the present one stays.
            if let Some(Ok(sensing)) = detector.wanted().map(|wanted| builder.build(wanted)) {
                detector.set_sensing(Arc::new(sensing));
            }
            assert!(changed.is_empty(), "{share}, frame {index}: {changed:?}");
        }
    }
}
