//! What the parts of a frame show beside the touches that are down: sums for a new finger at each of many places, and for the lift of
//! each finger.
//!
//! For a response r, readings x and variances v, a part adds sum r x / v and sum r r / v. Over the last parts, the response with
//! amplitude a = B / A explains B B / A squared deviations: a likelihood ratio for every place and every moment of onset.

use super::readings::PartReadings;
use crate::touch::Detector;
use crate::types::Part;

/// A change that explains this many squared deviations, but is not accepted, is unclear.
const UNCLEAR_GAIN: f64 = 30.0;
/// A new finger is seen in at least so many parts, ...
pub(super) const ONSET_PARTS: usize = 3;
/// ... and its amplitude, relative to a typical one, is at least this.
const LEAST_AMPLITUDE: f64 = 0.05;
/// A lift is seen in at least so many parts, ...
const LIFT_PARTS: usize = 2;
/// ... and this share of the finger's response, or more, is gone.
const GONE_SHARE: f64 = 0.6;

/// The sums of one part.
#[derive(Clone, Debug, Default)]
struct PartSums {
    readings: PartReadings,
    /// For each response: sums of r x / v and of r r / v.
    along: Vec<f32>,
    square: Vec<f32>,
    /// Scratch memory: sums of r / v.
    sum: Vec<f32>,
    /// Sum of x x / v.
    energy: f64,
    /// Sum of x / v, and the share of its square that shared noise explains.
    mean: f32,
    shared_share: f32,
}

/// The parts since the detector last ran.
#[derive(Clone, Debug, Default)]
pub(super) struct Evidence {
    /// Oldest first; sums beyond `count` are scratch memory.
    parts: Vec<PartSums>,
    count: usize,
    /// Responses of the fingers that are down, channels each.
    held: Vec<Vec<f32>>,
    /// What the best change explains.
    best_gain: f64,
    /// The best new finger and the best lift.
    onset: Option<Candidate>,
    lift: Option<Candidate>,
    /// For each response, its sums over the last parts.
    along: Vec<f32>,
    square: Vec<f32>,
}

/// The response that explains most of the last parts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Candidate {
    /// Its index: places first, then the fingers that are down.
    pub(super) response: usize,
    /// How many parts it is seen in.
    pub(super) parts: usize,
    /// Its factor: 1 for what is expected, -1 for a finger that has lifted.
    pub(super) amplitude: f64,
    /// The squared deviations that it explains, ...
    pub(super) gain: f64,
    /// ... of so many, ...
    pub(super) energy: f64,
    /// ... in so many readings.
    pub(super) readings: usize,
}

impl Evidence {
    /// Forgets the parts.
    pub(super) fn clear(&mut self) {
        self.count = 0;
        self.best_gain = 0.0;
        self.onset = None;
        self.lift = None;
    }

    /// Takes over the fingers that are down.
    pub(super) fn set_held(&mut self, detector: &Detector) {
        let before = self.held.len();
        detector.responses(&mut self.held);
        if self.held.len() != before {
            self.clear();
        }
    }

    /// The response of a finger that is down.
    pub(super) fn held(&self, index: usize) -> &[f32] {
        &self.held[index]
    }

    /// Number of fingers that are down.
    pub(super) fn held_count(&self) -> usize {
        self.held.len()
    }

    /// Whether something changed that is not yet clear.
    pub(super) fn is_unclear(&self) -> bool {
        self.best_gain > UNCLEAR_GAIN
    }

    /// The best new finger, if there is one.
    pub(super) fn onset(&self) -> Option<Candidate> {
        self.onset
    }

    /// The best lift of a finger, by its index among those that are down.
    pub(super) fn lift(&self) -> Option<Candidate> {
        self.lift
    }

    /// The squared deviations that a response explains in the last `parts` parts, and its amplitude.
    pub(super) fn gain(&self, response: usize, parts: usize) -> (f64, f64) {
        let (mut along, mut square) = (0.0, 0.0);
        for part in self.last(parts) {
            along += f64::from(part.along[response]);
            square += f64::from(part.square[response]);
        }
        match along > 0.0 && square > 0.0 {
            true => (along * along / square, along / square),
            false => (0.0, 0.0),
        }
    }

    /// Whether a channel was read in the last `parts` parts.
    pub(super) fn contains(&self, parts: usize, channel: usize) -> bool {
        self.last(parts)
            .iter()
            .any(|part| part.readings.span().contains(&channel))
    }

    /// The readings of the last `parts` parts.
    pub(super) fn readings(&self, parts: usize) -> impl Iterator<Item = &PartReadings> + Clone {
        self.last(parts).iter().map(|part| &part.readings)
    }

    fn last(&self, parts: usize) -> &[PartSums] {
        &self.parts[self.count - parts.min(self.count)..self.count]
    }

    /// Adds a part. `responses` are those of a finger at many `places`, channels x places; `expected` is the relative change of a
    /// channel by the touches that are down.
    pub(super) fn add(
        &mut self,
        detector: &Detector,
        (responses, places): (&[f32], usize),
        part: &Part,
        expected: impl Fn(usize) -> f32,
    ) {
        let most = detector.channels().div_ceil(part.volts.len().max(1));
        if self.count >= most {
            self.parts[..self.count].rotate_left(1);
            self.count -= 1;
        }
        if self.parts.len() <= self.count {
            self.parts.push(PartSums::default());
        }
        let sums = &mut self.parts[self.count];
        sums.readings.take(detector, part, expected);
        sums.project(detector);
        sums.add_places(responses, places);
        self.held
            .iter()
            .for_each(|response| sums.add_response(response));
        self.count += 1;
        self.find_best(places);
    }

