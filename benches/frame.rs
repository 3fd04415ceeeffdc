//! Set-up of the shipped pad to its first image, one frame to its events, and one part of a frame to its events.
//!
//! Criterion prints medians; the 99th percentile is printed too, because the worst frames are felt.

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use gelpad::cache;
use gelpad::calibrate::{ModelPrediction, Press as CalibrationPress, Presses, learn_maps};
use gelpad::eit::{Press, REFERENCE_FRAMES};
use gelpad::engine::{Engine, Input};
use gelpad::pad::{DEFAULT_PAD, Pad, shipped_pad};
use gelpad::profile::{DEFAULT_PROFILE, Profile, shipped_profile};
use gelpad::source::{FramesCsv, Noise, PartSplitter, SimulatedPad, Source, SourceReading};
use gelpad::touch::Detector;
use gelpad::types::{Frame, Method};

fn pad() -> Pad {
    let shipped = shipped_pad(DEFAULT_PAD).expect("shipped");
    Pad::from_toml(shipped.name, shipped.toml).expect("sound")
}

fn profile() -> Arc<Profile> {
    let shipped = shipped_profile(DEFAULT_PROFILE).expect("shipped");
    Arc::new(Profile::from_toml(shipped.name, shipped.toml).expect("sound"))
}

/// The 3000 frames of the session that the tests use: holds, taps, drift, 60 dB of noise.
fn frames(pad: &Pad) -> Vec<Frame> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/lattice-presses/session.csv");
    let mut session = FramesCsv::open(&path, pad.channels()).expect("the session");
    let mut frames = Vec::new();
    while let SourceReading::Frame(frame) = session.read().expect("a frame") {
        frames.push(frame);
    }
    frames
}

#[allow(clippy::disallowed_methods, reason = "a benchmark reads the clock")]
fn now() -> Instant {
    Instant::now()
}

fn set_up(criterion: &mut Criterion) {
    let pad = pad();
    let frames = frames(&pad);
    // The first call solves the response table, later calls load it.
    cache::sensing_builder(&pad, Method::default(), |_, _| ()).expect("solvable");
    criterion.bench_function("set-up to first image, responses cached", |bencher| {
        bencher.iter(|| {
            let pad = self::pad();
            let builder =
                cache::sensing_builder(&pad, Method::default(), |_, _| ()).expect("solvable");
            let sensing = Arc::new(builder.build_initial().expect("a matrix"));
            let mut engine = Engine::new(&pad, sensing, profile());
            let mut events = Vec::new();
            for frame in &frames[..=REFERENCE_FRAMES] {
                engine.input(&Input::Frame(frame.clone()), &mut events);
            }
            black_box(engine.image().peak())
        });
    });
    let builder = cache::sensing_builder(&pad, Method::default(), |_, _| ()).expect("solvable");
    let mut deviations = vec![1e-3; pad.channels()];
    // The channels of one electrode are excluded.
    for (deviation, channel) in deviations.iter_mut().zip(&pad.protocol.channels) {
        if [channel.drive, channel.measure]
            .iter()
            .any(|pair| pair.0 == 5 || pair.1 == 5)
        {
            *deviation = f64::INFINITY;
        }
    }
    let noise = deviations.into();
    criterion.bench_function("matrix without an electrode", |bencher| {
        bencher.iter(|| builder.build(&noise).expect("a matrix"));
    });
}

fn frame_to_events(criterion: &mut Criterion) {
    let pad = pad();
    let inputs: Vec<Input> = frames(&pad).into_iter().map(Input::Frame).collect();
    for method in Method::ALL {
        let builder = cache::sensing_builder(&pad, *method, |_, _| ()).expect("solvable");
        let sensing = Arc::new(builder.build_initial().expect("a matrix"));
        let fresh = Engine::new(&pad, sensing, profile());
        let name = format!("frame to events, {}", method.name());
        // Plays the whole session: divide by 3000 for one frame.
        criterion.bench_function(&format!("{name} (x 3000)"), |bencher| {
            bencher.iter_batched(
                || (fresh.clone(), Vec::with_capacity(4096)),
                |(mut engine, mut events)| {
                    for input in &inputs {
                        engine.input(input, &mut events);
                    }
                    events.len()
                },
                BatchSize::LargeInput,
            );
        });
        let mut took_us: Vec<f64> = Vec::new();
        for _ in 0..5 {
            let (mut engine, mut events) = (fresh.clone(), Vec::with_capacity(4096));
            for input in &inputs {
                let start = now();
                engine.input(input, &mut events);
                took_us.push(start.elapsed().as_secs_f64() * 1e6);
            }
        }
        print_times(&name, took_us);
    }
}

