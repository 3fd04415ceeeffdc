//! Records the three guided presses of a board whose numbering is not known. Contacts cannot be located yet, so the pad
//! counts as pressed while its readings differ from their level by more than their noise explains.
//!
//! ```text
//! readings  ~~~~~~~~~~~~~/~~~~~~~~~~\~~~~~~~~~~
//! state     rest | waiting | pressed | waiting
//! ```

use std::collections::VecDeque;

use super::solver::{Orientation, OrientationError, OrientationSolver};
use crate::calibrate::press_recorder::{PressRecorder, RecordedPress, Touching};
use crate::calibrate::presses::Press;
use crate::types::{Frame, PointMm};

/// Frames of the untouched pad that give level and noise.
const REST_FRAMES: usize = 30;
/// Frames whose mean is compared with the level.
const WINDOW_FRAMES: usize = 6;
/// The pad is pressed while the readings differ from their level by this many times what noise explains ...
const PRESSED: f64 = 1.6;
/// ... and released below this. Noise alone stays below 1.2 with a hundred readings.
const RELEASED: f64 = 1.35;
/// The level moves by this share of the difference in each frame of the untouched pad, to follow drift.
const FOLLOW_SHARE: f64 = 0.02;
/// Least relative noise of a reading: one that never changes does not show its noise.
const LEAST_DEVIATION: f64 = 1e-5;
/// Frames of a press that are averaged at most.
const MEAN_FRAMES: usize = 200;

/// What is needed next.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// The untouched pad is being measured: it must not be touched.
    Resting,
    /// Waiting for the press at this place.
    Press {
        /// Number of the press, 0 to 2.
        number: usize,
        /// The place, mm.
        place_mm: PointMm,
    },
    /// The pad is pressed and can be released.
    Pressed {
        /// Number of the press, 0 to 2.
        number: usize,
    },
    /// All three presses are recorded.
    Done(Result<Orientation, OrientationError>),
}

/// Records three guided presses, then finds the orientation.
#[derive(Clone, Debug)]
pub struct GuidedPressRecorder {
    solver: OrientationSolver,
    rest: Vec<Vec<f64>>,
    /// Mean of each reading on the untouched pad.
    level: Vec<f64>,
    /// Relative noise of each reading.
    deviations: Vec<f64>,
    window: VecDeque<Vec<f64>>,
    is_pressed: bool,
    recorder: PressRecorder,
    presses: Vec<Press>,
    result: Option<Result<Orientation, OrientationError>>,
}

impl GuidedPressRecorder {
    /// A recorder that first measures the untouched pad.
    #[must_use]
    pub fn new(solver: OrientationSolver) -> Self {
        Self {
            solver,
            rest: Vec::with_capacity(REST_FRAMES),
            level: Vec::new(),
            deviations: Vec::new(),
            window: VecDeque::with_capacity(WINDOW_FRAMES),
            is_pressed: false,
            recorder: PressRecorder::averaging(MEAN_FRAMES),
            presses: Vec::with_capacity(3),
            result: None,
        }
    }

    /// Takes a frame.
    ///
    /// # Panics
    /// If it has another number of readings than the pad.
    pub fn take_frame(&mut self, frame: &Frame) -> Progress {
        assert_eq!(frame.volts.len(), self.solver.channels());
        if let Some(result) = &self.result {
            return Progress::Done(result.clone());
        }
        let volts: Vec<f64> = frame.volts.iter().map(|volt| f64::from(*volt)).collect();
        if self.rest.len() < REST_FRAMES {
            self.rest.push(volts);
            if self.rest.len() == REST_FRAMES {
                self.measure_rest();
            }
            return self.progress();
        }
        let changes: Vec<f64> = volts
            .iter()
            .zip(&self.level)
            .map(|(volt, level)| (volt - level) / level)
            .collect();
        self.window.push_back(changes.clone());
        if self.window.len() > WINDOW_FRAMES {
            self.window.pop_front();
        }
        let strength = self.strength();
        if self.is_pressed && strength < RELEASED {
            self.is_pressed = false;
            self.window.clear();
        } else if !self.is_pressed && strength > PRESSED && self.window.len() == WINDOW_FRAMES {
            self.is_pressed = true;
        } else if !self.is_pressed {
            for (level, volt) in self.level.iter_mut().zip(&volts) {
                *level += FOLLOW_SHARE * (volt - *level);
            }
        }
        self.record(changes);
        self.progress()
    }

    /// Passes a frame to the press recorder; the third press gives the result.
    fn record(&mut self, changes: Vec<f64>) {
        let touching = if self.is_pressed {
            Touching::One(None)
        } else {
            Touching::Nothing
        };
        let shown_mm = self.solver.places_mm()[self.presses.len()];
        if let RecordedPress::Complete(press) =
            self.recorder.take_frame(touching, changes, shown_mm)
        {
            self.presses.push(press);
        }
        if let [a, b, c] = &self.presses[..] {
            self.result = Some(self.solver.find([a, b, c], &self.deviations));
        }
    }

    fn progress(&self) -> Progress {
        let number = self.presses.len();
        if let Some(result) = &self.result {
            Progress::Done(result.clone())
        } else if self.rest.len() < REST_FRAMES {
            Progress::Resting
        } else if self.is_pressed {
            Progress::Pressed { number }
        } else {
            Progress::Press {
                number,
                place_mm: self.solver.places_mm()[number],
            }
        }
    }

    fn measure_rest(&mut self) {
        let count = self.rest.len() as f64;
        let column = |channel: usize| self.rest.iter().map(move |frame| frame[channel]);
        let channels = self.solver.channels();
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

    /// Difference of the last frames' mean from the level, over what noise explains: about 1 for an untouched pad.
    fn strength(&self) -> f64 {
        let frames = self.window.len() as f64;
        // The level has an error of its own.
        let share = 1.0 / frames + 1.0 / REST_FRAMES as f64;
        let (mut sum, mut count) = (0.0, 0.0);
        for (channel, deviation) in self.deviations.iter().enumerate() {
            let changes = self.window.iter().map(|changes| changes[channel]);
            let difference = changes.sum::<f64>() / frames / deviation;
            if difference.is_finite() {
                sum += difference * difference / share;
                count += 1.0;
            }
        }
        libm::sqrt(sum / f64::max(count, 1.0))
    }
}
