//! Set-up of the shipped pad to its first image, and one frame to its events.
//!
//! Criterion gives medians; the p99 of a frame is printed beside them, since a player feels the worst frames.

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use gelpad::eit::REFERENCE_FRAMES;
use gelpad::engine::{Engine, Input};
use gelpad::pad::{DEFAULT_PAD, Pad, shipped_pad};
use gelpad::profile::{DEFAULT_PROFILE, Profile, shipped_profile};
use gelpad::source::{FramesCsv, Reading, Source};
use gelpad::touch::SensingBuilder;
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
    while let Reading::Frame(frame) = session.read().expect("a frame") {
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
    criterion.bench_function("set-up to first image", |bencher| {
        bencher.iter(|| {
            let pad = self::pad();
            let builder = SensingBuilder::new(&pad, Method::default()).expect("sound");
            let sensing = builder.first().expect("a matrix");
            let mut engine = Engine::new(&pad, Arc::new(sensing), profile());
            let mut events = Vec::new();
            for frame in &frames[..=REFERENCE_FRAMES] {
                engine.input(&Input::Frame(frame.clone()), &mut events);
            }
            black_box(engine.touches().image.peak())
        });
    });
}

fn frame_to_events(criterion: &mut Criterion) {
    let pad = pad();
    let inputs: Vec<Input> = frames(&pad).into_iter().map(Input::Frame).collect();
    for method in Method::ALL {
        let builder = SensingBuilder::new(&pad, *method).expect("sound");
        let sensing = Arc::new(builder.first().expect("a matrix"));
        let fresh = Engine::new(&pad, sensing, profile());
        let name = format!("frame to events, {}", method.name());
        // The whole session in one go: the time a frame is a three-thousandth.
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
        took_us.sort_by(f64::total_cmp);
        let at = |share: f64| took_us[(share * (took_us.len() - 1) as f64) as usize];
        println!(
            "{name}: median {:.1} us, p99 {:.1} us, of {} frames",
            at(0.5),
            at(0.99),
            took_us.len()
        );
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = set_up, frame_to_events
}
criterion_main!(benches);
