//! Properties of all profiles and touch scripts, tested with random ones.

use std::sync::Arc;

use gelpad::gesture::Gestures;
use gelpad::profile::Profile;
use gelpad::types::{
    Action, Axis, Contact, Event, NANOS_PER_MS, Nanos, Output, Phase, Touch, TouchId,
};
use proptest::prelude::*;

const PAD_MM: [f64; 2] = [100.0, 100.0];
const MIN_HOLD_NS: Nanos = 34 * NANOS_PER_MS;
/// Random profiles, each with a random script; every property is tested on each.
const CASES: u32 = 10_000;

/// Regions that overlap, slide, ignore touches, or count footprints.
const REGIONS: &[&str] = &[
    "{ name = \"r0\", x = 0, y = 0, w = 0.5, h = 0.5 }",
    "{ name = \"r1\", shape = \"circle\", x = 0.5, y = 0.5, r = 0.3, held_reach = 0.1 }",
    "{ name = \"r2\", x = 0.5, y = 0, w = 0.5, h = 0.6, slide = \"across\" }",
    "{ name = \"r3\", x = 0, y = 0.5, w = 0.4, h = 0.5, exclusive = false, footprint = 1 }",
    "{ name = \"r4\", shape = \"polygon\", points = [[0.3, 0.6], [1, 0.6], [1, 1], [0.5, 1]], slide = \"across\" }",
    "{ name = \"r5\", shape = \"ellipse\", x = 0.5, y = 0.1, w = 0.8, h = 0.2, rest = true, order = 1 }",
];

fn binding() -> impl Strategy<Value = String> {
    let region = prop_oneof![
        (0..6u8).prop_map(|r| format!("region = \"r{r}\", ")),
        Just(String::new())
    ];
    let layer = prop_oneof![9 => Just(""), 1 => Just("layer = \"up\", ")];
    let output = prop::sample::select(vec![
        "\"key:a\"",
        "\"key:b\"",
        "[\"key:a\", \"pad:x\"]",
        "\"mouse:left\"",
        "\"key:left-shift\"",
        "\"mouse:wheel-up\"",
        "\"layer:up\"",
    ]);
    let gesture = prop::sample::select(vec![
        "",
        "",
        "gesture = \"tap\", ",
        "gesture = \"hold\", hold_ms = 150, ",
        "gesture = \"double-tap\", ",
        "gesture = \"triple-tap\", ",
        "gesture = \"swipe\", direction = \"left\", swipe_mm = 6, ",
        "gesture = \"swipe\", direction = \"up\", fingers = 2, swipe_mm = 4, ",
        "gesture = \"contacts\", fingers = 2, ",
        "gesture = \"force\", force = 0.5, ",
    ]);
    let mode = prop::sample::select(vec![
        "",
        "",
        "",
        "mode = \"classified\", ",
        "mode = \"latch\", length_ms = 90, ",
        "mode = \"tap\", ",
        "mode = \"toggle\", ",
        "mode = \"turbo\", turbo_hz = 15, ",
        "mode = \"repeat\", repeat_delay_ms = 120, repeat_ms = 50, ",
        "mode = \"sticky\", ",
    ]);
    let simple = (region, layer, gesture, mode, output).prop_map(
        |(region, layer, gesture, mode, output)| {
            format!("{region}{layer}{gesture}{mode}output = {output}")
        },
    );
    let special = prop::sample::select(vec![
        "region = [\"r0\", \"r2\"], gesture = \"chord\", output = \"key:c\"",
        "region = \"r1\", gesture = \"dpad\", ways = 8, up = \"key:up\", down = \"key:down\", left = \"key:left\", right = \"key:right\"",
        "region = \"r1\", gesture = \"stick\", axis_x = \"pad:left-x\", axis_y = \"pad:left-y\"",
        "region = \"r2\", gesture = \"trigger\", axis = \"pad:right-trigger\"",
        "region = \"r0\", gesture = \"pointer\", gain = 3",
        "region = \"r0\", gesture = \"tap-hold\", tap = \"key:a\", hold = \"key:h\"",
        "region = \"r2\", gesture = \"tap-hold\", flavour = \"balanced\", tap = \"key:a\", hold = \"key:h\", quick_tap_ms = 80",
        "region = \"r2\", gesture = \"tap-hold\", flavour = \"hold-preferred\", tap = \"key:b\", hold = \"layer:up\"",
        "region = \"r4\", gesture = \"tap-hold\", flavour = \"tap-preferred\", tap = \"key:b\", hold = \"key:h\", require_prior_idle_ms = 60",
        "region = \"r4\", mode = \"macro\", macro = [\"press key:m\", \"wait 40\", \"tap key:a\", \"release key:m\"]",
    ])
    .prop_map(str::to_owned);
    prop_oneof![3 => simple, 2 => special]
}

