//! A button plays exactly what a touch plays: with random settings, gestures and modes, the same presses of two buttons
//! and of two regions give the same events. When a gamepad is unplugged, nothing stays down.

use std::sync::Arc;

use gelpad::gesture::Gestures;
use gelpad::profile::Profile;
use gelpad::types::{
    Axis, Button, Buttons, Contact, Control, Event, NANOS_PER_MS, Nanos, Phase, Touch, TouchId,
};
use proptest::prelude::*;

const PAD_MM: [f64; 2] = [100.0, 100.0];
/// Where the two regions are touched.
const PLACES_MM: [[f64; 2]; 2] = [[20.0, 50.0], [80.0, 50.0]];
const BUTTONS: [Button; 2] = [Button::A, Button::B];
const CASES: u32 = 3000;

/// Settings that are about times, not places.
fn settings() -> impl Strategy<Value = String> {
    let times = prop::sample::select(vec![
        "",
        "slow_keys_ms = 120\n",
        "bounce_keys_ms = 90\n",
        "tremor_ms = 60\ntremor_mm = 5\n",
        "slow_keys_ms = 50\nbounce_keys_ms = 80\n",
    ]);
    let more = prop::sample::select(vec![
        "",
        "activate = \"up\"\n",
        "sticky_keys = true\n",
        "min_gap_ms = 40\n",
        "max_hold_ms = 200\n",
    ]);
    (times, more).prop_map(|(times, more)| format!("{times}{more}"))
}

/// A binding without its place.
fn binding() -> impl Strategy<Value = String> {
    let gesture = prop::sample::select(vec![
        "",
        "gesture = \"tap\", ",
        "gesture = \"hold\", hold_ms = 150, ",
        "gesture = \"double-tap\", ",
        "gesture = \"force\", force = 0.5, ",
    ]);
    let mode = prop::sample::select(vec![
        "",
        "mode = \"classified\", ",
        "mode = \"latch\", length_ms = 90, ",
        "mode = \"toggle\", ",
        "mode = \"turbo\", turbo_hz = 9, ",
        "mode = \"repeat\", repeat_delay_ms = 120, ",
        "mode = \"sticky\", ",
    ]);
    let output = prop::sample::select(vec![
        "\"key:a\"",
        "[\"key:b\", \"key:a\"]",
        "\"key:left-shift\"",
    ]);
    let single = (gesture, mode, output)
        .prop_map(|(gesture, mode, output)| format!("{gesture}{mode}output = {output}"));
    let tap_hold = prop::sample::select(vec![
        "speculative",
        "tap-preferred",
        "balanced",
        "hold-preferred",
    ])
    .prop_map(|flavour| {
        format!(
            "gesture = \"tap-hold\", flavour = \"{flavour}\", tap = \"key:c\", hold = \"key:d\""
        )
    });
    prop_oneof![4 => single, 1 => tap_hold]
}

/// The same profile twice: by regions, and by buttons.
fn profiles(settings: &str, bindings: &[String; 2], chord: bool) -> [Arc<Profile>; 2] {
    let whole = |places: [&str; 2], both: &str| {
        let [first, second] = [0, 1].map(|i| format!("{{ {}, {} }}", places[i], bindings[i]));
        let chord = match chord {
            true => format!("{{ {both}, gesture = \"chord\", output = \"key:x\" }},"),
            false => String::new(),
        };
        let text = format!(
            "schema = 1\nname = \"case\"\n{settings}region = [{{ name = \"l\", x = 0, y = 0, w = 0.4, h = 1 }}, {{ name = \"r\", x = 0.6, y = 0, w = 0.4, h = 1 }}]\nbinding = [{first}, {second}, {chord}]\n"
        );
        let read = Profile::from_toml("case", &text);
        Arc::new(read.unwrap_or_else(|faulty| panic!("{faulty}\n{text}")))
    };
    [
        whole(
            ["region = \"l\"", "region = \"r\""],
            "region = [\"l\", \"r\"]",
        ),
        whole(
            ["from = \"pad:a\"", "from = \"pad:b\""],
            "from = [\"pad:a\", \"pad:b\"]",
        ),
    ]
}

