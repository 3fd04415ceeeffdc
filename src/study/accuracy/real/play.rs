//! One session: rest, presses with rests between, every frame disturbed; what the sensing made of it.

use std::collections::BTreeMap;

use super::board::Board;
use super::{Condition, Extent, Hand, Surroundings};
use crate::study::PressBound;
use crate::study::accuracy::Bench;
use crate::study::accuracy::noise::share;
use crate::study::accuracy::score::{REACH_MM, assign};
use crate::study::accuracy::sensed::{FRAME_NS, Sensed};
use crate::touch::SensingBuilder;
use crate::types::{Nanos, PointMm};

/// Frames before the first press, ...
const REST_FRAMES: usize = 400;
/// ... and before the pad as found comes in.
const FOUND_FRAMES: usize = 350;
/// Frames for which a finger lies on the pad from the start.
const LYING_FRAMES: usize = 100;
/// Presses while drumming, of two minutes.
const DRUMMED: usize = 1200;
/// Frames of each press, and of each rest, of a drumming hand.
const DRUM_FRAMES: usize = 5;
/// A touch that is still down this many frames after the last finger lifted is stuck.
const STUCK_FRAMES: usize = 50;

/// One press, solved: a single stage while it lasts, or one for each of its frames.
pub(super) struct Press {
    pub stages: Vec<Stage>,
}

/// A press at one moment.
pub(super) struct Stage {
    /// Where its fingers are.
    pub centres_mm: Vec<PointMm>,
    /// Readings, V/A.
    pub volts: Vec<f64>,
    /// Least errors of place of its fingers with noise as large as each reading; none where it is not known.
    pub bounds: Vec<PressBound>,
}

impl Press {
    fn stage(&self, frame: usize) -> &Stage {
        &self.stages[frame.min(self.stages.len() - 1)]
    }
}

/// One pad, solved at rest and under each press.
pub(super) struct Solved {
    pub rest: Vec<f64>,
    pub presses: Vec<Press>,
    /// What the surroundings change at their full size, relative to each reading; empty if nothing.
    pub surrounded: Vec<f64>,
}

/// What became of a session.
#[derive(Clone, Debug, Default)]
pub(super) struct Played {
    /// Fingers that pressed.
    pub fingers: usize,
    /// Presses.
    pub presses: usize,
    /// Presses in whose last frame as many touches were down as fingers; of a moving hand, throughout and one touch a finger.
    pub counted_right: usize,
    /// Fingers that were not found in the first frame of their press.
    pub late: usize,
    /// Fingers that were never found while they pressed.
    pub missed: usize,
    /// Presses after which a touch is down half a second after the lift, where that is looked at.
    pub stuck: usize,
    /// Touches that were never within reach of a finger.
    pub false_touches: usize,
    /// Errors of place in the frame in which a finger was first found, mm.
    pub first_errors_mm: Vec<f64>,
    /// Errors of place in the last frame of the press, mm; of a moving hand, in all but its first.
    pub last_errors_mm: Vec<f64>,
    /// The least that errors of place in one frame can be in the mean, mm, where white noise is all that disturbs.
    pub bounds_mm: Vec<f64>,
    /// Longest time of a touch without a finger, ms.
    pub longest_ms: f64,
    /// Seconds played.
    pub seconds: f64,
}

/// The sensing under test, with the disturbed readings of one pad.
struct Session<'a> {
    bench: &'a Bench,
    hand: Hand,
    surroundings: Surroundings,
    surrounded: &'a [f64],
    board: Board,
    sensed: Sensed<'a>,
    /// Touches that were once within reach of a finger.
    matched: BTreeMap<u64, bool>,
    /// For touches without a finger: since when.
    alone_since: BTreeMap<u64, Nanos>,
    played: Played,
}

