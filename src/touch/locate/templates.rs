//! Where a residual looks most like a touch: a matched filter over a grid of places.

use super::fit::Bounds;
use super::metric::{Metric, dot};
use crate::eit::ResponseTable;
use crate::eit::response::Response;
use crate::pad::Outline;
use crate::types::PointMm;

/// Grid steps along the pad's longer side: 5 mm on a 100 mm pad, within reach of the fit.
const ALONG: f64 = 20.0;

/// Whitened responses of a typical finger, of length one.
#[derive(Clone, Debug)]
pub(super) struct Templates {
    rank: usize,
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
            places_mm: Vec::new(),
            responses: Vec::new(),
        };
        let mut response = Response::default();
        for row in 0..=steps(height) {
            for column in 0..=steps(width) {
                let place_mm = [column as f64 * pitch_mm, row as f64 * pitch_mm];
                if !outline.contains(place_mm) {
                    continue;
                }
                table.respond(&bounds.typical(place_mm), &mut response);
                metric.whiten_coordinates(&mut response.value);
                let length = libm::sqrtf(dot(&response.value, &response.value));
                if length > 0.0 {
                    templates.places_mm.push(place_mm);
                    templates
                        .responses
                        .extend(response.value.iter().map(|value| value / length));
                }
            }
        }
        templates
    }

    /// The place where a touch would explain most of a residual; `None` if it explains nothing at any place.
    #[must_use]
    pub(super) fn peak(&self, residual: &[f32]) -> Option<Peak> {
        let mut best = (0.0f32, None);
        for (place, template) in self.responses.chunks_exact(self.rank).enumerate() {
            let along = dot(template, residual);
            if along > best.0 {
                best = (along, Some(place));
            }
        }
        best.1.map(|place| Peak {
            place_mm: self.places_mm[place],
            gain: f64::from(best.0) * f64::from(best.0),
        })
    }
}