/// Which of the two buttons changes, and how long after the last change, ms.
fn script() -> impl Strategy<Value = Vec<(usize, u64)>> {
    prop::collection::vec((0..2usize, 1..250u64), 1..24)
}

fn by_touches(profile: &Arc<Profile>, script: &[(usize, u64)]) -> Vec<Event> {
    let mut gestures = Gestures::new(Arc::clone(profile), PAD_MM);
    let (mut events, mut t_ns, mut next_id) = (Vec::new(), 0, 0);
    let mut down: [Option<Touch>; 2] = [None; 2];
    for (which, after_ms) in script {
        t_ns += after_ms * NANOS_PER_MS;
        let changed = match down[*which].take() {
            Some(touch) => Touch {
                phase: Phase::Up,
                ..touch
            },
            None => {
                next_id += 1;
                let touch = Touch {
                    id: TouchId(next_id),
                    phase: Phase::Down,
                    since_ns: t_ns,
                    contact: Contact {
                        centre_mm: PLACES_MM[*which],
                        area_mm2: 150.0,
                        force: 1.0,
                        confidence: 1.0,
                    },
                };
                down[*which] = Some(touch);
                touch
            }
        };
        gestures.touches(t_ns, &[changed], &mut events);
    }
    finish(gestures, t_ns, events)
}

fn by_buttons(profile: &Arc<Profile>, script: &[(usize, u64)]) -> Vec<Event> {
    let mut gestures = Gestures::new(Arc::clone(profile), PAD_MM);
    let mut events = Vec::new();
    let mut state = Control {
        present: true,
        ..Control::default()
    };
    for (which, after_ms) in script {
        state.t_ns += after_ms * NANOS_PER_MS;
        let button = BUTTONS[*which];
        state.buttons = match state.buttons.contains(button) {
            true => state.buttons.without(button),
            false => state.buttons.with(button),
        };
        gestures.control(&state, &mut events);
        // The same state again changes nothing.
        gestures.control(&state, &mut events);
    }
    finish(gestures, state.t_ns, events)
}

fn finish(mut gestures: Gestures, t_ns: Nanos, mut events: Vec<Event>) -> Vec<Event> {
    let end_ns = t_ns + 700 * NANOS_PER_MS;
    gestures.tick(end_ns, &mut events);
    gestures.release_all(end_ns, &mut events);
    events
}

fn state() -> impl Strategy<Value = (u64, bool, u16, [f32; Axis::ALL.len()])> {
    let axes = prop::array::uniform6(prop::sample::select(vec![
        -1.0f32, -0.3, 0.0, 0.1, 0.6, 1.0,
    ]));
    (1..200u64, prop::bool::weighted(0.9), any::<u16>(), axes)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(CASES))]

    #[test]
    fn a_button_plays_what_a_touch_plays(
        settings in settings(), bindings in [binding(), binding()], chord in any::<bool>(), script in script(),
    ) {
        let [regions, buttons] = profiles(&settings, &bindings, chord);
        prop_assert_eq!(by_touches(&regions, &script), by_buttons(&buttons, &script));
    }

    #[test]
    fn nothing_is_down_once_it_is_unplugged(
        settings in settings(), bindings in [binding(), binding()], states in prop::collection::vec(state(), 1..40),
    ) {
        let [_, profile] = profiles(&settings, &bindings, true);
        let mut gestures = Gestures::new(profile, PAD_MM);
        let mut events = Vec::new();
        let mut t_ns = 0;
        for (after_ms, present, bits, axes) in states {
            t_ns += after_ms * NANOS_PER_MS;
            let buttons = Buttons::from_bits(bits);
            gestures.control(&Control { t_ns, present, buttons, axes }, &mut events);
            prop_assert!(present || gestures.held().count() == 0);
        }
        t_ns += NANOS_PER_MS;
        gestures.control(&Control { t_ns, ..Control::default() }, &mut events);
        prop_assert_eq!(gestures.held().count(), 0);
        let still = events.len();
        gestures.tick(t_ns + 60_000 * NANOS_PER_MS, &mut events);
        prop_assert_eq!(events.len(), still, "events without a gamepad");
    }
}
