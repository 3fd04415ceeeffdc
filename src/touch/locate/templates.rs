//! Where a residual looks most like a touch: a matched filter over a grid of places.

use super::fit::Bounds;
use super::metric::{Metric, dot};
use crate::eit::ResponseTable;
use crate::pad::{Outline, TouchSign};
use crate::types::PointMm;

/// Grid steps along the pad's longer side: 5 mm on a 100 mm pad, within reach of the fit.
const ALONG: f64 = 20.0;

/// Number of places from which a touch is fitted, where one start is not enough ...
const PEAKS: usize = 4;
/// ... and their least distance, mm.
const PEAKS_APART_MM: f64 = 8.0;

/// Whitened responses of a typical finger, of length one.
#[derive(Clone, Debug)]
pub(super) struct Templates {
    rank: usize,
    /// Sign of the touches.
    sign: TouchSign,
    places_mm: Vec<PointMm>,
    /// Places x rank.
    responses: Vec<f32>,
}

/// The best place for a touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Peak {
    /// The place.
    pub(super) place_mm: PointMm,
    /// Upper bound of the fall of the cost, squared deviations.
    pub(super) gain: f64,
}

impl Templates {
    /// The templates for a table and a metric.
    #[must_use]
    pub(super) fn new(
        table: &ResponseTable,
        metric: &Metric,
        bounds: &Bounds,
        outline: &Outline,
    ) -> Self {
        let [width, height] = bounds.size_mm;
        let pitch_mm = width.max(height) / ALONG;
        let steps = |side: f64| libm::ceil(side / pitch_mm - 1e-9) as usize;
        let mut templates = Self {
            rank: table.rank(),
            sign: bounds.sign,
            places_mm: Vec::new(),
            responses: Vec::new(),
        };
        let mut response = Vec::new();
        for row in 0..=steps(height) {
            for column in 0..=steps(width) {
                let place_mm = [column as f64 * pitch_mm, row as f64 * pitch_mm];
                if !outline.contains(place_mm) {
                    continue;
                }
                table.respond_value(&bounds.typical(place_mm), &mut response);
                metric.whiten_coordinates(&mut response);
                let length = libm::sqrtf(dot(&response, &response));
                if length > 0.0 {
                    templates.places_mm.push(place_mm);
                    templates
                        .responses
                        .extend(response.iter().map(|value| value / length));
                }
            }
        }
        templates
    }

    /// The place where a touch of a sign would explain most of a residual; `None` if it explains nothing at any place.
    #[must_use]
    pub(super) fn peak(&self, residual: &[f32], sign: TouchSign) -> Option<Peak> {
        // Touches of either sign have nearly opposite responses.
        let factor = sign.factor() * self.sign.factor();
        let mut best = (0.0f32, None);
        for (place, template) in self.responses.chunks_exact(self.rank).enumerate() {
            let along = factor * dot(template, residual);
            if along > best.0 {
                best = (along, Some(place));
            }
        }
        best.1.map(|place| Peak {
            place_mm: self.places_mm[place],
            gain: f64::from(best.0) * f64::from(best.0),
        })
    }

    /// The best places for a touch of a sign, at least [`PEAKS_APART_MM`] apart, best first.
    #[must_use]
    pub(super) fn peaks(&self, residual: &[f32], sign: TouchSign) -> Vec<PointMm> {
        let factor = sign.factor() * self.sign.factor();
        let mut places: Vec<(f32, PointMm)> = self
            .responses
            .chunks_exact(self.rank)
            .zip(&self.places_mm)
            .map(|(template, place_mm)| (factor * dot(template, residual), *place_mm))
            .collect();
        places.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut chosen: Vec<PointMm> = Vec::with_capacity(PEAKS);
        for (_, [x, y]) in places {
            let is_apart =
                |other: &PointMm| libm::hypot(other[0] - x, other[1] - y) > PEAKS_APART_MM;
            if chosen.len() < PEAKS && chosen.iter().all(is_apart) {
                chosen.push([x, y]);
            }
        }
        chosen
    }
}
