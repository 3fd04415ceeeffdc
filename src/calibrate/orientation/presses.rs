//! Takes the three presses from the frames of a board whose numbering is not known: nothing can be located yet, so a press
//! is a change of the readings over their own noise.
//!
//! ```text
//! readings  ~~~~~~~~~~~~~/~~~~~~~~~~\~~~~~~~~~~
//! state     rest | waiting | pressed | waiting      a press is taken when it is over
//! ```

use std::collections::VecDeque;

use super::{Orienter, ShownPress, WhichWay, WhichWayError};
use crate::types::{Frame, PointMm};

/// Frames of the untouched pad from which level and noise are taken.
const REST_FRAMES: usize = 30;
/// Frames whose mean is held against the level.
const WINDOW: usize = 6;
/// The readings are off their level by so many times what noise explains while the pad is pressed; below the second, it is
/// left alone. Noise alone stays below 1.2 with a hundred readings.
const PRESSED: f64 = 1.6;
const RELEASED: f64 = 1.35;
/// Share by which the level follows each frame of the untouched pad: drift.
const FOLLOW: f64 = 0.02;
/// No reading is less noisy than this, relative: one that does not move at all tells nothing of the noise.
const LEAST_DEVIATION: f64 = 1e-5;
/// Frames of a press that are kept: the first ones that count.
const MOST_FRAMES: usize = 200;
/// A frame counts if it is pressed at least this hard beside the press's hardest: not while the finger comes and goes.
const HARD_SHARE: f64 = 0.7;
/// A press of fewer frames is a brush.
const FEWEST_FRAMES: usize = 4;

/// What a frame has brought.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// The untouched pad is being read: leave it alone.
    Resting,
    /// Waits for the press at this place.
    Press {
        /// 0 to 2.
        number: usize,
        /// Where, mm.
        place_mm: PointMm,
    },
    /// It is being pressed; let go.
    Pressed {
        /// 0 to 2.
        number: usize,
    },
    /// All three are taken.
    Done(Result<WhichWay, WhichWayError>),
}

/// Three presses being taken.
#[derive(Clone, Debug)]
pub struct ThreePresses {
    orienter: Orienter,
    rest: Vec<Vec<f64>>,
    level: Vec<f64>,
    deviations: Vec<f64>,
    window: VecDeque<Vec<f64>>,
    pressed: Option<Vec<Vec<f64>>>,
    taken: Vec<ShownPress>,
    done: Option<Result<WhichWay, WhichWayError>>,
}

impl ThreePresses {
    /// Waits for the pad to be at rest, then for the first press.
    #[must_use]
    pub fn new(orienter: Orienter) -> Self {
        Self {
            orienter,
            rest: Vec::with_capacity(REST_FRAMES),
            level: Vec::new(),
            deviations: Vec::new(),
            window: VecDeque::with_capacity(WINDOW),
            pressed: None,
            taken: Vec::with_capacity(3),
            done: None,
        }
    }

    /// Begins anew.
    pub fn restart(&mut self) {
        self.rest.clear();
        self.window.clear();
        self.pressed = None;
        self.taken.clear();
        self.done = None;
    }

    /// Takes a frame.
    ///
    /// # Panics
    /// If it has another number of readings than the pad.
    pub fn frame(&mut self, frame: &Frame) -> Progress {
        assert_eq!(frame.volts.len(), self.orienter.channels);
        if let Some(done) = &self.done {
            return Progress::Done(done.clone());
        }
        let volts: Vec<f64> = frame.volts.iter().map(|volt| f64::from(*volt)).collect();
        if self.rest.len() < REST_FRAMES {
            self.rest.push(volts);
            if self.rest.len() == REST_FRAMES {
                self.learn_rest();
            }
            return self.progress();
        }
        let changes: Vec<f64> = volts
            .iter()
            .zip(&self.level)
            .map(|(volt, level)| (volt - level) / level)
            .collect();
        self.window.push_back(changes.clone());
        if self.window.len() > WINDOW {
            self.window.pop_front();
        }
        let strength = self.strength();
        match &mut self.pressed {
            Some(press) if strength < RELEASED => {
                let press = std::mem::take(press);
                self.pressed = None;
                self.take(&press);
            }
            Some(press) => {
                if press.len() < MOST_FRAMES {
                    press.push(changes);
                }
            }
            None if strength > PRESSED && self.window.len() == WINDOW => {
                self.pressed = Some(vec![changes]);
            }
            None => {
                for (level, volt) in self.level.iter_mut().zip(&volts) {
                    *level += FOLLOW * (volt - *level);
                }
            }
        }
        self.progress()
    }

    fn progress(&self) -> Progress {
        let number = self.taken.len();
        match (&self.done, &self.pressed) {
            (Some(done), _) => Progress::Done(done.clone()),
            _ if self.rest.len() < REST_FRAMES => Progress::Resting,
            (None, Some(_)) => Progress::Pressed { number },
            (None, None) => Progress::Press {
                number,
                place_mm: self.orienter.places_mm[number],
            },
        }
    }

    fn learn_rest(&mut self) {
        let count = self.rest.len() as f64;
        let column = |channel: usize| self.rest.iter().map(move |frame| frame[channel]);
        let channels = self.orienter.channels;
        self.level = (0..channels)
            .map(|channel| column(channel).sum::<f64>() / count)
            .collect();
        self.deviations = (0..channels)
            .map(|channel| {
                let level = self.level[channel];
                let square: f64 = column(channel).map(|v| (v - level) * (v - level)).sum();
                (libm::sqrt(square / (count - 1.0)) / level.abs()).max(LEAST_DEVIATION)
            })
            .collect();
    }

    /// How far the last frames' mean is off the level, in what noise explains: about 1 for an untouched pad.
    fn strength(&self) -> f64 {
        let frames = self.window.len() as f64;
        // The level's own error counts too.
        let share = 1.0 / frames + 1.0 / REST_FRAMES as f64;
        let (mut sum, mut count) = (0.0, 0.0);
        for (channel, deviation) in self.deviations.iter().enumerate() {
            let mean = self
                .window
                .iter()
                .map(|change| change[channel])
                .sum::<f64>()
                / frames;
            let off = mean / deviation;
            if off.is_finite() {
                sum += off * off / share;
                count += 1.0;
            }
        }
        libm::sqrt(sum / f64::max(count, 1.0))
    }

    /// Takes a press that is over, and looks which way round the pad is after the third.
    fn take(&mut self, press: &[Vec<f64>]) {
        self.window.clear();
        let hard = |change: &Vec<f64>| {
            let square = |(change, deviation): (&f64, &f64)| {
                let off = change / deviation;
                if off.is_finite() { off * off } else { 0.0 }
            };
            let sum: f64 = change.iter().zip(&self.deviations).map(square).sum();
            libm::sqrt(sum)
        };
        let hardest = press.iter().map(hard).fold(0.0, f64::max);
        let kept: Vec<&Vec<f64>> = press
            .iter()
            .filter(|change| hard(change) >= HARD_SHARE * hardest)
            .collect();
        if kept.len() < FEWEST_FRAMES {
            return;
        }
        let changes = (0..self.orienter.channels)
            .map(|channel| {
                kept.iter().map(|change| change[channel]).sum::<f64>() / kept.len() as f64
            })
            .collect();
        self.taken.push(ShownPress {
            place_mm: self.orienter.places_mm[self.taken.len()],
            changes,
        });
        if let [a, b, c] = &self.taken[..] {
            let presses = [a.clone(), b.clone(), c.clone()];
            self.done = Some(self.orienter.find(&presses, &self.deviations));
        }
    }
}
