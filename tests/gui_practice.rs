//! The practice view by its accessibility labels, and the level played through the gesture engine.
#![cfg(feature = "gui")]

use std::sync::Arc;

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use gelpad::gesture::Gestures;
use gelpad::gui::practice::{Practice, PracticeTab, PracticeView, RunStage, SOLUTION};
use gelpad::gui::still;
use gelpad::profile::{Profile, SHIPPED_PROFILES, shipped_profile};
use gelpad::types::{Contact, Event, NANOS_PER_MS, Nanos, Phase, PointMm, Touch, TouchId};

const PAD_MM: [f64; 2] = [100.0, 100.0];
/// Centres of super-mario's regions, mm.
const RIGHT: PointMm = [37.0, 57.0];
const JUMP: PointMm = [81.0, 52.0];

fn profile(name: &str) -> Profile {
    let shipped = shipped_profile(name).expect("shipped");
    Profile::from_toml(shipped.name, shipped.toml).expect("sound")
}

fn practice() -> Practice {
    let mut practice = Practice::default();
    practice.set_profile(&profile("super-mario"));
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

/// Events of a profile while one finger holds right and another one jumps along the solution.
fn events(name: &str) -> Vec<Event> {
    let mut gestures = Gestures::new(Arc::new(profile(name)), PAD_MM);
    let mut events = Vec::new();
    let start_ns = 1000 * NANOS_PER_MS;
    gestures.touches(
        start_ns,
        &[touch(0, Phase::Down, RIGHT, start_ns)],
        &mut events,
    );
    for (id, (at_ms, long_ms)) in (1..).zip(SOLUTION) {
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

/// Plays events for some seconds with 60 repaints a second.
fn play(practice: &mut Practice, events: &[Event], seconds: f64) {
    let (mut next, mut t_s) = (0, 0.0);
    while t_s < seconds {
        t_s += 1.0 / 60.0;
        while events
            .get(next)
            .is_some_and(|event| event.t_ns as f64 * 1e-9 <= t_s)
        {
            practice.push_event(&events[next]);
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
        RunStage::Done { best: true },
        "at {:?}",
        practice.player_px()
    );
    assert_eq!(practice.jumps().len(), SOLUTION.len());
}

#[test]
fn the_first_message_names_the_regions_to_press() {
    let mut harness = harness(practice(), [1000.0, 640.0]);
    harness.run();
    harness.get_by_label_contains("“right” on the pad to walk, “jump” to jump");
    harness.get_by_label_contains("no jump yet");
}

#[test]
fn nothing_is_repainted_before_the_first_press() {
    // `run` ends when nothing asks for a repaint.
    let mut harness = harness(practice(), [1000.0, 640.0]);
    assert!(harness.run() < 4);
}

#[test]
fn the_end_shows_time_and_best_time() {
    let mut done = practice();
    play(&mut done, &events("super-mario"), 45.0);
    let best = done.best_s().expect("finished");
    let mut harness = harness(done, [1000.0, 640.0]);
    harness.run();
    harness.get_by_label_contains("your best");
    harness.get_by_label(&format!("best {best:.1} s"));
}

#[test]
fn restart_works_by_mouse_and_by_keyboard() {
    for by_keyboard in [false, true] {
        let mut done = practice();
        play(&mut done, &events("super-mario"), 45.0);
        let mut harness = harness(done, [1000.0, 640.0]);
        harness.run();
        let button = harness.get_by_label("Restart");
        if by_keyboard {
            button.focus();
            harness.run();
            harness.key_press(egui::Key::Enter);
        } else {
            button.click();
        }
        harness.run();
        assert_eq!(harness.state().practice.stage(), RunStage::Ready);
        assert!(
            harness.state().practice.best_s().is_some(),
            "the best time stays"
        );
    }
}

#[test]
fn auto_walk_needs_only_jumps() {
    let mut harness = harness(practice(), [1000.0, 640.0]);
    harness.run();
    harness.get_by_label("Auto-walk").click();
    harness.run();
    harness.get_by_label_contains("Press “jump” on the pad");
    assert!(harness.query_by_label_contains("to walk").is_none());
    let practice = &mut harness.state_mut().practice;
    assert!(practice.auto_walk());
    let from = practice.player_px()[0];
    let jumps: Vec<Event> = events("super-mario").into_iter().skip(1).take(2).collect();
    play(practice, &jumps, 5.0);
    assert!(practice.player_px()[0] > from + 60.0);
}

#[test]
fn the_last_press_length_is_shown() {
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
            practice.set_profile(&profile(shipped.name));
            play(&mut practice, &events("super-mario"), 3.0);
            let mut harness = harness(practice, size);
            harness.run_steps(3);
        }
    }
}

#[test]
fn events_of_the_game_play_the_level_once() {
    let mut tab = PracticeTab::default();
    let mut view = still::view();
    let events = events("super-mario");
    tab.play_new_events(&view);
    for (count, event) in (1..).zip(&events) {
        view.events = [*event].into();
        view.events_so_far = count;
        tab.play_new_events(&view);
        tab.play_new_events(&view);
    }
    assert_eq!(view.events_so_far as usize, events.len());
    tab.practice.advance(0.1);
    assert_ne!(tab.practice.stage(), RunStage::Ready);
    // Another game counts its events from 0.
    view.events = [events[0]].into();
    view.events_so_far = 1;
    tab.play_new_events(&view);
}