/// The same session, its frames read drive by drive.
fn part_to_events(criterion: &mut Criterion) {
    let pad = pad();
    let frames = frames(&pad);
    let mut splitter = PartSplitter::new(&pad.protocol);
    let parts: Vec<Input> = frames
        .iter()
        .flat_map(|frame| splitter.take(frame.clone()))
        .map(Input::Part)
        .collect();
    let frames: Vec<Input> = frames.into_iter().map(Input::Frame).collect();
    let builder = cache::sensing_builder(&pad, Method::default(), |_, _| ()).expect("solvable");
    let sensing = Arc::new(builder.build_initial().expect("a matrix"));
    let fresh = Engine::new(&pad, sensing, profile());
    criterion.bench_function("part to events (x 48000)", |bencher| {
        bencher.iter_batched(
            || (fresh.clone(), Vec::with_capacity(4096)),
            |(mut engine, mut events)| {
                for input in &parts {
                    engine.input(input, &mut events);
                }
                events.len()
            },
            BatchSize::LargeInput,
        );
    });
    let time_all = |inputs: &[Input]| {
        let mut took_us = Vec::new();
        for _ in 0..3 {
            let (mut engine, mut events) = (fresh.clone(), Vec::with_capacity(4096));
            for input in inputs {
                let start = now();
                engine.input(input, &mut events);
                took_us.push(start.elapsed().as_secs_f64() * 1e6);
            }
        }
        took_us
    };
    let (by_frame, by_part) = (time_all(&frames), time_all(&parts));
    let sum = |times: &[f64]| times.iter().sum::<f64>();
    println!(
        "a frame in parts costs {:.2} times a whole frame",
        sum(&by_part) / sum(&by_frame)
    );
    print_times("whole frame to events", by_frame);
    print_times("part to events", by_part);
}

fn frame_to_touches(criterion: &mut Criterion) {
    touches_on(criterion, &pad(), "frame to touches");
    touches_on(criterion, &learned_pad(), "frame to touches, learned pad");
}

/// The shipped pad as 200 simulated presses describe it, without its model.
fn learned_pad() -> Pad {
    let pad = pad();
    let simulated = SimulatedPad::new(&pad).expect("solvable");
    let untouched = simulated.volts(&[]).expect("solvable");
    let list = (0..200).map(|index| {
        let share = |root: f64| (0.5 + f64::from(index) * root).fract();
        let place_mm = [0.754_877_666, 0.569_840_29].map(|root| 100.0 * share(root));
        let press = Press {
            centre_mm: place_mm,
            radius_mm: 7.0,
            rise: 1.0,
        };
        let volts = simulated.volts(&[press]).expect("solvable");
        let pairs = volts.iter().zip(&untouched);
        CalibrationPress {
            place_mm,
            modelled: Some(ModelPrediction {
                force: 0.5,
                place_mm,
            }),
            changes: pairs.map(|(volt, before)| volt / before - 1.0).collect(),
        }
    });
    let presses = Presses::new("simulated", list.collect()).expect("spread");
    let maps = learn_maps(&presses, pad.outline.size_mm()).expect("learned");
    Pad {
        learned: Some(Arc::new(maps)),
        ..pad
    }
}

/// One, two and three touches that go down one after the other, stay, and lift: frames like those of static.csv at 60 dB.
fn touches_on(criterion: &mut Criterion, pad: &Pad, title: &str) {
    let builder = cache::sensing_builder(pad, Method::Tikhonov, |_, _| ()).expect("solvable");
    let simulated = SimulatedPad::new(pad).expect("solvable");
    let places = [[30.0, 40.0], [70.0, 35.0], [50.0, 75.0]];
    let finger = |index: usize| Press {
        centre_mm: places[index],
        radius_mm: 7.0,
        rise: 1.0,
    };
    let mut noise = Noise::new(60.0, 1);
    for touches in 1..=places.len() {
        let mut frames = Vec::new();
        let mut play = |down: usize, count: usize, frames: &mut Vec<Frame>| {
            let fingers: Vec<Press> = (0..down).map(finger).collect();
            let volts = simulated.volts(&fingers).expect("solvable");
            for _ in 0..count {
                let t_ns = frames.len() as u64 * 10_000_000;
                frames.push(Frame {
                    t_ns,
                    volts: noise.read(&volts),
                });
            }
        };
        play(0, 50, &mut frames);
        for down in 1..=touches {
            play(down, if down == touches { 300 } else { 20 }, &mut frames);
        }
        let sensing = Arc::new(builder.build_initial().expect("a matrix"));
        let fresh = Detector::for_pad(sensing, &pad.protocol);
        let name = format!("{title}, tikhonov, {touches} down");
        criterion.bench_function(&format!("{name} (x {})", frames.len()), |bencher| {
            bencher.iter_batched(
                || (fresh.clone(), Vec::with_capacity(4096)),
                |(mut detector, mut changed)| {
                    for frame in &frames {
                        detector.process_frame(frame, &mut changed);
                    }
                    changed.len()
                },
                BatchSize::LargeInput,
            );
        });
        let mut took_us = Vec::new();
        for _ in 0..5 {
            let (mut detector, mut changed) = (fresh.clone(), Vec::with_capacity(4096));
            for frame in &frames {
                let start = now();
                detector.process_frame(frame, &mut changed);
                took_us.push(start.elapsed().as_secs_f64() * 1e6);
            }
        }
        print_times(&name, took_us);
    }
}

/// Median and p99 of times of single frames.
fn print_times(name: &str, mut took_us: Vec<f64>) {
    took_us.sort_by(f64::total_cmp);
    let at = |share: f64| took_us[(share * (took_us.len() - 1) as f64) as usize];
    println!(
        "{name}: median {:.1} us, p99 {:.1} us, of {}",
        at(0.5),
        at(0.99),
        took_us.len()
    );
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = set_up, frame_to_events, part_to_events, frame_to_touches
}
criterion_main!(benches);
