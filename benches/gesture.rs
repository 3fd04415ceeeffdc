//! One step of ten touches on a profile with a hundred bindings. It prints the 99th percentile: players feel the slowest steps.

use std::sync::Arc;
use std::time::Instant;

use criterion::{Criterion, criterion_group, criterion_main};
use gelpad::gesture::Gestures;
use gelpad::profile::Profile;
use gelpad::types::{Contact, NANOS_PER_MS, Phase, Touch, TouchId};

const TOUCHES: u64 = 10;
/// Steps of each touch: down, moves, up.
const STEPS: u64 = 50;
const LIVES: u64 = 400;

fn profile() -> Arc<Profile> {
    let bindings: String = (1..=100)
        .map(|cell| {
            format!(
                "  {{ region = \"g-{cell}\", output = \"key:{}\" }},\n",
                ["a", "b", "c", "d"][cell % 4]
            )
        })
        .collect();
    let text = format!(
        "schema = 1\nname = \"hundred\"\npanic_contacts = 0\nregion = [{{ name = \"g\", shape = \"grid\", x = 0, y = 0, w = 1, h = 1, columns = 10, rows = 10 }}]\nbinding = [\n{bindings}]\n"
    );
    Arc::new(Profile::from_toml("hundred", &text).expect("sound"))
}

fn step(life: u64, step: u64) -> Vec<Touch> {
    let phase = match step {
        0 => Phase::Down,
        last if last == STEPS - 1 => Phase::Up,
        _ => Phase::Move,
    };
    (0..TOUCHES)
        .map(|finger| Touch {
            id: TouchId(life * TOUCHES + finger),
            phase,
            since_ns: 0,
            contact: Contact {
                centre_mm: [
                    ((finger * 10 + step + life) % 100) as f64,
                    ((finger * 37 + step) % 100) as f64,
                ],
                area_mm2: 150.0,
                force: 0.5,
                confidence: 1.0,
            },
        })
        .collect()
}

#[allow(clippy::disallowed_methods, reason = "a benchmark reads the clock")]
fn now() -> Instant {
    Instant::now()
}

fn steps(criterion: &mut Criterion) {
    let frames: Vec<Vec<Touch>> = (0..LIVES)
        .flat_map(|life| (0..STEPS).map(move |at| step(life, at)))
        .collect();
    let fresh = Gestures::new(profile(), [100.0, 100.0]);
    let mut took_us: Vec<f64> = Vec::new();
    let (mut gestures, mut events) = (fresh.clone(), Vec::with_capacity(1 << 20));
    for (index, changed) in frames.iter().enumerate() {
        let t_ns = index as u64 * 10 * NANOS_PER_MS;
        let start = now();
        gestures.touches(t_ns, changed, &mut events);
        took_us.push(start.elapsed().as_secs_f64() * 1e6);
    }
    took_us.sort_by(f64::total_cmp);
    let at = |share: f64| took_us[(share * (took_us.len() - 1) as f64) as usize];
    println!(
        "gesture step, {TOUCHES} touches and 100 bindings: median {:.2} us, p99 {:.2} us, of {} steps",
        at(0.5),
        at(0.99),
        took_us.len()
    );
    criterion.bench_function("gesture step, 10 touches moving, 100 bindings", |bencher| {
        let mut gestures = fresh.clone();
        events.clear();
        gestures.touches(0, &frames[0], &mut events);
        let mut t_ns = 0;
        bencher.iter(|| {
            t_ns += 10 * NANOS_PER_MS;
            gestures.touches(t_ns, &frames[1], &mut events);
        });
    });
}

criterion_group!(benches, steps);
criterion_main!(benches);