/// Plays a condition on one pad. `found` is the sensing of the pad as found, unless its drawing stays in use.
pub(super) fn session(
    bench: &Bench,
    condition: &Condition,
    extent: Extent,
    solved: &Solved,
    found: Option<&SensingBuilder>,
    seed: u64,
) -> Played {
    let (rest, mut presses) = (&solved.rest[..], &solved.presses[..]);
    let rhythm = condition.hand.rhythm();
    let mut session = Session {
        bench,
        hand: condition.hand,
        surroundings: condition.surroundings,
        surrounded: &solved.surrounded,
        board: Board::new(condition, rest, &bench.pad.protocol, seed),
        sensed: Sensed::new(bench.sensing.new_detector(), bench.sensing.builder()),
        matched: BTreeMap::new(),
        alone_since: BTreeMap::new(),
        played: Played::default(),
    };
    let resting = if presses.is_empty() {
        extent.untouched_s * 100
    } else {
        REST_FRAMES
    };
    if let (Hand::FingerAfterLying, [lying, others @ ..]) = (condition.hand, presses) {
        for _ in 0..LYING_FRAMES {
            session.step(&lying.stage(0).volts, &[]);
        }
        presses = others;
    }
    for frame in 0..resting {
        session.step(rest, &[]);
        if let Some(found) = found.filter(|_| frame == FOUND_FRAMES) {
            session.sensed.change_pad(found);
        }
    }
    if let Hand::SeveralAfterDrumming(_) = condition.hand {
        session.drum(rest, presses);
    }
    for press in presses {
        session.press(press, rhythm.press_frames);
        if condition.disturbances.is_empty() {
            let noise = share(condition.snr_db);
            let bounds = press.stages.iter().flat_map(|stage| &stage.bounds);
            let bounds_mm = bounds.map(|bound| bound.with_noise(noise).mean_mm());
            let reach_mm = REACH_MM * bench.scale;
            let played = &mut session.played.bounds_mm;
            played.extend(bounds_mm.map(|mm| mm.min(reach_mm)));
        }
        for pause in 1..=rhythm.pause_frames {
            session.step(rest, &[]);
            let is_down = !session.sensed.detector.touches_down().is_empty();
            session.played.stuck += usize::from(pause == STUCK_FRAMES && is_down);
        }
    }
    let matched = session.matched.values();
    session.played.false_touches = matched.filter(|matched| !**matched).count();
    session.played.seconds = session.board.now_s();
    session.played
}

impl Session<'_> {
    /// Presses and rests in turn, fast, without scoring places.
    fn drum(&mut self, rest: &[f64], presses: &[Press]) {
        for press in presses.iter().cycle().take(DRUMMED) {
            let stage = press.stage(0);
            for _ in 0..DRUM_FRAMES {
                self.step(&stage.volts, &stage.centres_mm);
            }
            for _ in 0..DRUM_FRAMES {
                self.step(rest, &[]);
            }
        }
    }

    /// Plays one press and scores it.
    fn press(&mut self, press: &Press, frames: usize) {
        let count = press.stages[0].centres_mm.len();
        let is_moving = self.hand.is_moving();
        let mut first: Vec<Option<f64>> = vec![None; count];
        let mut ids: Vec<u64> = Vec::new();
        for index in 0..frames {
            let stage = press.stage(index);
            let errors = self.step(&stage.volts, &stage.centres_mm);
            for (kept, error) in first.iter_mut().zip(&errors) {
                *kept = kept.or(*error);
            }
            if index == 0 {
                self.played.late += errors.iter().filter(|error| error.is_none()).count();
            }
            ids.extend(
                self.sensed
                    .detector
                    .touches_down()
                    .iter()
                    .map(|touch| touch.id.0),
            );
            let is_last = index + 1 == frames;
            if is_last || is_moving && index > 0 {
                self.played.last_errors_mm.extend(errors.iter().flatten());
            }
            if is_last {
                ids.sort_unstable();
                ids.dedup();
                let down = self.sensed.detector.touches_down().len();
                let is_whole = !is_moving || ids.len() == count;
                let is_right = down == count && errors.iter().all(Option::is_some) && is_whole;
                self.played.counted_right += usize::from(is_right);
            }
        }
        self.played.presses += 1;
        self.played.fingers += count;
        self.played.missed += first.iter().filter(|error| error.is_none()).count();
        self.played.first_errors_mm.extend(first.iter().flatten());
    }

    /// Plays one frame; returns for each finger how far off it was found.
    fn step(&mut self, volts: &[f64], fingers: &[PointMm]) -> Vec<Option<f64>> {
        let share = self.surroundings.share(self.board.now_s());
        let mut surrounded = volts.to_vec();
        for (volt, change) in surrounded.iter_mut().zip(self.surrounded) {
            *volt *= 1.0 + share * change;
        }
        let frame = self.board.read(&surrounded);
        self.sensed.process(&frame);
        let down = self.sensed.detector.touches_down().to_vec();
        let seen: Vec<PointMm> = down.iter().map(|touch| touch.contact.centre_mm).collect();
        let assigned = assign(fingers, &seen, REACH_MM * self.bench.scale);
        for (index, touch) in down.iter().enumerate() {
            let id = touch.id.0;
            let is_matched = assigned.contains(&Some(index));
            let ever = self.matched.entry(id).or_default();
            *ever |= is_matched;
            if is_matched {
                self.alone_since.remove(&id);
            } else {
                self.alone_since.entry(id).or_insert(frame.t_ns);
            }
        }
        self.alone_since
            .retain(|id, _| down.iter().any(|touch| touch.id.0 == *id));
        for since in self.alone_since.values() {
            let ms = (frame.t_ns + FRAME_NS - since) as f64 * 1e-6;
            self.played.longest_ms = self.played.longest_ms.max(ms);
        }
        fingers
            .iter()
            .zip(assigned)
            .map(|(finger, index)| {
                index.map(|index| {
                    libm::hypot(finger[0] - seen[index][0], finger[1] - seen[index][1])
                })
            })
            .collect()
    }
}
