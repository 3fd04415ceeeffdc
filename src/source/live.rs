//! The simulated pad under live fingers: what a mouse, a touch screen or a test presses goes through the forward model.
//!
//! ```text
//! Hand ─fingers─▶ thread that solves ─voltages─▶ LiveSource ─frames, 100 a second─▶
//! ```
//! Frames never wait for the solver: until the new voltages are there the old ones are read on, as from a board. Both
//! queues are bounded; of moves that wait only the newest is solved, but no finger that comes or goes is left out. Coming and
//! going are shown equally late, by what solving has taken lately: the length of a press is kept.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use rtrb::{Consumer, Producer, PushError, RingBuffer};

use super::{Finger, Noise, Pace, Reading, SimulatedPad, Source, SourceError};
use crate::pad::Pad;
use crate::types::{Frame, NANOS_PER_MS, Nanos};

/// 100 frames a second.
const FRAME_NS: Nanos = 10 * NANOS_PER_MS;
/// States of the fingers that may wait to be solved.
const HAND_QUEUE: usize = 64;
/// Solved states that may wait to be read.
const SOLVED_QUEUE: usize = 8;
/// Frames for which fingers stay as they are before one more comes or goes: no finger taps shorter than 30 ms, but a mouse does.
const SHORTEST_TAP_FRAMES: u64 = 3;
/// Fingers that come or go are shown as late as the slowest of so many were, but not later than this.
const LAGS: usize = 12;
const LONGEST_LAG: Duration = Duration::from_millis(250);
/// Solved states that are kept: a place that is pressed again need not be solved again.
const KEPT: usize = 64;
/// Longest sleep: what a shut-down waits for at most.
const NAP: Duration = Duration::from_millis(50);

/// What presses the live pad. Dropping it ends the source.
#[derive(Debug)]
pub struct Hand {
    fingers: Producer<Pressed>,
    /// A state that found the queue full.
    waiting: Option<Pressed>,
    resting: Arc<AtomicBool>,
    solver: std::thread::Thread,
}

impl Hand {
    /// Presses with these fingers from now on, and with no other.
    pub fn press(&mut self, fingers: &[Finger]) {
        self.waiting = Some(Pressed {
            fingers: fingers.to_vec(),
            at: clock(),
        });
        self.flush();
    }

    /// Tries again to hand over what found no room; whether all is handed over.
    pub fn flush(&mut self) -> bool {
        let Some(pressed) = self.waiting.take() else {
            return true;
        };
        if let Err(PushError::Full(back)) = self.fingers.push(pressed) {
            self.waiting = Some(back);
        }
        self.solver.unpark();
        self.waiting.is_none()
    }

    /// Lets the pad rest: it sends no frames; or wakes it.
    pub fn rest(&mut self, resting: bool) {
        self.resting.store(resting, Ordering::Relaxed);
    }

    /// Whether the pad rests.
    #[must_use]
    pub fn is_resting(&self) -> bool {
        self.resting.load(Ordering::Relaxed)
    }
}

/// A state of the fingers, and since when it is so.
#[derive(Clone, Debug)]
struct Pressed {
    fingers: Vec<Finger>,
    at: Instant,
}

/// Voltages of one state of the fingers.
struct Solved {
    volts: Arc<Vec<f64>>,
    /// When it may be read, if not at once.
    due: Option<Instant>,
    /// Which fingers press.
    ids: Vec<u64>,
}

/// The live pad as a source.
pub struct LiveSource {
    solved: Consumer<Solved>,
    next: Option<Solved>,
    now: Solved,
    /// Frames since a finger came or went.
    steady_frames: u64,
    resting: Arc<AtomicBool>,
    start: Option<Instant>,
    frame: u64,
    noise: Noise,
    stop: Arc<AtomicBool>,
    solver: Option<JoinHandle<()>>,
}

