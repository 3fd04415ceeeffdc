//! A finger that went down while its frame was being read: where it may be, and how sure that is.

use std::sync::Arc;

use super::evidence::Evidence;
use super::fit::{FingerBounds, Fitted, fit};
use super::readings::PartReadings;
use crate::eit::ResponseTable;
use crate::eit::response::{MOST_STRENGTH, Response, TouchModel};
use crate::pad::TouchSign;
use crate::touch::{Detector, Locator};
use crate::types::PointMm;

/// Places along the pad's longer side at which a finger is looked for: 10 mm apart on a pad of 100 mm.
const ALONG: f64 = 10.0;
/// A finger explains so many squared deviations: every part asks again at many places, sixteen times as often as frames do, ...
const LEAST_GAIN: f64 = 60.0;
/// ... in at least so many parts.
const LEAST_PARTS: usize = 3;
/// Amplitude of the faintest finger, relative to a typical one.
const LEAST_AMPLITUDE: f64 = 0.05;
/// The fitted finger leaves at most this many squared deviations a reading ...
const REST: f64 = 4.0;
/// ... and this share of what changed.
const REST_SHARE: f64 = 0.1;
/// Its place is known to this standard deviation, mm: a region needs no more.
const PLACE_MM: f64 = 1.2;
/// New fingers are at least this far from those that are down, mm: nearer changes are theirs.
const APART_MM: f64 = 14.0;

/// Responses of a typical finger at many places, one value per channel.
#[derive(Clone, Debug)]
pub(super) struct OnsetModel {
    table: Arc<ResponseTable>,
    sign: TouchSign,
    bounds: FingerBounds,
    places_mm: Vec<PointMm>,
    /// Places x channels.
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
        let mut response = Response::default();
        let mut changes = vec![0.0; model.table.channels()];
        for row in 0..=steps[1] {
            for column in 0..=steps[0] {
                let centre_mm = [column as f64 * pitch_mm, row as f64 * pitch_mm];
                let touch = TouchModel {
                    centre_mm,
                    ..typical
                };
                model.table.respond(&touch, &mut response);
                model.table.expand(&response.value, &mut changes);
                if changes.iter().any(|change| *change != 0.0) {
                    model.places_mm.push(centre_mm);
                    model.responses.extend_from_slice(&changes);
                }
            }
        }
        model
    }

    /// Whether the model is that of a locator and a sign.
    pub(super) fn is_for(&self, locator: &Locator, sign: TouchSign) -> bool {
        self.sign == sign && Arc::ptr_eq(&self.table, locator.table())
    }

    /// The responses, in the order of the places.
    pub(super) fn responses(&self) -> impl Iterator<Item = &[f32]> {
        self.responses.chunks_exact(self.table.channels())
    }

    /// A finger that went down, and how many parts ago.
    pub(super) fn find(&self, detector: &Detector, evidence: &Evidence) -> Option<(Fitted, usize)> {
        let best = evidence.candidate(0..self.places_mm.len(), LEAST_PARTS, |amplitude| {
            amplitude > LEAST_AMPLITUDE
        })?;
        if best.gain < LEAST_GAIN {
            return None;
        }
        let start = TouchModel {
            centre_mm: self.places_mm[best.response],
            strength: (best.amplitude * self.bounds.typical.strength).clamp(0.02, MOST_STRENGTH),
            ..self.bounds.typical
        };
        // The part in which the finger landed shows it half.
        let candidates = [best.parts, best.parts.saturating_sub(1)];
        candidates
            .into_iter()
            .filter(|parts| *parts >= LEAST_PARTS)
            .find_map(|parts| {
                let fitted = self.fit(start, evidence.readings(parts))?;
                let is_clear = fitted.rest < REST * fitted.readings + REST_SHARE * fitted.energy
                    && fitted.energy - fitted.rest > LEAST_GAIN
                    && fitted.place_mm < PLACE_MM;
                let is_apart = detector.frame_touches().down.iter().all(|down| {
                    let [x, y] = down.contact.centre_mm;
                    let [a, b] = fitted.touch.centre_mm;
                    libm::hypot(a - x, b - y) > APART_MM
                });
                (is_clear && is_apart).then_some((fitted, parts))
            })
    }

    /// Fits a finger to the readings of some parts.
    pub(super) fn fit<'a>(
        &self,
        start: TouchModel,
        parts: impl Iterator<Item = &'a PartReadings> + Clone,
    ) -> Option<Fitted> {
        fit(&self.table, &self.bounds, start, parts)
    }
}
