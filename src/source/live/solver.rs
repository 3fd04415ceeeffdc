//! The thread that solves the forward model for the live pad.
//!
//! Of waiting moves only the newest is solved, but no finger that comes or goes is skipped. Fingers that come and fingers
//! that go are shown with the same delay, the longest of the last solutions, so that the length of a press is kept.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rtrb::{Consumer, Producer, PushError};

use super::NAP;
use crate::eit::Press;
use crate::source::{Finger, SimulatedPad};

/// Number of solutions whose longest delay is used, and its limit.
const DELAYS: usize = 12;
const LONGEST_DELAY: Duration = Duration::from_millis(250);
/// Solved states that are kept: a place that is pressed again need not be solved again.
const KEPT_STATES: usize = 64;

/// A state of the fingers and when it began.
#[derive(Clone, Debug)]
pub(super) struct Pressed {
    pub(super) fingers: Vec<Finger>,
    pub(super) at: Instant,
}

/// Voltages of one state of the fingers.
pub(super) struct Solved {
    pub(super) volts: Arc<Vec<f64>>,
    /// When it may be read; none: immediately.
    pub(super) due: Option<Instant>,
    /// Ids of the fingers that press.
    pub(super) ids: Vec<u64>,
}

/// Solves the newest of each run of states with the same fingers, until `stop` is set or the sender is gone.
pub(super) fn solve_all(
    pad: &SimulatedPad,
    mut pressed: Consumer<Pressed>,
    mut solved: Producer<Solved>,
    stop: &AtomicBool,
) {
    let mut solver = Solver {
        pad,
        solved: VecDeque::new(),
        solve_delays: VecDeque::new(),
        last_ids: Vec::new(),
    };
    while !stop.load(Ordering::Relaxed) {
        let Some(state) = newest_of_run(&mut pressed) else {
            if pressed.is_abandoned() {
                return;
            }
            std::thread::park_timeout(NAP);
            continue;
        };
        let Some(mut next) = solver.solve(&state) else {
            continue;
        };
        while let Err(PushError::Full(back)) = solved.push(next) {
            if stop.load(Ordering::Relaxed) || solved.is_abandoned() {
                return;
            }
            next = back;
            std::thread::park_timeout(Duration::from_millis(2));
        }
    }
}

struct Solver<'a> {
    pad: &'a SimulatedPad,
    solved: VecDeque<(Vec<Press>, Arc<Vec<f64>>)>,
    /// Delays of the last states in which a finger came or went.
    solve_delays: VecDeque<Duration>,
    last_ids: Vec<u64>,
}

impl Solver<'_> {
    /// Solves one state; none if the forward model has no solution for it.
    fn solve(&mut self, state: &Pressed) -> Option<Solved> {
        let volts = self.volts(&state.fingers)?;
        let ids = ids(&state.fingers);
        let mut due = None;
        if ids != self.last_ids {
            self.solve_delays
                .push_back(state.at.elapsed().min(LONGEST_DELAY));
            if self.solve_delays.len() > DELAYS {
                self.solve_delays.pop_front();
            }
            due = self
                .solve_delays
                .iter()
                .max()
                .map(|delay| state.at + *delay);
            self.last_ids.clone_from(&ids);
        }
        Some(Solved { volts, due, ids })
    }

    fn volts(&mut self, fingers: &[Finger]) -> Option<Arc<Vec<f64>>> {
        let presses: Vec<Press> = fingers.iter().map(|finger| finger.press).collect();
        if let Some((_, volts)) = self.solved.iter().find(|(solved, _)| *solved == presses) {
            return Some(Arc::clone(volts));
        }
        let volts = self
            .pad
            .volts(&presses)
            .inspect_err(|error| tracing::error!("the simulated pad cannot be solved: {error}"));
        let volts = Arc::new(volts.ok()?);
        self.solved.push_back((presses, Arc::clone(&volts)));
        if self.solved.len() > KEPT_STATES {
            self.solved.pop_front();
        }
        Some(volts)
    }
}

/// The next state, or the newest of the states after it with the same fingers; it keeps the time of the first.
fn newest_of_run(pressed: &mut Consumer<Pressed>) -> Option<Pressed> {
    let mut state = pressed.pop().ok()?;
    while let Ok(next) = pressed.peek() {
        if ids(&next.fingers) != ids(&state.fingers) {
            break;
        }
        state.fingers = pressed.pop().ok()?.fingers;
    }
    Some(state)
}

fn ids(fingers: &[Finger]) -> Vec<u64> {
    fingers.iter().map(|finger| finger.id).collect()
}

#[cfg(test)]
mod tests {
    use rtrb::RingBuffer;

    use super::*;
    use crate::source::clock::now;

    fn finger(id: u64, x: f64) -> Finger {
        Finger {
            id,
            press: Press {
                centre_mm: [x, 50.0],
                radius_mm: 7.0,
                rise: 1.2,
            },
        }
    }

    #[test]
    fn only_the_newest_move_is_solved_but_no_finger_is_skipped() {
        let (mut producer, mut consumer) = RingBuffer::new(16);
        for state in [
            vec![finger(1, 20.0)],
            vec![finger(1, 30.0)],
            vec![],
            vec![finger(2, 40.0)],
        ] {
            let pressed = Pressed {
                fingers: state,
                at: now(),
            };
            producer.push(pressed).expect("room");
        }
        let states: Vec<Vec<Finger>> = std::iter::from_fn(|| newest_of_run(&mut consumer))
            .map(|pressed| pressed.fingers)
            .collect();
        assert_eq!(
            states,
            [vec![finger(1, 30.0)], vec![], vec![finger(2, 40.0)]]
        );
    }
}