fn settings() -> impl Strategy<Value = String> {
    let one = prop::sample::select(vec![
        "min_gap_ms = 34",
        "max_hold_ms = 200",
        "slow_keys_ms = 50",
        "bounce_keys_ms = 70",
        "sticky_keys = true",
        "dwell_ms = 80",
        "tremor_ms = 40\ntremor_mm = 6",
        "activate = \"up\"",
        "assist = \"last\"",
        "assist = \"first\"",
        "rest_area_mm2 = 250",
        "mirror = \"both\"",
        "rotate = 90",
        "area_x = 0.2\narea_w = 0.7",
        "tapping_term_ms = 90",
    ]);
    prop::collection::vec(one, 0..4).prop_map(|mut chosen| {
        chosen.sort_unstable();
        chosen.dedup_by_key(|line| line.split(' ').next().map(str::to_owned));
        chosen.join("\n")
    })
}

fn profile() -> impl Strategy<Value = String> {
    (settings(), prop::collection::vec(binding(), 1..7)).prop_map(|(settings, bindings)| {
        // The layer that some outputs switch always has a binding.
        let bindings: String = bindings.iter().map(|binding| format!("  {{ {binding} }},\n")).collect();
        let regions: String = REGIONS.iter().map(|region| format!("  {region},\n")).collect();
        format!(
            "schema = 1\nname = \"random\"\npanic_contacts = 0\n{settings}\nregion = [\n{regions}]\nbinding = [\n{bindings}  {{ region = \"r0\", layer = \"up\", output = \"key:z\" }},\n]\n"
        )
    })
}

/// A change of one finger in a frame: it goes down, or if it is down it moves or lifts.
#[derive(Clone, Copy, Debug)]
struct FingerChange {
    finger: usize,
    lifts: bool,
    at_mm: [f64; 2],
    area_mm2: f64,
    force: f64,
}

fn finger_change() -> impl Strategy<Value = FingerChange> {
    (
        0..5usize,
        any::<bool>(),
        0.0..100.0f64,
        0.0..100.0f64,
        50.0..300.0f64,
        0.0..1.0f64,
    )
        .prop_map(|(finger, lifts, x, y, area_mm2, force)| FingerChange {
            finger,
            lifts,
            at_mm: [x, y],
            area_mm2,
            force,
        })
}

/// Frames: their times and the changes of the touches.
fn script() -> impl Strategy<Value = Vec<(Nanos, Vec<Touch>)>> {
    let frame = (1..120u64, prop::collection::vec(finger_change(), 0..3));
    prop::collection::vec(frame, 1..25).prop_map(|frames| {
        let mut down: [Option<Touch>; 5] = [None; 5];
        let (mut t_ns, mut next_id) = (0, 0);
        frames
            .into_iter()
            .map(|(ms, changes)| {
                t_ns += ms * NANOS_PER_MS;
                let changed = changes
                    .iter()
                    .map(|one| apply(&mut down[one.finger], one, t_ns, &mut next_id))
                    .collect();
                (t_ns, changed)
            })
            .collect()
    })
}

fn apply(slot: &mut Option<Touch>, change: &FingerChange, t_ns: Nanos, next_id: &mut u64) -> Touch {
    let contact = Contact {
        centre_mm: change.at_mm,
        area_mm2: change.area_mm2,
        force: change.force,
        confidence: 1.0,
    };
    match slot.take() {
        None => {
            let touch = Touch {
                id: TouchId(*next_id),
                phase: Phase::Down,
                since_ns: t_ns,
                contact,
            };
            *next_id += 1;
            *slot = Some(touch);
            touch
        }
        Some(touch) if change.lifts => Touch {
            phase: Phase::Up,
            ..touch
        },
        Some(touch) => {
            let touch = Touch {
                phase: Phase::Move,
                contact,
                ..touch
            };
            *slot = Some(touch);
            touch
        }
    }
}

/// How the same frames reach the gestures.
#[derive(Clone, Copy, Debug)]
enum Batching {
    /// As whole frames, without a tick between.
    Frames,
    /// Every tick at its due time, as the runtime does.
    Ticks,
    /// One change per call, and a tick that is not due.
    Changes,
}

fn play(profile: &Arc<Profile>, script: &[(Nanos, Vec<Touch>)], batching: Batching) -> Vec<Event> {
    let mut gestures = Gestures::new(Arc::clone(profile), PAD_MM);
    let mut events = Vec::new();
    let mut last_ns = 0;
    for (t_ns, changed) in script {
        match batching {
            Batching::Frames => gestures.touches(*t_ns, changed, &mut events),
            Batching::Ticks => {
                while let Some(due) = gestures.next_due().filter(|due| *due <= *t_ns) {
                    gestures.tick(due, &mut events);
                }
                gestures.touches(*t_ns, changed, &mut events);
            }
            Batching::Changes => {
                gestures.tick(last_ns + (t_ns - last_ns) / 3, &mut events);
                for one in changed {
                    gestures.touches(*t_ns, std::slice::from_ref(one), &mut events);
                }
            }
        }
        last_ns = *t_ns;
    }
    gestures.tick(last_ns, &mut events);
    gestures.release_all(last_ns, &mut events);
    assert_eq!(gestures.held().count(), 0);
    events
}