impl LiveSource {
    /// A live pad, and the hand that presses it.
    ///
    /// # Errors
    /// A pad that cannot be solved; no thread to solve it on.
    pub fn new(pad: &Pad, noise: Noise) -> Result<(Self, Hand), SourceError> {
        let simulated = SimulatedPad::new(pad)?;
        let rest = simulated.volts(&[])?;
        let (fingers_in, fingers) = RingBuffer::new(HAND_QUEUE);
        let (solved_in, solved) = RingBuffer::new(SOLVED_QUEUE);
        let stop = Arc::new(AtomicBool::new(false));
        let resting = Arc::new(AtomicBool::new(false));
        let stopping = Arc::clone(&stop);
        let solver = Builder::new()
            .name("forward".to_owned())
            .spawn(move || solve_all(&simulated, fingers, solved_in, &stopping))
            .map_err(|error| SourceError::File {
                path: "the simulated pad".into(),
                error,
            })?;
        let hand = Hand {
            fingers: fingers_in,
            waiting: None,
            resting: Arc::clone(&resting),
            solver: solver.thread().clone(),
        };
        let source = Self {
            solved,
            next: None,
            now: Solved {
                volts: Arc::new(rest),
                due: None,
                ids: Vec::new(),
            },
            steady_frames: SHORTEST_TAP_FRAMES,
            resting,
            start: None,
            frame: 0,
            noise,
            stop,
            solver: Some(solver),
        };
        Ok((source, hand))
    }

    /// Goes on to the newest state that may be shown.
    fn take_solved(&mut self) {
        self.steady_frames += 1;
        loop {
            if self.next.is_none() {
                self.next = self.solved.pop().ok();
            }
            let Some(next) = &self.next else { return };
            let same = next.ids == self.now.ids;
            if !same && self.steady_frames < SHORTEST_TAP_FRAMES {
                return;
            }
            if next.due.is_some_and(|due| due > clock()) {
                return;
            }
            if !same {
                self.steady_frames = 0;
            }
            if let Some(next) = self.next.take() {
                self.now = next;
            }
        }
    }
}

impl Source for LiveSource {
    fn pace(&self) -> Pace {
        Pace::ByDevice
    }

    fn read(&mut self) -> Result<Reading, SourceError> {
        if self.resting.load(Ordering::Relaxed) {
            self.start = None;
            std::thread::sleep(NAP);
            return Ok(Reading::Idle);
        }
        if self.solved.is_abandoned() {
            return Ok(Reading::End);
        }
        let first = self.frame;
        let start = *self
            .start
            .get_or_insert_with(|| clock() - Duration::from_nanos(first * FRAME_NS));
        self.frame += 1;
        let due = start + Duration::from_nanos(self.frame * FRAME_NS);
        let early = due.saturating_duration_since(clock());
        if early.is_zero() {
            // The machine was asleep or busy: frames that nobody read are gone, as a board's would be.
            let behind = clock().saturating_duration_since(due).as_nanos();
            self.frame += u64::try_from(behind).unwrap_or(0) / FRAME_NS;
        } else {
            std::thread::sleep(early);
        }
        self.take_solved();
        Ok(Reading::Frame(Frame {
            t_ns: self.frame * FRAME_NS,
            volts: self.noise.read(&self.now.volts),
        }))
    }
}

impl Drop for LiveSource {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(solver) = self.solver.take() {
            solver.thread().unpark();
            // A solver that panicked has been told of.
            let _ = solver.join();
        }
    }
}

#[allow(clippy::disallowed_methods, reason = "a device keeps its own time")]
fn clock() -> Instant {
    Instant::now()
}

