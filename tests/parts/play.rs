//! Boards in parts through the whole game: what goes wrong within a frame.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use gelpad::cache;
use gelpad::eit::Press;
use gelpad::engine::Engine;
use gelpad::output::{OutputDevice, OutputError};
use gelpad::pad::Pad;
use gelpad::profile::{Profile, shipped_profile};
use gelpad::runtime;
use gelpad::source::{Noise, SimulatedPad, Source, SourceError, SourcePace, SourceReading};
use gelpad::touch::SensingBuilder;
use gelpad::types::{Action, Event, Method, Nanos, Output, Part};

use super::board::pad;

/// Where super-mario's region `jump` lies, mm.
pub const JUMP: [f64; 2] = [80.0, 50.0];
const DRIVES: usize = 16;
const PART_NS: Nanos = 5_000_000;

pub fn builder(pad: &Pad) -> SensingBuilder {
    cache::sensing_builder(pad, Method::default(), |_, _| ()).expect("solvable")
}

pub fn engine(pad: &Pad, builder: &SensingBuilder) -> Engine {
    let shipped = shipped_profile("super-mario").expect("shipped");
    let profile = Arc::new(Profile::from_toml("super-mario", shipped.toml).expect("sound"));
    Engine::new(
        pad,
        Arc::new(builder.build_initial().expect("a matrix")),
        profile,
    )
}

/// A device that keeps its events.
#[derive(Clone, Default)]
pub struct Kept(pub Arc<Mutex<Vec<Event>>>);

impl OutputDevice for Kept {
    fn name(&self) -> &str {
        "kept"
    }

    fn supports(&self, _: Output) -> bool {
        true
    }

    fn send(&mut self, event: &Event) -> Result<(), OutputError> {
        self.0.lock().expect("unpoisoned").push(*event);
        Ok(())
    }
}

/// A board that hands on these parts at their times, and then nothing for a while.
struct PartsThenSilence {
    parts: VecDeque<Part>,
    start: Option<std::time::Instant>,
    silent: Duration,
}

impl Source for PartsThenSilence {
    fn pace(&self) -> SourcePace {
        SourcePace::ByDevice
    }

    fn read(&mut self) -> Result<SourceReading, SourceError> {
        let now = super::board::now();
        let start = *self.start.get_or_insert(now);
        let Some(part) = self.parts.front() else {
            self.silent = self.silent.saturating_sub(Duration::from_millis(20));
            std::thread::sleep(Duration::from_millis(20));
            return Ok(match self.silent.is_zero() {
                true => SourceReading::End,
                false => SourceReading::Idle,
            });
        };
        let due = start + Duration::from_nanos(part.t_ns);
        std::thread::sleep(due.saturating_duration_since(now));
        Ok(SourceReading::Part(
            self.parts.pop_front().expect("just seen"),
        ))
    }
}

/// Parts of a pad that is pressed from one part on.
fn parts(pad: &Pad, count: usize, pressed_from: usize) -> Vec<Part> {
    let simulated = SimulatedPad::new(pad).expect("solvable");
    let finger = Press {
        centre_mm: JUMP,
        radius_mm: 7.0,
        rise: 1.2,
    };
    let states = [vec![], vec![finger]].map(|presses| simulated.volts(&presses).expect("solved"));
    let mut noise = Noise::new(60.0, 4);
    let per_drive = pad.channels() / DRIVES;
    (0..count)
        .map(|index| {
            let first = index % DRIVES * per_drive;
            let state = &states[usize::from(index >= pressed_from)];
            Part {
                t_ns: index as Nanos * PART_NS,
                first,
                volts: noise.read(&state[first..first + per_drive]),
            }
        })
        .collect()
}

fn play(pad: &Pad, parts: Vec<Part>, silent: Duration) -> (Vec<Event>, u64) {
    let builder = builder(pad);
    let kept = Kept::default();
    let source = PartsThenSilence {
        parts: parts.into(),
        start: None,
        silent,
    };
    let engine = engine(pad, &builder);
    let game = runtime::start(engine, builder, Box::new(source), Box::new(kept.clone()));
    let summary = game.expect("threads").join();
    assert_eq!(summary.panicked, None);
    let events = kept.0.lock().expect("unpoisoned").clone();
    (events, summary.frames)
}

/// Presses and releases, with their times in ms.
fn keys(events: &[Event]) -> Vec<(bool, u64)> {
    let is_press = |event: &Event| match event.action {
        Action::Press(_) => Some((true, event.t_ns / 1_000_000)),
        Action::Release(_) => Some((false, event.t_ns / 1_000_000)),
        _ => None,
    };
    events.iter().filter_map(is_press).collect()
}

#[test]
fn a_board_that_stops_within_a_frame_releases_its_key_after_a_quarter_of_a_second() {
    let pad = pad("edinburgh-lattice");
    let pressed_from = 30 * DRIVES;
    let last = pressed_from + 20;
    let (events, frames) = play(
        &pad,
        parts(&pad, last + 1, pressed_from),
        Duration::from_secs(2),
    );
    assert_eq!(frames, 31, "the last frame is not complete");
    let [(true, down_ms), (false, up_ms)] = keys(&events)[..] else {
        panic!("{events:?}");
    };
    let part_ms = PART_NS / 1_000_000;
    let pressed_ms = pressed_from as u64 * part_ms;
    assert!(
        (pressed_ms..pressed_ms + 10 * part_ms).contains(&down_ms),
        "pressed at {pressed_ms}, key at {down_ms} ms"
    );
    let stopped_ms = last as u64 * part_ms;
    // Half a second is the limit between frames; the computer may be busy.
    assert!(
        (stopped_ms + 250..stopped_ms + 480).contains(&up_ms),
        "stopped at {stopped_ms}, released at {up_ms} ms"
    );
}

#[test]
fn lost_repeated_and_shuffled_parts_stick_no_key_and_stop_no_play() {
    let pad = pad("edinburgh-lattice");
    let all = parts(&pad, 60 * DRIVES, 50 * DRIVES);
    // A press at the end that must be seen, after every kind of fault.
    let mut faulty: Vec<Part> = Vec::new();
    for (index, part) in all.iter().enumerate() {
        let in_turn = index % 97;
        if !(15 * DRIVES..=45 * DRIVES).contains(&index) {
            faulty.push(part.clone());
            continue;
        }
        match in_turn {
            // Lost.
            0 | 40..47 => {}
            // Twice, at the same time.
            1..=4 => faulty.extend([part.clone(), part.clone()]),
            // Of another place in the frame.
            5 => faulty.push(Part {
                t_ns: part.t_ns,
                ..all[index + 7].clone()
            }),
            _ => faulty.push(part.clone()),
        }
    }
    let (events, _) = play(&pad, faulty, Duration::from_millis(40));
    let pressed_ms = 50 * DRIVES as u64 * PART_NS / 1_000_000;
    let [(true, down_ms), (false, _)] = keys(&events)[..] else {
        panic!("{:?}", keys(&events));
    };
    assert!(
        (pressed_ms..pressed_ms + 80).contains(&down_ms),
        "{down_ms}"
    );
}