    /// The best responses, over any number of the last parts. The first `places` are those of new fingers.
    fn find_best(&mut self, places: usize) {
        let responses = places + self.held.len();
        self.along.clear();
        self.along.resize(responses, 0.0);
        self.square.clear();
        self.square.resize(responses, 0.0);
        (self.best_gain, self.onset, self.lift) = (0.0, None, None);
        let (mut energy, mut readings) = (0.0, 0);
        let parts = std::mem::take(&mut self.parts);
        for (before, part) in parts[..self.count].iter().rev().enumerate() {
            energy += part.energy;
            readings += part.readings.changes.len();
            let added = part.along.iter().zip(&part.square);
            let sums = self.along.iter_mut().zip(&mut self.square);
            let mut is_large = false;
            for ((along, square), (more_along, more_square)) in sums.zip(added) {
                *along += more_along;
                *square += more_square;
                is_large |= *along * *along > UNCLEAR_GAIN as f32 * *square;
            }
            // Most parts show noise only.
            if is_large {
                let seen = Candidate {
                    parts: before + 1,
                    energy,
                    readings,
                    ..Candidate::default()
                };
                self.take_large(places, seen);
            }
        }
        self.parts = parts;
        if let Some(lift) = &mut self.lift {
            lift.response -= places;
        }
    }

    /// Compares the sums over the parts of `seen` with the best so far.
    fn take_large(&mut self, places: usize, seen: Candidate) {
        for (response, (along, square)) in self.along.iter().zip(&self.square).enumerate() {
            let (along, square) = (f64::from(*along), f64::from(*square));
            let power = along * along;
            // Gains are compared without division: only the best is divided.
            if power > self.best_gain * square {
                self.best_gain = power / square;
            }
            let (best, is_wanted) = if response < places {
                let is_wanted = seen.parts >= ONSET_PARTS && along > LEAST_AMPLITUDE * square;
                (&mut self.onset, is_wanted)
            } else {
                let is_wanted = seen.parts >= LIFT_PARTS && along < -GONE_SHARE * square;
                (&mut self.lift, is_wanted)
            };
            let before = best.map_or(0.0, |best| best.gain);
            if is_wanted && power > before * square {
                *best = Some(Candidate {
                    response,
                    amplitude: along / square,
                    gain: power / square,
                    ..seen
                });
            }
        }
    }
}

impl PartSums {
    /// Starts the sums. Noise that the readings of a part share is projected out.
    fn project(&mut self, detector: &Detector) {
        let shared = detector.reference().shared_noise();
        let shared = shared.gain + shared.drive;
        let PartReadings {
            changes,
            precisions,
            ..
        } = &self.readings;
        let precision: f64 = precisions.iter().map(|p| f64::from(*p)).sum();
        self.shared_share = (shared / (1.0 + shared * precision)) as f32;
        let weighted = changes.iter().zip(precisions);
        self.mean = weighted.clone().map(|(x, p)| x * p).sum();
        let energy: f64 = weighted.map(|(x, p)| f64::from(x * x * p)).sum();
        self.energy = energy - f64::from(self.shared_share * self.mean * self.mean);
        self.along.clear();
        self.square.clear();
    }

    /// Adds the sums of a finger at many places, at all of them together: the responses are channels x places.
    fn add_places(&mut self, responses: &[f32], places: usize) {
        self.along.resize(places, 0.0);
        self.square.resize(places, 0.0);
        self.sum.clear();
        self.sum.resize(places, 0.0);
        let rows = responses.chunks_exact(places.max(1));
        let rows = rows.skip(self.readings.first);
        let readings = self.readings.changes.iter().zip(&self.readings.precisions);
        for (row, (x, p)) in rows.zip(readings) {
            let xp = x * p;
            let sums = self
                .along
                .iter_mut()
                .zip(&mut self.square)
                .zip(&mut self.sum);
            for (r, ((along, square), sum)) in row.iter().zip(sums) {
                *along += r * xp;
                *square += r * r * p;
                *sum += r * p;
            }
        }
        let sums = self.along.iter_mut().zip(&mut self.square).zip(&self.sum);
        for ((along, square), sum) in sums {
            *along -= self.shared_share * sum * self.mean;
            *square = (*square - self.shared_share * sum * sum).max(0.0);
        }
    }

    /// Adds the sums of a response, one relative change per channel of the pad.
    fn add_response(&mut self, response: &[f32]) {
        let (mut along, mut square, mut sum) = (0.0f32, 0.0f32, 0.0f32);
        let readings = self.readings.changes.iter().zip(&self.readings.precisions);
        for (r, (x, p)) in response[self.readings.span()].iter().zip(readings) {
            along += r * x * p;
            square += r * r * p;
            sum += r * p;
        }
        self.along.push(along - self.shared_share * sum * self.mean);
        self.square
            .push((square - self.shared_share * sum * sum).max(0.0));
    }
}
