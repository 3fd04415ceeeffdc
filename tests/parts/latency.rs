//! From a press of the pad to the key, over a pseudo-terminal at 115,200 baud: OpenEIT's text, a quarter of a second a frame.
//!
//! `GELPAD_PRESSES=N` sets the number of presses (`scripts/press-to-key.sh`).

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use gelpad::output::{OutputDevice, OutputError};
use gelpad::runtime;
use gelpad::source::Source;
use gelpad::source::board::BoardSettings;
use gelpad::source::serial::SerialSource;
use gelpad::source::wire::WireFormat;
use gelpad::stats::quantile;
use gelpad::types::{Action, Event, Output};

use super::board::{ServedBoard, now, pad, plan};
use super::play::{JUMP, builder, engine};

const BAUD: u32 = 115_200;
/// The reference is taken before the first press, ms.
const FIRST_MS: u64 = 4500;
const PRESS_MS: u64 = 400;
const PAUSE_MS: u64 = 500;

/// When each press begins, ms: anywhere within a frame.
fn presses(count: u64) -> Vec<u64> {
    (0..count)
        .map(|n| FIRST_MS + n * (PRESS_MS + PAUSE_MS) + n * 149 % 233)
        .collect()
}

fn script(presses: &[u64]) -> String {
    let [x, y] = JUMP;
    let mut text: String = presses
        .iter()
        .map(|t| format!("t:{t} down 1 {x} {y}\nt:{} up 1\n", t + PRESS_MS))
        .collect();
    let last = presses.last().expect("a press");
    text.push_str(&format!("t:{} end\n", last + PRESS_MS + PAUSE_MS));
    text
}

/// Notes when keys are pressed and released.
#[derive(Clone, Default)]
struct Stopwatch(Arc<Mutex<Vec<(bool, Instant)>>>);

impl OutputDevice for Stopwatch {
    fn name(&self) -> &str {
        "stopwatch"
    }

    fn supports(&self, _: Output) -> bool {
        true
    }

    fn send(&mut self, event: &Event) -> Result<(), OutputError> {
        let mut seen = self.0.lock().expect("unpoisoned");
        match event.action {
            Action::Press(_) => seen.push((true, now())),
            Action::Release(_) => seen.push((false, now())),
            _ => {}
        }
        Ok(())
    }
}

/// Delays of presses and of releases, ms; other key presses.
#[derive(Debug, Default)]
struct Delays {
    down_ms: Vec<f64>,
    up_ms: Vec<f64>,
    others: usize,
}

fn play(format: &str, presses: &[u64], seed: u64) -> Delays {
    let pad = pad("openeit-lattice");
    let settings = BoardSettings {
        menu: false,
        ..BoardSettings::new(WireFormat::OpenEit)
    };
    let builder = builder(&pad);
    let engine = engine(&pad, &builder);
    let board = ServedBoard::start(
        &pad,
        &settings,
        &script(presses),
        (60.0, seed),
        plan(None, Some(BAUD)),
    );
    let format = format.parse().expect("a format");
    let mut source = SerialSource::open(&board.port, BAUD, &pad, format).expect("opened");
    source.read_in_parts();
    let stopwatch = Stopwatch::default();
    let device = Box::new(stopwatch.clone());
    let game = runtime::start(engine, builder, Box::new(source), device).expect("threads");
    let length = presses.last().expect("a press") + PRESS_MS + PAUSE_MS;
    std::thread::sleep(Duration::from_millis(length));
    let summary = game.end_within(Duration::from_secs(5)).expect("ends");
    assert_eq!(summary.panicked, None);
    let opened = board.opened.lock().expect("unpoisoned").expect("opened");
    board.end();
    let seen = stopwatch.0.lock().expect("unpoisoned");
    let mut delays = Delays::default();
    let mut own = 0;
    for start in presses {
        let mut first = |is_press, after_ms: u64| {
            let from = opened + Duration::from_millis(after_ms);
            let until = from + Duration::from_millis(PRESS_MS + PAUSE_MS / 2);
            let mut those = seen
                .iter()
                .filter(|(press, at)| *press == is_press && (from..until).contains(at));
            let (_, at) = those.next()?;
            own += usize::from(is_press);
            Some((*at - from).as_secs_f64() * 1e3)
        };
        delays.down_ms.extend(first(true, *start));
        delays.up_ms.extend(first(false, start + PRESS_MS));
    }
    delays.others = seen.iter().filter(|(press, _)| *press).count() - own;
    delays
}

#[test]
fn a_press_reaches_its_key_before_its_frame_has_arrived() {
    let count = std::env::var("GELPAD_PRESSES").map_or(9, |n| n.parse().expect("a number"));
    let presses = presses(count);
    let (whole, parts) = std::thread::scope(|scope| {
        let whole = scope.spawn(|| play("openeit:whole", &presses, 3));
        let parts = scope.spawn(|| play("openeit", &presses, 3));
        (
            whole.join().expect("no panic"),
            parts.join().expect("no panic"),
        )
    });
    for (name, delays) in [("frame by frame", &whole), ("in parts", &parts)] {
        let at = |times: &[f64], share| quantile(times.iter().copied(), share).unwrap_or(f64::NAN);
        println!(
            "{name}: {} of {count} presses, {} others; press to key median {:.0} ms, p95 {:.0} ms; lift to release median {:.0} ms, p95 {:.0} ms",
            delays.down_ms.len(),
            delays.others,
            at(&delays.down_ms, 0.5),
            at(&delays.down_ms, 0.95),
            at(&delays.up_ms, 0.5),
            at(&delays.up_ms, 0.95)
        );
    }
    assert_eq!(parts.down_ms.len() as u64, count, "every press has its key");
    assert_eq!(parts.others, 0, "no other key");
    // Frame by frame a press waits for the end of its frame and of the next: this holds on a busy computer too.
    let median = |times: &[f64]| quantile(times.iter().copied(), 0.5).expect("some");
    assert!(median(&parts.down_ms) < 0.6 * median(&whole.down_ms));
}