/// The outputs that are down two seconds after every finger has lifted.
fn left_down(profile: &Arc<Profile>, script: &[(Nanos, Vec<Touch>)]) -> Vec<Output> {
    let mut gestures = Gestures::new(Arc::clone(profile), PAD_MM);
    let mut events = Vec::new();
    let mut down: Vec<Touch> = Vec::new();
    let mut end_ns = 0;
    for (t_ns, changed) in script {
        gestures.touches(*t_ns, changed, &mut events);
        for touch in changed {
            down.retain(|other| other.id != touch.id);
            if touch.phase != Phase::Up {
                down.push(*touch);
            }
        }
        end_ns = t_ns + NANOS_PER_MS;
    }
    let lifted: Vec<Touch> = down
        .into_iter()
        .map(|touch| Touch {
            phase: Phase::Up,
            ..touch
        })
        .collect();
    gestures.touches(end_ns, &lifted, &mut events);
    gestures.tick(end_ns + 2000 * NANOS_PER_MS, &mut events);
    gestures.held().collect()
}

/// Follows what is down; fails where an output is pressed twice, released while up, or out of order.
fn follow(events: &[Event], end_ns: Nanos, floor: bool) -> Result<(), TestCaseError> {
    let mut down: Vec<(Output, Nanos)> = Vec::new();
    let mut axes = [0.0f32; Axis::ALL.len()];
    let mut last_ns = 0;
    for event in events {
        prop_assert!(event.t_ns >= last_ns, "{event} runs backwards");
        last_ns = event.t_ns;
        match event.action {
            Action::Press(output) => {
                prop_assert!(
                    down.iter().all(|(other, _)| *other != output),
                    "{event}: pressed twice"
                );
                down.push((output, event.t_ns));
            }
            Action::Release(output) => {
                let index = down.iter().position(|(other, _)| *other == output);
                prop_assert!(index.is_some(), "{event}: not down");
                let (_, since) = down.remove(index.expect("just seen"));
                let long = event.t_ns - since >= MIN_HOLD_NS || event.t_ns == end_ns;
                prop_assert!(long || !floor, "{event}: after {} ns", event.t_ns - since);
            }
            Action::Axis(axis, value) => {
                let index = Axis::ALL
                    .iter()
                    .position(|one| *one == axis)
                    .expect("an axis");
                prop_assert!(
                    (-1.0..=1.0).contains(&value) && axes[index] != value,
                    "{event}"
                );
                axes[index] = value;
            }
            Action::Motion { .. } | Action::Wheel { .. } => {}
        }
    }
    prop_assert!(down.is_empty(), "{down:?} never released");
    prop_assert!(
        axes.iter().all(|value| *value == 0.0),
        "{axes:?} not at rest"
    );
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: CASES, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_profiles_and_touches((toml, script, cut) in (profile(), script(), any::<prop::sample::Index>())) {
        let profile = Profile::from_toml("random", &toml);
        prop_assert!(profile.is_ok(), "{}\n{toml}", profile.unwrap_err());
        let profile = Arc::new(profile.expect("just seen"));
        let end_ns = script.last().map_or(0, |(t_ns, _)| *t_ns);
        let events = play(&profile, &script, Batching::Frames);
        // Every press has its release, nothing is pressed twice, nothing is shorter than the floor.
        follow(&events, end_ns, true)?;
        // Outputs that should not outlast their touches are released with them, not only at the end.
        if !["toggle", "sticky"].iter().any(|outlasts| toml.contains(outlasts)) {
            prop_assert_eq!(left_down(&profile, &script), vec![]);
        }
        // The same events, bit for bit, however the frames are batched.
        prop_assert_eq!(&events, &play(&profile, &script, Batching::Frames));
        prop_assert_eq!(&events, &play(&profile, &script, Batching::Ticks));
        // A resting arm is recognized by its largest part, so there a frame must stay whole.
        if profile.settings.rest_area_mm2.is_none() {
            prop_assert_eq!(&events, &play(&profile, &script, Batching::Changes));
        }
        // Nothing stays held, whichever frame is the last.
        let head = &script[..=cut.index(script.len())];
        let end_ns = head.last().map_or(0, |(t_ns, _)| *t_ns);
        follow(&play(&profile, head, Batching::Ticks), end_ns, true)?;
    }
}
