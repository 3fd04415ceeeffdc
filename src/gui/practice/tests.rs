use super::*;
use crate::profile::{DEFAULT_PROFILE, shipped_profile};
use crate::types::{NANOS_PER_MS, Output};
use proptest::prelude::*;

fn profile() -> Profile {
    let shipped = shipped_profile(DEFAULT_PROFILE).expect("shipped");
    Profile::from_toml(shipped.name, shipped.toml).expect("sound")
}

fn practice() -> Practice {
    let mut practice = Practice::default();
    practice.follow(&profile());
    practice
}

fn output(deed: Deed) -> Output {
    Controls::of(&profile()).output(deed).expect("bound")
}

fn event(t_ms: u64, down: bool, deed: Deed) -> Event {
    let output = output(deed);
    let action = if down {
        Action::Press(output)
    } else {
        Action::Release(output)
    };
    Event {
        t_ns: t_ms * NANOS_PER_MS,
        action,
    }
}

/// The script as events, in order.
fn script() -> Vec<Event> {
    let mut events = vec![event(1000, true, Deed::Right)];
    for (at_ms, long_ms) in A_WAY {
        events.push(event(1000 + at_ms, true, Deed::Jump));
        events.push(event(1000 + at_ms + long_ms, false, Deed::Jump));
    }
    events
}

/// Plays events with a window that is drawn so many times a second; the source begins a second before the first event.
fn play(events: &[Event], draws_per_s: f64, seconds: f64) -> Practice {
    let mut practice = practice();
    let mut next = 0;
    let mut t_s = 0.0;
    while t_s < seconds {
        t_s += 1.0 / draws_per_s;
        while events
            .get(next)
            .is_some_and(|event| event.t_ns as f64 * 1e-9 <= t_s)
        {
            practice.event(&events[next]);
            next += 1;
        }
        practice.advance(1.0 / draws_per_s);
    }
    practice
}

#[test]
fn a_script_of_presses_finishes_the_level() {
    let practice = play(&script(), 60.0, 45.0);
    let Stage::Done { best } = practice.stage() else {
        panic!(
            "at {:?} after {} falls",
            practice.body().place,
            practice.falls()
        );
    };
    assert!(best);
    assert_eq!(practice.falls(), 0);
    assert_eq!(practice.best_s(), Some(practice.time_s()));
    let taken = practice.taken().iter().filter(|taken| **taken).count();
    assert!(taken > 3, "{taken} coins on the way");
}

#[test]
fn the_length_of_a_press_is_told_beside_the_height_of_its_jump() {
    for (long_ms, tiles) in [(83, 34.0 / 16.0), (333, 60.0 / 16.0), (600, 66.0 / 16.0)] {
        let events = [
            event(500, true, Deed::Jump),
            event(500 + long_ms, false, Deed::Jump),
        ];
        let practice = play(&events, 60.0, 3.0);
        let jump = *practice.jumps().next_back().expect("a jump");
        assert!((jump.held_ms - long_ms as f64).abs() < 1e-9, "{jump:?}");
        assert!((jump.height_px / TILE - tiles).abs() < 0.2, "{jump:?}");
        assert!(jump.released && jump.peaked && !jump.running);
    }
}

#[test]
fn a_press_that_is_over_before_the_window_is_drawn_still_jumps_by_its_length() {
    let events = [
        event(1010, true, Deed::Jump),
        event(1060, false, Deed::Jump),
    ];
    let often = play(&events, 60.0, 3.0)
        .jumps()
        .next_back()
        .expect("a jump")
        .height_px;
    let seldom = play(&events, 8.0, 3.0)
        .jumps()
        .next_back()
        .expect("a jump")
        .height_px;
    // A step more or less.
    assert!((often - seldom).abs() < 3.0, "{often} {seldom}");
}

#[test]
fn after_the_end_a_jump_begins_anew_and_the_best_time_stays() {
    let mut practice = play(&script(), 60.0, 45.0);
    let best = practice.best_s();
    practice.event(&event(45_020, true, Deed::Jump));
    practice.advance(0.1);
    assert_eq!(practice.stage(), Stage::Ready);
    assert_eq!(practice.best_s(), best);
    assert!(practice.taken().iter().all(|taken| !taken));
}

#[test]
fn a_fall_begins_at_the_last_place_that_stands_and_the_clock_runs_on() {
    let practice = play(&[event(500, true, Deed::Right)], 60.0, 12.0);
    assert!(
        practice.falls() > 0 || practice.body().place[0] < 260.0,
        "{:?}",
        practice.body().place
    );
    assert_eq!(practice.stage(), Stage::Running);
}

proptest! {
    #[test]
    fn no_events_and_no_pace_break_it(
        presses in proptest::collection::vec((0u64..4000, 0usize..4, any::<bool>()), 0..80),
        draws in proptest::collection::vec(0.0..0.5f64, 1..80),
    ) {
        let deeds = [Deed::Left, Deed::Right, Deed::Run, Deed::Jump];
        let mut practice = practice();
        let mut presses = presses.into_iter();
        for dt_s in draws {
            if let Some((t_ms, deed, down)) = presses.next() {
                practice.event(&event(t_ms, down, deeds[deed]));
            }
            practice.advance(dt_s);
            let [x, y] = practice.body().place;
            prop_assert!(x.is_finite() && y > level::BOTTOM - 20.0 && x <= practice.level().width());
        }
    }
}
