//! One session: rest, presses with rests between, every frame disturbed; what the sensing made of it.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{Condition, Extent, Hand, Surroundings};
use crate::source::{Disturber, Noise};
use crate::study::StudyError;
use crate::study::accuracy::Bench;
use crate::study::accuracy::score::{REACH_MM, assign};
use crate::touch::Detector;
use crate::types::{Frame, NANOS_PER_MS, Nanos, PointMm, Touch};

/// A hundred frames a second, as in play.
const FRAME_NS: Nanos = 10 * NANOS_PER_MS;
/// Frames before the first press.
const REST_FRAMES: usize = 400;
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
    detector: Detector,
    noise: Noise,
    disturber: Disturber,
    frame: usize,
    changed: Vec<Touch>,
    /// Touches that were once within reach of a finger.
    matched: BTreeMap<u64, bool>,
    /// For touches without a finger: since which frame.
    alone_since: BTreeMap<u64, usize>,
    played: Played,
}

/// Plays a condition on one pad.
pub(super) fn session(
    bench: &Bench,
    condition: &Condition,
    extent: Extent,
    solved: &Solved,
    seed: u64,
) -> Result<Played, StudyError> {
    let (rest, mut presses) = (&solved.rest[..], &solved.presses[..]);
    let rhythm = condition.hand.rhythm();
    let mut session = Session {
        bench,
        hand: condition.hand,
        surroundings: condition.surroundings,
        surrounded: &solved.surrounded,
        detector: bench.sensing.new_detector(),
        noise: Noise::new(condition.snr_db, seed),
        disturber: Disturber::new(
            &condition.disturbances,
            rest,
            &bench.pad.protocol,
            seed ^ 0x5eed,
        ),
        frame: 0,
        changed: Vec::new(),
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
            session.step(&lying.stage(0).volts, &[])?;
        }
        presses = others;
    }
    for _ in 0..resting {
        session.step(rest, &[])?;
    }
    if let Hand::SeveralAfterDrumming(_) = condition.hand {
        session.drum(rest, presses)?;
    }
    for press in presses {
        session.press(press, rhythm.press_frames)?;
        for pause in 1..=rhythm.pause_frames {
            session.step(rest, &[])?;
            let is_down = !session.detector.touches_down().is_empty();
            session.played.stuck += usize::from(pause == STUCK_FRAMES && is_down);
        }
    }
    let matched = session.matched.values();
    session.played.false_touches = matched.filter(|matched| !**matched).count();
    session.played.seconds = session.frame as f64 * FRAME_NS as f64 * 1e-9;
    Ok(session.played)
}

impl Session<'_> {
    /// Presses and rests in turn, fast, without scoring places.
    fn drum(&mut self, rest: &[f64], presses: &[Press]) -> Result<(), StudyError> {
        for press in presses.iter().cycle().take(DRUMMED) {
            let stage = press.stage(0);
            for _ in 0..DRUM_FRAMES {
                self.step(&stage.volts, &stage.centres_mm)?;
            }
            for _ in 0..DRUM_FRAMES {
                self.step(rest, &[])?;
            }
        }
        Ok(())
    }

    /// Plays one press and scores it.
    fn press(&mut self, press: &Press, frames: usize) -> Result<(), StudyError> {
        let count = press.stages[0].centres_mm.len();
        let is_moving = self.hand.is_moving();
        let mut first: Vec<Option<f64>> = vec![None; count];
        let mut ids: Vec<u64> = Vec::new();
        for index in 0..frames {
            let stage = press.stage(index);
            let errors = self.step(&stage.volts, &stage.centres_mm)?;
            for (kept, error) in first.iter_mut().zip(&errors) {
                *kept = kept.or(*error);
            }
            if index == 0 {
                self.played.late += errors.iter().filter(|error| error.is_none()).count();
            }
            ids.extend(self.detector.touches_down().iter().map(|touch| touch.id.0));
            let is_last = index + 1 == frames;
            if is_last || is_moving && index > 0 {
                self.played.last_errors_mm.extend(errors.iter().flatten());
            }
            if is_last {
                ids.sort_unstable();
                ids.dedup();
                let down = self.detector.touches_down().len();
                let is_whole = !is_moving || ids.len() == count;
                let is_right = down == count && errors.iter().all(Option::is_some) && is_whole;
                self.played.counted_right += usize::from(is_right);
            }
        }
        self.played.presses += 1;
        self.played.fingers += count;
        self.played.missed += first.iter().filter(|error| error.is_none()).count();
        self.played.first_errors_mm.extend(first.iter().flatten());
        Ok(())
    }

    /// Plays one frame; returns for each finger how far off it was found.
    fn step(&mut self, volts: &[f64], fingers: &[PointMm]) -> Result<Vec<Option<f64>>, StudyError> {
        let t_s = self.frame as f64 * FRAME_NS as f64 * 1e-9;
        let share = self.surroundings.share(t_s);
        let mut surrounded = volts.to_vec();
        for (volt, change) in surrounded.iter_mut().zip(self.surrounded) {
            *volt *= 1.0 + share * change;
        }
        let mut read: Vec<f64> = self
            .noise
            .read(&surrounded)
            .iter()
            .map(|volt| f64::from(*volt))
            .collect();
        let t_ns = self.frame as Nanos * FRAME_NS;
        self.disturber.apply(t_s, &mut read);
        let volts = read.iter().map(|volt| *volt as f32).collect();
        self.changed.clear();
        self.detector
            .process_frame(&Frame { t_ns, volts }, &mut self.changed);
        if let Some(wanted) = self.detector.wanted() {
            // As in play: where no weights can be made, the present ones stay.
            if let Ok(sensing) = self.bench.sensing.build(wanted) {
                self.detector.set_sensing(Arc::new(sensing));
            }
        }
        let down = self.detector.touches_down().to_vec();
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
                self.alone_since.entry(id).or_insert(self.frame);
            }
        }
        self.alone_since
            .retain(|id, _| down.iter().any(|touch| touch.id.0 == *id));
        for since in self.alone_since.values() {
            let ms = (self.frame + 1 - since) as f64 * 10.0;
            self.played.longest_ms = self.played.longest_ms.max(ms);
        }
        self.frame += 1;
        Ok(fingers
            .iter()
            .zip(assigned)
            .map(|(finger, index)| {
                index.map(|index| {
                    libm::hypot(finger[0] - seen[index][0], finger[1] - seen[index][1])
                })
            })
            .collect())
    }
}
