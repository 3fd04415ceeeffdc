//! The practice view by its labels, and the level played through the real gestures.
#![cfg(feature = "gui")]

use std::sync::Arc;

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use gelpad::gesture::Gestures;
use gelpad::gui::practice::{A_WAY, Practice, PracticeTab, PracticeView, Stage};
use gelpad::gui::still;
use gelpad::profile::{Profile, SHIPPED_PROFILES, shipped_profile};
use gelpad::types::{Contact, Event, NANOS_PER_MS, Nanos, Phase, PointMm, Touch, TouchId};

const PAD_MM: [f64; 2] = [100.0, 100.0];
/// Middles of super-mario's regions, mm.
const RIGHT: PointMm = [37.0, 57.0];
const JUMP: PointMm = [81.0, 52.0];

fn profile(name: &str) -> Profile {
    let shipped = shipped_profile(name).expect("shipped");
    Profile::from_toml(shipped.name, shipped.toml).expect("sound")
}

fn practice() -> Practice {
    let mut practice = Practice::default();
    practice.follow(&profile("super-mario"));
    practice
}

fn touch(id: u64, phase: Phase, centre_mm: PointMm, since_ns: Nanos) -> Touch {
    Touch {
        id: TouchId(id),
        phase,
        since_ns,
        contact: Contact {
            centre_mm,
            area_mm2: 150.0,
            force: 0.5,
            confidence: 1.0,
        },
    }
}

/// Events of fingers that walk to the right and jump all the way, by a profile on the pad.
fn events(name: &str) -> Vec<Event> {
    let mut gestures = Gestures::new(Arc::new(profile(name)), PAD_MM);
    let mut events = Vec::new();
    let start_ns = 1000 * NANOS_PER_MS;
    gestures.touches(
        start_ns,
        &[touch(0, Phase::Down, RIGHT, start_ns)],
        &mut events,
    );
    for (id, (at_ms, long_ms)) in (1..).zip(A_WAY) {
        let down_ns = start_ns + at_ms * NANOS_PER_MS;
        let up_ns = down_ns + long_ms * NANOS_PER_MS;
        gestures.touches(
            down_ns,
            &[touch(id, Phase::Down, JUMP, down_ns)],
            &mut events,
        );
        gestures.touches(up_ns, &[touch(id, Phase::Up, JUMP, down_ns)], &mut events);
    }
    gestures.tick(60_000 * NANOS_PER_MS, &mut events);
    events
}

/// Plays events with 60 draws a second until a time.
fn play(practice: &mut Practice, events: &[Event], seconds: f64) {
    let (mut next, mut t_s) = (0, 0.0);
    while t_s < seconds {
        t_s += 1.0 / 60.0;
        while events
            .get(next)
            .is_some_and(|event| event.t_ns as f64 * 1e-9 <= t_s)
        {
            practice.event(&events[next]);
            next += 1;
        }
        practice.advance(1.0 / 60.0);
    }
}

struct Shown {
    view: PracticeView,
    practice: Practice,
}

fn harness(practice: Practice, size: [f32; 2]) -> Harness<'static, Shown> {
    let shown = Shown {
        view: PracticeView::default(),
        practice,
    };
    Harness::builder().with_size(size).build_ui_state(
        |ui, shown: &mut Shown| shown.view.ui(ui, &mut shown.practice, None),
        shown,
    )
}

#[test]
fn fingers_on_the_pad_finish_the_level() {
    let mut practice = practice();
    play(&mut practice, &events("super-mario"), 45.0);
    assert_eq!(
        practice.stage(),
        Stage::Done { best: true },
        "at {:?}",
        practice.body().place
    );
    assert_eq!(practice.jumps().len(), A_WAY.len());
}

#[test]
fn before_the_first_press_it_says_which_outputs_play() {
    let mut harness = harness(practice(), [1000.0, 640.0]);
    harness.run();
    harness.get_by_label_contains("“right” on the pad to walk, “jump” to jump");
    harness.get_by_label_contains("no jump yet");
}

#[test]
fn it_stands_still_until_something_is_pressed() {
    // Else `run` would never end.
    let mut harness = harness(practice(), [1000.0, 640.0]);
    assert!(harness.run() < 4);
}

#[test]
fn the_end_tells_the_time_and_the_best() {
    let mut done = practice();
    play(&mut done, &events("super-mario"), 45.0);
    let best = done.best_s().expect("finished");
    let mut harness = harness(done, [1000.0, 640.0]);
    harness.run();
    harness.get_by_label_contains("your best");
    harness.get_by_label(&format!("best {best:.1} s"));
}

#[test]
fn begin_anew_is_pressed_by_mouse_and_by_keyboard() {
    for by_keyboard in [false, true] {
        let mut done = practice();
        play(&mut done, &events("super-mario"), 45.0);
        let mut harness = harness(done, [1000.0, 640.0]);
        harness.run();
        let button = harness.get_by_label("Begin anew");
        if by_keyboard {
            button.focus();
            harness.run();
            harness.key_press(egui::Key::Enter);
        } else {
            button.click();
        }
        harness.run();
        assert_eq!(harness.state().practice.stage(), Stage::Ready);
        assert!(
            harness.state().practice.best_s().is_some(),
            "the best time stays"
        );
    }
}

#[test]
fn walking_by_itself_leaves_only_jumps_to_be_pressed() {
    let mut harness = harness(practice(), [1000.0, 640.0]);
    harness.run();
    harness.get_by_label("Walk by itself").click();
    harness.run();
    harness.get_by_label_contains("Press “jump” on the pad");
    assert!(harness.query_by_label_contains("to walk").is_none());
    let practice = &mut harness.state_mut().practice;
    assert!(practice.walks());
    let from = practice.body().place[0];
    let jumps: Vec<Event> = events("super-mario").into_iter().skip(1).take(2).collect();
    play(practice, &jumps, 5.0);
    assert!(practice.body().place[0] > from + 60.0);
}

#[test]
fn the_length_of_the_last_press_stands_beside_the_height_of_its_jump() {
    let mut practice = practice();
    let jump: Vec<Event> = events("super-mario").into_iter().skip(1).take(2).collect();
    play(&mut practice, &jump, 30.0);
    let last = *practice.jumps().next_back().expect("a jump");
    let mut harness = harness(practice, [1000.0, 640.0]);
    harness.step();
    harness.get_by_label_contains(&format!("pressed {:.0} ms", last.held_ms));
}

#[test]
fn every_shipped_profile_and_every_size_is_drawn() {
    for shipped in SHIPPED_PROFILES {
        for size in [
            [1280.0, 800.0],
            [800.0, 500.0],
            [320.0, 200.0],
            [60.0, 40.0],
        ] {
            let mut practice = Practice::default();
            practice.follow(&profile(shipped.name));
            play(&mut practice, &events("super-mario"), 3.0);
            let mut harness = harness(practice, size);
            harness.run_steps(3);
        }
    }
}

#[test]
fn a_view_of_the_game_plays_the_level_beside_the_pad() {
    let mut tab = PracticeTab::default();
    let mut view = still::view();
    let events = events("super-mario");
    tab.take(&view);
    for (count, event) in (1..).zip(&events) {
        view.events = [*event].into();
        view.events_so_far = count;
        tab.take(&view);
        tab.take(&view);
    }
    assert_eq!(view.events_so_far as usize, events.len());
    tab.practice.advance(0.1);
    assert_ne!(tab.practice.stage(), Stage::Ready);
    // Another game counts its events from none.
    view.events = [events[0]].into();
    view.events_so_far = 1;
    tab.take(&view);
}