fn solve_all(
    pad: &SimulatedPad,
    mut pressed: Consumer<Pressed>,
    mut solved: Producer<Solved>,
    stop: &AtomicBool,
) {
    let mut known: VecDeque<(Vec<Finger>, Arc<Vec<f64>>)> = VecDeque::new();
    let mut lags: VecDeque<Duration> = VecDeque::new();
    let mut last_ids: Vec<u64> = Vec::new();
    while !stop.load(Ordering::Relaxed) {
        let Some(state) = newest_of_run(&mut pressed) else {
            if pressed.is_abandoned() {
                return;
            }
            std::thread::park_timeout(NAP);
            continue;
        };
        let kept = known
            .iter()
            .find(|(fingers, _)| are_alike(fingers, &state.fingers));
        let volts = match kept {
            Some((_, volts)) => Arc::clone(volts),
            None => match pad.volts(&state.fingers) {
                Ok(volts) => {
                    let volts = Arc::new(volts);
                    known.push_back((state.fingers.clone(), Arc::clone(&volts)));
                    volts
                }
                Err(error) => {
                    tracing::error!("the simulated pad cannot be pressed like that: {error}");
                    continue;
                }
            },
        };
        if known.len() > KEPT {
            known.pop_front();
        }
        let ids = ids(&state.fingers);
        let mut due = None;
        if ids != last_ids {
            lags.push_back(state.at.elapsed().min(LONGEST_LAG));
            if lags.len() > LAGS {
                lags.pop_front();
            }
            due = lags.iter().max().map(|lag| state.at + *lag);
            last_ids.clone_from(&ids);
        }
        let mut next = Solved { volts, due, ids };
        while let Err(PushError::Full(back)) = solved.push(next) {
            if stop.load(Ordering::Relaxed) || solved.is_abandoned() {
                return;
            }
            next = back;
            std::thread::park_timeout(Duration::from_millis(2));
        }
    }
}

/// Whether the pad reads the same: fingers of other numbers at the same places.
fn are_alike(a: &[Finger], b: &[Finger]) -> bool {
    a.len() == b.len()
        && a.iter()
            .zip(b)
            .all(|(a, b)| Finger { id: 0, ..*a } == Finger { id: 0, ..*b })
}

/// The next state, or the newest of those that follow with the same fingers; pressed since the first of them.
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
    use super::*;
    use crate::pad::{DEFAULT_PAD, shipped_pad};

    fn finger(id: u64, x: f64) -> Finger {
        Finger {
            id,
            centre_mm: [x, 50.0],
            radius_mm: 7.0,
            rise: 1.2,
        }
    }

    fn pad() -> Pad {
        Pad::from_toml("p", shipped_pad(DEFAULT_PAD).expect("shipped").toml).expect("sound")
    }

    fn frame(source: &mut LiveSource) -> Frame {
        loop {
            match source.read().expect("a reading") {
                Reading::Frame(frame) => return frame,
                Reading::Idle => {}
                other => panic!("{other:?}"),
            }
        }
    }

    #[test]
    fn of_moves_only_the_newest_is_solved_but_no_finger_is_left_out() {
        let (mut producer, mut consumer) = RingBuffer::new(16);
        for state in [
            vec![finger(1, 20.0)],
            vec![finger(1, 30.0)],
            vec![],
            vec![finger(2, 40.0)],
        ] {
            let pressed = Pressed {
                fingers: state,
                at: clock(),
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

    #[test]
    fn a_click_shorter_than_a_frame_is_still_a_tap_of_thirty_milliseconds() {
        let (mut source, mut hand) = LiveSource::new(&pad(), Noise::new(300.0, 1)).expect("a pad");
        let rest = frame(&mut source).volts;
        hand.press(&[finger(1, 50.0)]);
        hand.press(&[]);
        // On a busy machine the tap may take longer, but it is never shorter, and it ends.
        let mut touched = (0..1000)
            .map(|_| frame(&mut source).volts != rest)
            .skip_while(|touched| !touched);
        let long = touched.by_ref().take_while(|touched| *touched).count();
        assert!(long >= 3, "{long} frames of 10 ms");
        assert_eq!(touched.next(), Some(false));
    }

    #[test]
    fn times_go_on_after_a_rest_and_the_source_ends_without_its_hand() {
        let (mut source, mut hand) = LiveSource::new(&pad(), Noise::new(60.0, 1)).expect("a pad");
        let before = frame(&mut source).t_ns;
        hand.rest(true);
        assert_eq!(source.read().expect("a reading"), Reading::Idle);
        hand.rest(false);
        let after = frame(&mut source).t_ns;
        assert!(after > before, "{after} {before}");
        drop(hand);
        let ends = (0..1000).any(|_| source.read().expect("a reading") == Reading::End);
        assert!(ends);
    }
}
