//! A finger that went down while its frame was being read: where it may be, and how sure that is.

use std::sync::Arc;

use super::evidence::{Candidate, Evidence, ONSET_PARTS};
use super::fit::{FingerBounds, FitMemory, Fitted, fit};
use super::moves::rest_of_moves;
use super::readings::PartReadings;
use super::refusals::{Refusal, Refusals};
use crate::eit::ResponseTable;
use crate::eit::response::{MOST_STRENGTH, TouchModel};
use crate::pad::TouchSign;
use crate::touch::{Detector, Locator};
use crate::types::{PointMm, Touch, distance_mm};

/// Places along the pad's longer side at which a finger is looked for: 10 mm apart on a pad of 100 mm.
const ALONG: f64 = 10.0;
/// Least squared deviations that a finger explains: every part asks again at many places, sixteen times as often as frames do.
const LEAST_GAIN: f64 = 60.0;
/// A change that is seen in more parts than this and is still refused stays so.
const LASTING_PARTS: usize = 8;
/// Steps of the first fit of a finger, ...
const FIRST_STEPS: usize = 7;
/// ... and of the next ones, which start from the one before.
const NEXT_STEPS: usize = 3;
/// The fitted finger leaves at most this many squared deviations a reading ...
const REST: f64 = 4.0;
/// ... and this share of what changed.
const REST_SHARE: f64 = 0.1;
/// Its place is known to this standard deviation, mm: a region needs no more.
const PLACE_MM: f64 = 1.4;
/// A place that is farther than this from the best one is another, mm; ...
const ELSEWHERE_MM: f64 = 16.0;
/// ... fits that end nearer than this to each other are the same.
const SAME_MM: f64 = 5.0;
/// A finger is surely where it is fitted, and not elsewhere, if that explains at least this many squared deviations more: odds of 400 to 1.
const SURE: f64 = 12.0;
/// New fingers are at least this far from those that are down, mm: nearer changes are theirs.
const APART_MM: f64 = 14.0;
/// Changes that are seen best at a place this near to a finger that is down are that finger's, mm: they are not fitted.
const SAME_FINGER_MM: f64 = 6.0;

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
        refusals: &mut Refusals,
        memory: &mut FitMemory,
    ) -> Option<(Fitted, usize)> {
        let is_worth_a_fit =
            |best: &Candidate| best.gain >= LEAST_GAIN && refusals.allow(best.gain);
        let best = evidence.onset().filter(is_worth_a_fit)?;
        let down = detector.touches_down();
        let found = if is_near(down, self.places_mm[best.response], SAME_FINGER_MM) {
            Err(Refusal::Other)
        } else {
            // The part in which the finger landed shows it half.
            let all = self.fit_first(&best, down, evidence, best.parts, memory);
            let parts = best.parts - 1;
            match all {
                // Half a part of many makes no difference.
                Err(_) if (ONSET_PARTS..LASTING_PARTS).contains(&parts) => self
                    .fit_first(&best, down, evidence, parts, memory)
                    .map(|fitted| (fitted, parts)),
                all => all.map(|fitted| (fitted, best.parts)),
            }
        };
        let found = found.and_then(|(fitted, parts)| {
            match is_move(detector, &fitted, evidence.readings(parts)) {
                true => Err(Refusal::Other),
                false => Ok((fitted, parts)),
            }
        });
        let refused = |refusal| match best.parts > LASTING_PARTS {
            true => Refusal::Lasting,
            false => refusal,
        };
        found
            .map_err(|refusal| refusals.add(best.gain, refused(refusal)))
            .ok()
    }

    /// Fits a finger to the last `parts` parts, from the best place and from the best one elsewhere. It is refused if both explain them.
    fn fit_first(
        &self,
        best: &Candidate,
        down: &[Touch],
        evidence: &Evidence,
        parts: usize,
        memory: &mut FitMemory,
    ) -> Result<Fitted, Refusal> {
        let mut fit_from = |place| {
            let start = self.start(place, evidence, parts);
            let readings = evidence.readings(parts);
            fit(&self.table, &self.bounds, start, readings, memory)
        };
        let one = fit_from(best.response).ok_or(Refusal::Other)?;
        if !one.is_clear() || is_near(down, one.touch.centre_mm, APART_MM) {
            return Err(Refusal::Other);
        }
        let rival = self.best_elsewhere(best.response, evidence, parts);
        let best = match rival.and_then(&mut fit_from) {
            Some(other) if !one.is_same(&other) => {
                let (best, rival) = match one.cost <= other.cost {
                    true => (one, other),
                    false => (other, one),
                };
                if rival.cost - best.cost <= SURE {
                    return Err(Refusal::Unsure);
                }
                best
            }
            _ => one,
        };
        if best.place_mm >= PLACE_MM {
            return Err(Refusal::Unsure);
        }
        let is_new = best.is_clear() && !is_near(down, best.touch.centre_mm, APART_MM);
        is_new.then_some(best).ok_or(Refusal::Other)
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

/// Whether moves of the fingers that are down explain almost as much of the readings as a new finger.
fn is_move<'a>(
    detector: &Detector,
    new: &Fitted,
    readings: impl Iterator<Item = &'a PartReadings>,
) -> bool {
    let Some(locator) = detector.locator() else {
        return false;
    };
    let mut slopes = Vec::new();
    locator.slopes(&mut slopes);
    !slopes.is_empty() && rest_of_moves(&slopes, readings) < new.rest + LEAST_GAIN
}

/// Whether a place is at most so far from a finger that is down.
fn is_near(down: &[Touch], place_mm: PointMm, most_mm: f64) -> bool {
    down.iter()
        .any(|touch| distance_mm(touch.contact.centre_mm, place_mm) <= most_mm)
}

impl Fitted {
    /// Whether it explains enough, and leaves little.
    fn is_clear(&self) -> bool {
        self.rest < REST * self.readings + REST_SHARE * self.energy
            && self.energy - self.rest > LEAST_GAIN
    }

    /// Whether two fits ended at the same place.
    fn is_same(&self, other: &Self) -> bool {
        distance_mm(self.touch.centre_mm, other.touch.centre_mm) < SAME_MM
    }
}
