use super::controls::{Controls, GameAction};
use super::level::TILE;
use super::*;
use crate::profile::{DEFAULT_PROFILE, Profile, shipped_profile};
use crate::types::{Action, Event, NANOS_PER_MS, Output};
use proptest::prelude::*;

fn profile() -> Profile {
    let shipped = shipped_profile(DEFAULT_PROFILE).expect("shipped");
    Profile::from_toml(shipped.name, shipped.toml).expect("sound")
}

fn practice() -> Practice {
    let mut practice = Practice::default();
    practice.set_profile(&profile());
    practice
}

fn output(game_action: GameAction) -> Output {
    Controls::from_profile(&profile())
        .output(game_action)
        .expect("bound")
}

fn event(t_ms: u64, down: bool, game_action: GameAction) -> Event {
    let output = output(game_action);
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

/// The events of the solution.
fn solution() -> Vec<Event> {
    let mut events = vec![event(1000, true, GameAction::Right)];
    for (at_ms, long_ms) in SOLUTION {
        events.push(event(1000 + at_ms, true, GameAction::Jump));
        events.push(event(1000 + at_ms + long_ms, false, GameAction::Jump));
    }
    events
}

/// Plays events in a window that is repainted `draws_per_s` times a second.
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
            practice.push_event(&events[next]);
            next += 1;
        }
        practice.advance(1.0 / draws_per_s);
    }
    practice
}

#[test]
fn the_solution_finishes_the_level() {
    let practice = play(&solution(), 60.0, 45.0);
    let RunStage::Done { best } = practice.stage() else {
        panic!(
            "at {:?} after {} falls",
            practice.body.place, practice.falls
        );
    };
    assert!(best);
    assert_eq!(practice.falls, 0);
    assert_eq!(practice.best_s(), Some(practice.time_s()));
    let taken = practice.coins_taken.iter().filter(|taken| **taken).count();
    assert!(taken > 3, "{taken} coins on the way");
}

#[test]
fn jumps_report_press_length_and_height() {
    for (long_ms, tiles) in [(83, 34.0 / 16.0), (333, 60.0 / 16.0), (600, 66.0 / 16.0)] {
        let events = [
            event(500, true, GameAction::Jump),
            event(500 + long_ms, false, GameAction::Jump),
        ];
        let practice = play(&events, 60.0, 3.0);
        let jump = *practice.jumps().next_back().expect("a jump");
        assert!((jump.held_ms - long_ms as f64).abs() < 1e-9, "{jump:?}");
        assert!((jump.height_px / TILE - tiles).abs() < 0.2, "{jump:?}");
        assert!(jump.released && jump.peaked && !jump.running);
    }
}

#[test]
fn the_repaint_rate_does_not_change_jump_heights() {
    let events = [
        event(1010, true, GameAction::Jump),
        event(1060, false, GameAction::Jump),
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
    // One step of tolerance.
    assert!((often - seldom).abs() < 3.0, "{often} {seldom}");
}

#[test]
fn a_jump_after_the_end_restarts_and_keeps_the_best_time() {
    let mut practice = play(&solution(), 60.0, 45.0);
    let best = practice.best_s();
    practice.push_event(&event(45_020, true, GameAction::Jump));
    practice.advance(0.1);
    assert_eq!(practice.stage(), RunStage::Ready);
    assert_eq!(practice.best_s(), best);
    assert!(practice.coins_taken.iter().all(|taken| !taken));
}

#[test]
fn a_fall_continues_at_a_checkpoint_with_the_clock_running() {
    let practice = play(&[event(500, true, GameAction::Right)], 60.0, 12.0);
    assert!(
        practice.falls > 0 || practice.body.place[0] < 260.0,
        "{:?}",
        practice.body.place
    );
    assert_eq!(practice.stage(), RunStage::Running);
}

proptest! {
    #[test]
    fn any_events_at_any_rate_keep_the_player_in_the_level(
        presses in proptest::collection::vec((0u64..4000, 0usize..4, any::<bool>()), 0..80),
        draws in proptest::collection::vec(0.0..0.5f64, 1..80),
    ) {
        let actions = [GameAction::Left, GameAction::Right, GameAction::Run, GameAction::Jump];
        let mut practice = practice();
        let mut presses = presses.into_iter();
        for dt_s in draws {
            if let Some((t_ms, game_action, down)) = presses.next() {
                practice.push_event(&event(t_ms, down, actions[game_action]));
            }
            practice.advance(dt_s);
            let [x, y] = practice.body.place;
            prop_assert!(x.is_finite() && y > level::BOTTOM - 20.0 && x <= practice.level.width());
        }
    }
}
