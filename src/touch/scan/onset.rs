//! A finger that went down while its frame was being read: where it may be, and how sure that is.

use std::sync::Arc;

use super::evidence::{Evidence, ONSET_PARTS};
use super::fit::{FingerBounds, FitMemory, Fitted, fit};
use super::readings::PartReadings;
use crate::eit::ResponseTable;
use crate::eit::response::{MOST_STRENGTH, TouchModel};
use crate::pad::TouchSign;
use crate::touch::{Detector, Locator};
use crate::types::{PointMm, distance_mm};

/// Places along the pad's longer side at which a finger is looked for: 10 mm apart on a pad of 100 mm.
const ALONG: f64 = 10.0;
/// Least squared deviations that a finger explains: every part asks again at many places, sixteen times as often as frames do.
const LEAST_GAIN: f64 = 60.0;
/// Steps of the first fit of a finger, ...
const FIRST_STEPS: usize = 7;
/// ... and of the next ones, which start from the one before.
const NEXT_STEPS: usize = 3;
/// The fitted finger leaves at most this many squared deviations a reading ...
const REST: f64 = 4.0;
/// ... and this share of what changed.
const REST_SHARE: f64 = 0.1;
/// Its place is known to this standard deviation, mm: a region needs no more.
const PLACE_MM: f64 = 1.2;
/// A place that is farther than this from the best one is another, mm; ...
const ELSEWHERE_MM: f64 = 16.0;
/// ... fits that end nearer than this to each other are the same.
const SAME_MM: f64 = 5.0;
/// A finger is surely where it is fitted, and not elsewhere, if that explains at least this many squared deviations more: odds of 400 to 1.
const SURE: f64 = 12.0;
/// New fingers are at least this far from those that are down, mm: nearer changes are theirs.
const APART_MM: f64 = 14.0;

/// Responses of a typical finger at many places, one value per channel.
#[derive(Clone, Debug)]
pub(super) struct OnsetModel {
    table: Arc<ResponseTable>,
    sign: TouchSign,
    bounds: FingerBounds,
    places_mm: Vec<PointMm>,
    /// Channels x places.
    responses: Vec<f32>,
}

impl OnsetModel {
    /// The responses of a pad for fingers of a sign.
    pub(super) fn new(locator: &Locator, sign: TouchSign) -> Self {
        let table = Arc::clone(locator.table());
        let size_mm = locator.size_mm();
        let pitch_mm = size_mm[0].max(size_mm[1]) / ALONG;
        let typical = TouchModel {
            sign,
            ..locator.typical_touch([0.0; 2])
        };
        let steps = size_mm.map(|side| libm::ceil(side / pitch_mm - 1e-9) as usize);
        let mut model = Self {
            sign,
            bounds: FingerBounds {
                typical,
                size_mm,
                log_radius: table.radii_mm().map(libm::log),
            },
            places_mm: Vec::new(),
            responses: Vec::new(),
            table,
        };
        let mut response = Vec::new();
        let mut changes = vec![0.0; model.table.channels()];
        let mut by_place = Vec::new();
        for row in 0..=steps[1] {
            for column in 0..=steps[0] {
                let centre_mm = [column as f64 * pitch_mm, row as f64 * pitch_mm];
                let touch = TouchModel {
                    centre_mm,
                    ..typical
                };
                model.table.respond_value(&touch, &mut response);
                model.table.expand(&response, &mut changes);
                if changes.iter().any(|change| *change != 0.0) {
                    model.places_mm.push(centre_mm);
                    by_place.extend_from_slice(&changes);
                }
            }
        }
        let (channels, places) = (changes.len(), model.places_mm.len());
        let transposed = (0..channels * places)
            .map(|index| by_place[index % places * channels + index / places]);
        model.responses = transposed.collect();
        model
    }

    /// Whether the model is that of a locator and a sign.
    pub(super) fn is_for(&self, locator: &Locator, sign: TouchSign) -> bool {
        self.sign == sign && Arc::ptr_eq(&self.table, locator.table())
    }

