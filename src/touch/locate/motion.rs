//! Places of held touches over the frames: a Kalman filter with constant velocity for each touch.
//!
//! A single frame places a touch as well as its noise allows; a finger that stays is placed better by all of its frames. A
//! measurement that the filter does not expect starts it again from there, so that a slide is not delayed, and a new touch is
//! at its first frame's place. (Bar-Shalom, Li and Kirubarajan 2001, sections 5.2 and 6.3: discrete white noise of the
//! acceleration.)

use super::held::HeldMean;
use crate::types::PointMm;

/// How fast a finger is when it lands, mm/s, ...
const LANDING_MM_PER_S: f64 = 20.0;
/// ... and when it has left the place where it was expected.
const MOVING_MM_PER_S: f64 = 500.0;
/// Deviation of the acceleration from one frame to the next, mm/s2.
const ACCELERATION_MM_PER_S2: f64 = 500.0;
/// What a finger that is held still moves between two frames, mm.
const TREMBLE_MM: f64 = 0.03;
/// A measurement is unexpected if its squared distance exceeds this many variances: 1 of 400 by noise.
const UNEXPECTED: f64 = 12.0;
/// The mean of a finger's frames lags if its squared distance from the finger exceeds this many variances.
const LAGS: f64 = 20.0;
/// A finger moves if its squared speed exceeds this many variances, and may creep if it exceeds so many.
const MOVES: f64 = 6.0;
const CREEPS: f64 = 2.0;
/// A finger that moves less than this between two frames is looked for where it was, mm.
const LEAST_STEP_MM: f64 = 1.0;
/// Weight of a frame in the mean of what a touch explains.
const EVIDENCE_WEIGHT: f64 = 0.25;
/// A touch that explains less than this many times what it needs to stay is faint.
const FAINT: f64 = 5.0;
/// A finger lifts if its touch explains less than one in so many of what it explained in the last frames.
const FADES: f64 = 4.0;
/// Places that are so far from the expected one, mm, are another touch's.
const REACH_MM: f64 = 14.0;

/// Place and velocity of a touch along one axis, with their covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axis {
    at_mm: f64,
    mm_per_s: f64,
    /// Variance of the place, mm2.
    place: f64,
    /// Covariance of place and velocity, mm2/s.
    both: f64,
    /// Variance of the velocity, mm2/s2.
    velocity: f64,
}

impl Axis {
    fn new(at_mm: f64, variance_mm2: f64, mm_per_s: f64) -> Self {
        Self {
            at_mm,
            mm_per_s: 0.0,
            place: variance_mm2,
            both: 0.0,
            velocity: mm_per_s * mm_per_s,
        }
    }

    fn advance(&mut self, elapsed_s: f64) {
        self.at_mm += elapsed_s * self.mm_per_s;
        self.place += elapsed_s * (2.0 * self.both + elapsed_s * self.velocity);
        self.both += elapsed_s * self.velocity;
        let kick = elapsed_s * ACCELERATION_MM_PER_S2;
        self.velocity += kick * kick;
        self.both += 0.5 * elapsed_s * kick * kick;
        self.place += 0.25 * elapsed_s * elapsed_s * kick * kick + TREMBLE_MM * TREMBLE_MM;
    }

    fn correct(&mut self, at_mm: f64, variance_mm2: f64) {
        let off_mm = at_mm - self.at_mm;
        let share = self.place / (self.place + variance_mm2);
        let pull = self.both / (self.place + variance_mm2);
        self.at_mm += share * off_mm;
        self.mm_per_s += pull * off_mm;
        self.velocity -= pull * self.both;
        self.place *= 1.0 - share;
        self.both *= 1.0 - share;
    }
}

/// How one touch moves.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Motion {
    axes: [Axis; 2],
    /// What it changed while it did not move.
    held: HeldMean,
    /// What the touch explains as a multiple of what it needs to stay, over the last frames.
    evidence: f64,
    /// Whether it explained too little in the last frame.
    was_weak: bool,
    /// How far the touch is expected to have moved since the last frame.
    step_mm: PointMm,
}

impl Motion {
    /// A touch that was first seen at a place, with the variance of each coordinate, mm2.
    pub(super) fn new(place_mm: PointMm, variances_mm2: [f64; 2]) -> Self {
        Self {
            axes: [0, 1].map(|k| Axis::new(place_mm[k], variances_mm2[k], LANDING_MM_PER_S)),
            held: HeldMean::default(),
            evidence: 1.0,
            was_weak: false,
            step_mm: [0.0; 2],
        }
    }

    /// Takes what the touch explains in a frame, as a multiple of what it needs to stay.
    pub(super) fn weigh(&mut self, stay_ratio: f64) {
        self.evidence += EVIDENCE_WEIGHT * (stay_ratio - self.evidence);
        self.was_weak = stay_ratio < 1.0;
    }

    /// Whether the touch is kept although it explains too little of this frame: it is faint, noise hides a faint touch in some
    /// frames, and the last frame showed it.
    pub(super) fn survives_weak_frame(&self) -> bool {
        self.evidence < FAINT && !self.was_weak
    }

    /// Whether a touch that explains this multiple of what it needs to stay explained far more in the last frames.
    pub(super) fn fades(&self, stay_ratio: f64) -> bool {
        self.evidence > FADES * stay_ratio
    }

    /// The place by all frames so far.
    pub(super) fn place_mm(&self) -> PointMm {
        match self.held.touch() {
            Some(touch) => touch.centre_mm,
            None => self.axes.map(|axis| axis.at_mm),
        }
    }

