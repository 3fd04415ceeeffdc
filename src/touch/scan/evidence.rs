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

/// The sums of one part.
#[derive(Clone, Debug, Default)]
struct PartSums {
    readings: PartReadings,
    /// For each response: sums of r x / v and of r r / v.
    along: Vec<f32>,
    square: Vec<f32>,
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
}

/// The response that explains most of the last parts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    /// Its index: places first, then the fingers that are down.
    pub(super) response: usize,
    /// How many parts it is seen in.
    pub(super) parts: usize,
    /// Its amplitude.
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

    /// Number of responses: places, then fingers that are down.
    pub(super) fn responses(&self) -> usize {
        self.parts[..self.count]
            .last()
            .map_or(0, |part| part.along.len())
    }

    /// Number of fingers that are down.
    pub(super) fn held_count(&self) -> usize {
        self.held.len()
    }

    /// Whether something changed that is not yet clear.
    pub(super) fn is_unclear(&self) -> bool {
        self.best_gain > UNCLEAR_GAIN
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

    /// Adds a part, with the `responses` of a finger at many places. `expected` is the relative change of a channel by the touches that are down.
    pub(super) fn add<'a>(
        &mut self,
        detector: &Detector,
        responses: impl Iterator<Item = &'a [f32]>,
        part: &Part,
        expected: impl Fn(usize) -> f32,
    ) {
        let most = self.expected_parts(detector, part);
        if self.count >= most {
            self.parts[..self.count].rotate_left(1);
            self.count -= 1;
        }
        if self.parts.len() <= self.count {
            self.parts.push(PartSums::default());
        }
        let held = std::mem::take(&mut self.held);
        let sums = &mut self.parts[self.count];
        sums.readings.take(detector, part, expected);
        let sums = &mut self.parts[self.count];
        sums.project(detector);
        responses.for_each(|response| sums.add_response(response));
        held.iter().for_each(|response| sums.add_response(response));
        self.held = held;
        self.count += 1;
        self.find_best();
    }

    /// Parts of a whole frame.
    fn expected_parts(&self, detector: &Detector, part: &Part) -> usize {
        detector.channels().div_ceil(part.volts.len().max(1))
    }

    /// The best response among some, over any number of the last parts; `is_wanted` tells by amplitude.
    pub(super) fn candidate(
        &self,
        among: std::ops::Range<usize>,
        least_parts: usize,
        is_wanted: impl Fn(f64) -> bool,
    ) -> Option<Candidate> {
        let mut best: Option<Candidate> = None;
        let mut along = vec![0.0f64; among.len()];
        let mut square = vec![0.0f64; among.len()];
        let (mut energy, mut readings) = (0.0, 0);
        for (before, part) in self.parts[..self.count].iter().rev().enumerate() {
            energy += part.energy;
            readings += part.readings.changes.len();
            for (k, response) in among.clone().enumerate() {
                along[k] += f64::from(part.along[response]);
                square[k] += f64::from(part.square[response]);
                if before + 1 < least_parts || square[k] <= 0.0 {
                    continue;
                }
                let gain = along[k] * along[k] / square[k];
                let amplitude = along[k] / square[k];
                if best.is_none_or(|best| gain > best.gain) && is_wanted(amplitude) {
                    best = Some(Candidate {
                        response,
                        parts: before + 1,
                        amplitude,
                        gain,
                        energy: 0.0,
                        readings: 0,
                    });
                }
            }
            if let Some(best) = best.as_mut().filter(|best| best.parts == before + 1) {
                best.energy = energy;
                best.readings = readings;
            }
        }
        best
    }

    fn find_best(&mut self) {
        let best = self.candidate(0..self.responses(), 1, |_| true);
        self.best_gain = best.map_or(0.0, |best| best.gain);
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
