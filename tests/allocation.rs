//! A step of the gestures does not allocate once the profile is loaded, nor a part of a frame that changes no touch.
//! Tests of their own binary, because they count all allocations.

#![allow(
    unsafe_code,
    reason = "a global allocator is an unsafe trait; this one only counts"
)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::Arc;

use gelpad::cache;
use gelpad::engine::{Engine, Input};
use gelpad::gesture::Gestures;
use gelpad::pad::{DEFAULT_PAD, Pad, shipped_pad};
use gelpad::profile::{DEFAULT_PROFILE, Profile, shipped_profile};
use gelpad::source::{FramesCsv, PartSplitter, Source, SourceReading};
use gelpad::types::{Contact, Method, NANOS_PER_MS, Phase, Touch, TouchId};

struct Counting;

thread_local! {
    /// Allocations of this thread: the test harness has others.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// A hundred bindings of all kinds on a grid of 10 x 10.
fn profile() -> Arc<Profile> {
    let kinds = [
        "output = \"key:a\"",
        "gesture = \"tap\", output = \"key:b\"",
        "gesture = \"hold\", hold_ms = 50, output = \"key:c\"",
        "gesture = \"tap-hold\", tap = \"key:d\", hold = \"key:e\", tapping_term_ms = 50",
        "gesture = \"dpad\", up = \"key:up\", down = \"key:down\"",
        "gesture = \"stick\", axis_x = \"pad:left-x\", axis_y = \"pad:left-y\"",
        "gesture = \"trigger\", axis = \"pad:right-trigger\"",
        "mode = \"turbo\", turbo_hz = 20, output = \"key:f\"",
        "mode = \"classified\", output = \"key:g\"",
        "mode = \"macro\", macro = [\"tap key:h\", \"wait 20\", \"tap key:i\"]",
    ];
    let bindings: String = (0..100)
        .map(|cell| {
            format!(
                "  {{ region = \"g-{}\", {} }},\n",
                cell + 1,
                kinds[cell % kinds.len()]
            )
        })
        .collect();
    let text = format!(
        "schema = 1\nname = \"hundred\"\npanic_contacts = 0\ntremor_mm = 1\ntremor_ms = 5\nregion = [{{ name = \"g\", shape = \"grid\", x = 0, y = 0, w = 1, h = 1, columns = 10, rows = 10, slide = \"across\" }}]\nbinding = [\n{bindings}]\n"
    );
    Arc::new(Profile::from_toml("hundred", &text).unwrap_or_else(|faulty| panic!("{faulty}")))
}

#[test]
fn a_step_of_ten_touches_and_a_hundred_bindings_does_not_allocate() {
    let mut gestures = Gestures::new(profile(), [100.0, 100.0]);
    let mut events = Vec::with_capacity(10_000);
    let mut frames = Vec::new();
    for frame in 0..600u64 {
        let (round, step) = (frame / 20, frame % 20);
        let phase = match step {
            0 => Phase::Down,
            19 => Phase::Up,
            _ => Phase::Move,
        };
        let changed: Vec<Touch> = (0..10u64)
            .map(|finger| Touch {
                id: TouchId(round * 10 + finger),
                phase,
                since_ns: 0,
                contact: Contact {
                    centre_mm: [
                        (finger * 10 + round * 7 + step * 2) as f64 % 100.0,
                        (finger * 10 + step) as f64 % 100.0,
                    ],
                    area_mm2: 150.0,
                    force: step as f64 / 20.0,
                    confidence: 1.0,
                },
            })
            .collect();
        frames.push((frame * 10 * NANOS_PER_MS, changed));
    }
    let before = ALLOCATIONS.get();
    for (t_ns, changed) in &frames {
        gestures.touches(*t_ns, changed, &mut events);
        gestures.tick(t_ns + 5 * NANOS_PER_MS, &mut events);
    }
    let after = ALLOCATIONS.get();
    assert!(
        events.len() > 1000,
        "the script plays: {} events",
        events.len()
    );
    assert_eq!(after - before, 0, "allocations in {} steps", frames.len());
}

/// The frames of the session that other tests use, read drive by drive: holds, taps, two touches, drift.
fn parts(pad: &Pad) -> Vec<Input> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/data/lattice-presses/session.csv"
    );
    let mut session = FramesCsv::open(path.as_ref(), pad.channels()).expect("the session");
    let mut splitter = PartSplitter::new(&pad.protocol);
    let mut parts = Vec::new();
    while let SourceReading::Frame(frame) = session.read().expect("a frame") {
        parts.extend(splitter.take(frame).into_iter().map(Input::Part));
    }
    parts
}

#[test]
fn a_part_that_changes_no_touch_does_not_allocate() {
    let shipped = shipped_pad(DEFAULT_PAD).expect("shipped");
    let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
    let profile = shipped_profile(DEFAULT_PROFILE).expect("shipped");
    let profile = Arc::new(Profile::from_toml(profile.name, profile.toml).expect("sound"));
    let builder = cache::sensing_builder(&pad, Method::default(), |_, _| ()).expect("solvable");
    let sensing = Arc::new(builder.build_initial().expect("a matrix"));
    let mut engine = Engine::new(&pad, sensing, profile);
    let parts = parts(&pad);
    let mut events = Vec::with_capacity(10_000);
    // The first half shows every kind of touch: memory grows there.
    let (first, second) = parts.split_at(parts.len() / 2);
    for part in first {
        engine.input(part, &mut events);
    }
    let (mut allocated, mut counted) = (0, 0);
    for input in second {
        let is_free = engine.touches_down().is_empty();
        let before = ALLOCATIONS.get();
        engine.input(input, &mut events);
        let Input::Part(part) = input else {
            continue;
        };
        // At the end of a frame the detector looks for touches, as it does in whole frames.
        let ends_frame = part.first + part.volts.len() == pad.channels();
        if is_free && engine.touches_down().is_empty() && !ends_frame {
            allocated += ALLOCATIONS.get() - before;
            counted += 1;
        }
    }
    assert!(counted > 1000, "{counted} parts without a touch");
    assert_eq!(allocated, 0, "allocations in {counted} parts");
}
