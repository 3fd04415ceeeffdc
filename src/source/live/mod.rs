//! The simulated pad under live fingers: presses of a mouse, a touch screen or a test go through the forward model.
//!
//! ```text
//! Hand ─fingers─▶ solver thread ─voltages─▶ LiveSource ─frames, 100 a second─▶
//! ```
//! Frames never wait for the solver (`solver.rs`): until new voltages are ready, the old ones are read. Both
//! queues are bounded.

mod solver;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use rtrb::{Consumer, Producer, PushError, RingBuffer};

use super::clock::now;
use super::{
    Finger, Noise, SIMULATED_FRAME_NS, SimulatedPad, Source, SourceError, SourcePace, SourceReading,
};
use crate::pad::Pad;
use crate::types::Frame;
use solver::{Pressed, Solved, solve_all};

/// States of the fingers that may wait to be solved.
const HAND_QUEUE: usize = 64;
/// Solved states that may wait to be read.
const SOLVED_QUEUE: usize = 8;
/// Minimum number of frames between two changes of the set of fingers. No finger taps shorter than 30 ms, but
/// a mouse does.
const SHORTEST_TAP_FRAMES: u64 = 3;
/// Longest sleep, and so the longest delay of a shut-down.
const NAP: Duration = Duration::from_millis(50);

/// The fingers on the live pad. Dropping it ends the source.
#[derive(Debug)]
pub struct LiveFingers {
    fingers: Producer<Pressed>,
    /// A state that found the queue full.
    waiting: Option<Pressed>,
    resting: Arc<AtomicBool>,
    solver: std::thread::Thread,
}

impl LiveFingers {
    /// From now on exactly these fingers press.
    pub fn set_fingers(&mut self, fingers: &[Finger]) {
        self.waiting = Some(Pressed {
            fingers: fingers.to_vec(),
            at: now(),
        });
        self.flush();
    }

    /// Tries again to queue a state that found no room; returns whether none is waiting.
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

    /// Suspends the pad (it sends no frames) or resumes it.
    pub fn suspend(&mut self, resting: bool) {
        self.resting.store(resting, Ordering::Relaxed);
    }

    /// Whether the pad is suspended.
    #[must_use]
    pub fn is_suspended(&self) -> bool {
        self.resting.load(Ordering::Relaxed)
    }
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
    /// A live pad and its fingers.
    ///
    /// # Errors
    /// The pad cannot be solved, or no thread be started.
    pub fn new(pad: &Pad, noise: Noise) -> Result<(Self, LiveFingers), SourceError> {
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
        let hand = LiveFingers {
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

    /// Advances to the newest state that may be shown.
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
            if next.due.is_some_and(|due| due > now()) {
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
    fn pace(&self) -> SourcePace {
        SourcePace::ByDevice
    }

    fn read(&mut self) -> Result<SourceReading, SourceError> {
        if self.resting.load(Ordering::Relaxed) {
            self.start = None;
            std::thread::sleep(NAP);
            return Ok(SourceReading::Idle);
        }
        if self.solved.is_abandoned() {
            return Ok(SourceReading::End);
        }
        let first = self.frame;
        let start = *self
            .start
            .get_or_insert_with(|| now() - Duration::from_nanos(first * SIMULATED_FRAME_NS));
        self.frame += 1;
        let due = start + Duration::from_nanos(self.frame * SIMULATED_FRAME_NS);
        let early = due.saturating_duration_since(now());
        if early.is_zero() {
            // The computer was asleep or busy: frames that nobody read are lost, as those of a board would be.
            let behind = now().saturating_duration_since(due).as_nanos();
            self.frame += u64::try_from(behind).unwrap_or(0) / SIMULATED_FRAME_NS;
        } else {
            std::thread::sleep(early);
        }
        self.take_solved();
        Ok(SourceReading::Frame(Frame {
            t_ns: self.frame * SIMULATED_FRAME_NS,
            volts: self.noise.read(&self.now.volts),
        }))
    }
}

impl Drop for LiveSource {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(solver) = self.solver.take() {
            solver.thread().unpark();
            // A panic of the solver was already reported.
            let _ = solver.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eit::Press;
    use crate::pad::{DEFAULT_PAD, shipped_pad};

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

    fn pad() -> Pad {
        Pad::from_toml("p", shipped_pad(DEFAULT_PAD).expect("shipped").toml).expect("sound")
    }

    fn frame(source: &mut LiveSource) -> Frame {
        loop {
            match source.read().expect("a reading") {
                SourceReading::Frame(frame) => return frame,
                SourceReading::Idle => {}
                other => panic!("{other:?}"),
            }
        }
    }

    #[test]
    fn a_click_shorter_than_a_frame_is_still_a_tap_of_thirty_milliseconds() {
        let (mut source, mut hand) = LiveSource::new(&pad(), Noise::new(300.0, 1)).expect("a pad");
        let rest = frame(&mut source).volts;
        hand.set_fingers(&[finger(1, 50.0)]);
        hand.set_fingers(&[]);
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
        hand.suspend(true);
        assert_eq!(source.read().expect("a reading"), SourceReading::Idle);
        hand.suspend(false);
        let after = frame(&mut source).t_ns;
        assert!(after > before, "{after} {before}");
        drop(hand);
        let ends = (0..1000).any(|_| source.read().expect("a reading") == SourceReading::End);
        assert!(ends);
    }
}