    /// The responses, channels x places, and the number of places.
    pub(super) fn responses(&self) -> (&[f32], usize) {
        (&self.responses, self.places_mm.len())
    }

    /// A finger that went down, and how many parts ago.
    pub(super) fn find(
        &self,
        detector: &Detector,
        evidence: &Evidence,
        memory: &mut FitMemory,
    ) -> Option<(Fitted, usize)> {
        let best = evidence.onset().filter(|best| best.gain >= LEAST_GAIN)?;
        // The part in which the finger landed shows it half.
        let candidates = [best.parts, best.parts.saturating_sub(1)];
        candidates
            .into_iter()
            .filter(|parts| *parts >= ONSET_PARTS)
            .find_map(|parts| {
                let fitted = self.fit_first(best.response, evidence, parts, memory)?;
                let is_clear = fitted.rest < REST * fitted.readings + REST_SHARE * fitted.energy
                    && fitted.energy - fitted.rest > LEAST_GAIN
                    && fitted.place_mm < PLACE_MM;
                let is_apart = detector.frame_touches().down.iter().all(|down| {
                    distance_mm(down.contact.centre_mm, fitted.touch.centre_mm) > APART_MM
                });
                (is_clear && is_apart).then_some((fitted, parts))
            })
    }

    /// Fits a finger to the last `parts` parts, from the best place and from the best one elsewhere. `None` if both explain them.
    fn fit_first(
        &self,
        best: usize,
        evidence: &Evidence,
        parts: usize,
        memory: &mut FitMemory,
    ) -> Option<Fitted> {
        let elsewhere = self.best_elsewhere(best, evidence, parts);
        let starts = [Some(best), elsewhere];
        let [one, other] = starts.map(|start| {
            let start = self.start(start?, evidence, parts);
            let readings = evidence.readings(parts);
            fit(&self.table, &self.bounds, start, readings, memory)
        });
        let (Some(one), Some(other)) = (one, other) else {
            return one.or(other);
        };
        let (best, rival) = match one.cost <= other.cost {
            true => (one, other),
            false => (other, one),
        };
        let is_same = distance_mm(best.touch.centre_mm, rival.touch.centre_mm) < SAME_MM;
        (is_same || rival.cost - best.cost > SURE).then_some(best)
    }

    /// A typical finger at a place, as strong as the last `parts` parts show it.
    fn start(&self, response: usize, evidence: &Evidence, parts: usize) -> (TouchModel, usize) {
        let (_, amplitude) = evidence.gain(response, parts);
        let strength = (amplitude * self.bounds.typical.strength).clamp(0.02, MOST_STRENGTH);
        let touch = TouchModel {
            centre_mm: self.places_mm[response],
            strength,
            ..self.bounds.typical
        };
        (touch, FIRST_STEPS)
    }

    /// The place that explains most of the last `parts` parts, not near the best one.
    fn best_elsewhere(&self, best: usize, evidence: &Evidence, parts: usize) -> Option<usize> {
        let best_mm = self.places_mm[best];
        (0..self.places_mm.len())
            .filter(|place| distance_mm(self.places_mm[*place], best_mm) > ELSEWHERE_MM)
            .map(|place| (place, evidence.gain(place, parts).0))
            .filter(|(_, gain)| *gain > 0.0)
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(place, _)| place)
    }

    /// Fits a finger that was fitted before to more readings.
    pub(super) fn fit_again<'a>(
        &self,
        before: &Fitted,
        parts: impl Iterator<Item = &'a PartReadings> + Clone,
        memory: &mut FitMemory,
    ) -> Option<Fitted> {
        let start = (before.touch, NEXT_STEPS);
        fit(&self.table, &self.bounds, start, parts, memory)
    }

    /// The relative change of each channel by a finger.
    pub(super) fn respond(&self, finger: &Fitted, memory: &mut FitMemory, changes: &mut Vec<f32>) {
        self.table.respond(&finger.touch, &mut memory.response);
        changes.resize(self.table.channels(), 0.0);
        self.table.expand(&memory.response.value, changes);
    }
}