    /// Takes what the touch changed in a frame: its response and what no touch explains, whitened. Returns the mean of the frames in
    /// which it was held, if there are several.
    pub(super) fn hold(&mut self, response: &[f32], residual: &[f32]) -> Option<&mut HeldMean> {
        if self.is_moving() {
            self.held.clear();
        }
        self.held.add(response, residual);
        (self.held.frames() > 1).then_some(&mut self.held)
    }

    /// Starts the mean of the frames again.
    pub(super) fn forget_held(&mut self) {
        self.held.clear();
    }

    /// Starts the mean again if the finger creeps away from it: it is so far behind a finger that seems to move.
    pub(super) fn leave_lagging_mean(&mut self) {
        let Some(touch) = self.held.touch() else {
            return;
        };
        let mut squared_distance = 0.0;
        let mut along = 0.0;
        for (axis, mean_mm) in self.axes.iter().zip(touch.centre_mm) {
            let behind_mm = axis.at_mm - mean_mm;
            squared_distance += behind_mm * behind_mm / axis.place;
            along += behind_mm * axis.mm_per_s;
        }
        if squared_distance > LAGS && along > 0.0 && self.squared_speed() > CREEPS {
            self.held.clear();
        }
    }

    /// Whether the finger moves more than noise makes it seem to.
    fn is_moving(&self) -> bool {
        self.squared_speed() > MOVES
    }

    /// In units of its variance.
    fn squared_speed(&self) -> f64 {
        let axes = self.axes.iter();
        axes.map(|axis| axis.mm_per_s * axis.mm_per_s / axis.velocity)
            .sum()
    }

    /// Moves the expected place on by a time.
    pub(super) fn advance(&mut self, elapsed_s: f64) {
        self.step_mm = self.axes.map(|axis| elapsed_s * axis.mm_per_s);
        for axis in &mut self.axes {
            axis.advance(elapsed_s);
        }
    }

    /// How far the touch is expected to have moved since the last frame, mm; zero if it hardly moves.
    pub(super) fn step_mm(&self) -> PointMm {
        let [dx, dy] = self.step_mm;
        if libm::hypot(dx, dy) < LEAST_STEP_MM {
            [0.0; 2]
        } else {
            self.step_mm
        }
    }

    /// Distance of a place from the expected one, mm, if it may be this touch's.
    fn distance_mm(&self, place_mm: PointMm) -> Option<f64> {
        let [dx, dy] = [0, 1].map(|k| place_mm[k] - self.axes[k].at_mm);
        let distance_mm = libm::hypot(dx, dy);
        (distance_mm < REACH_MM).then_some(distance_mm)
    }

    /// Corrects the expected place by that of a frame, with the variance of each coordinate, mm2.
    pub(super) fn correct(&mut self, place_mm: PointMm, variances_mm2: [f64; 2]) {
        let surprise: f64 = (0..2)
            .map(|k| {
                let off_mm = place_mm[k] - self.axes[k].at_mm;
                off_mm * off_mm / (self.axes[k].place + variances_mm2[k])
            })
            .sum();
        for k in 0..2 {
            if surprise > UNEXPECTED {
                self.held.clear();
                self.axes[k] = Axis::new(place_mm[k], variances_mm2[k], MOVING_MM_PER_S);
            } else {
                self.axes[k].correct(place_mm[k], variances_mm2[k]);
            }
        }
    }
}

/// The motion whose expected place is nearest to a place, within reach.
pub(super) fn nearest(motions: &[Motion], place_mm: PointMm) -> Option<usize> {
    motions
        .iter()
        .enumerate()
        .filter_map(|(which, motion)| Some((motion.distance_mm(place_mm)?, which)))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, which)| which)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME_S: f64 = 0.01;

    /// Deviation of the noise of [`wobble`], mm.
    const SIGMA_MM: f64 = 0.7;

    /// Noise without a random generator: the same in every run.
    fn wobble(frame: usize) -> f64 {
        SIGMA_MM * std::f64::consts::SQRT_2 * libm::sin(2.399_963 * (frame * frame) as f64)
    }

    #[test]
    fn a_held_finger_is_placed_by_all_of_its_frames() {
        let mut motion = Motion::new([50.0 + wobble(0), 50.0], [SIGMA_MM * SIGMA_MM; 2]);
        let mut squares = 0.0;
        for frame in 1..200 {
            motion.advance(FRAME_S);
            motion.correct([50.0 + wobble(frame), 50.0], [SIGMA_MM * SIGMA_MM; 2]);
            let off_mm = motion.place_mm()[0] - 50.0;
            squares += off_mm * off_mm / 199.0;
        }
        assert!(squares < 0.4 * SIGMA_MM * SIGMA_MM, "{squares}");
    }

    #[test]
    fn a_slide_is_followed_without_delay() {
        let variances = [0.01; 2];
        let mut motion = Motion::new([10.0, 50.0], variances);
        for frame in 1..20 {
            motion.advance(FRAME_S);
            let at_mm = 10.0 + 3.0 * f64::from(frame);
            motion.correct([at_mm, 50.0], variances);
            let lag_mm = at_mm - motion.place_mm()[0];
            assert!(lag_mm.abs() < 0.05, "frame {frame}: {lag_mm} mm");
        }
    }

    #[test]
    fn a_place_out_of_reach_is_another_touch() {
        let motion = Motion::new([10.0, 50.0], [0.01; 2]);
        assert_eq!(motion.distance_mm([40.0, 50.0]), None);
        assert_eq!(motion.distance_mm([13.0, 54.0]), Some(5.0));
    }
}
