//! Where an unexplained rest looks most like a touch: a matched filter over a grid of places.

use super::fit::Bounds;
use super::metric::{Metric, dot};
use crate::eit::ResponseTable;
use crate::eit::response::Response;
use crate::pad::Outline;
use crate::types::PointMm;

/// Places along the pad's longer side: 5 mm on a 100 mm pad, within reach of the fit.
const ALONG: f64 = 20.0;

/// Whitened responses of a usual finger, of length one.
#[derive(Clone, Debug)]
pub(super) struct Templates {
    rank: usize,
    places_mm: Vec<PointMm>,
    /// Places by rank.
    responses: Vec<f32>,
}

/// The best place and what a touch there would explain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Peak {
    /// Where.
    pub(super) place_mm: PointMm,
    /// By how much the cost would fall at most, squared deviations.
    pub(super) gain: f64,
}

impl Templates {
    /// Templates for a metric.
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
                table.respond(&bounds.usual(place_mm), &mut response);
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

    /// The place where a touch would explain most of a rest, if it would explain anything anywhere.
    #[must_use]
    pub(super) fn peak(&self, rest: &[f32]) -> Option<Peak> {
        let mut best = (0.0f32, None);
        for (place, template) in self.responses.chunks_exact(self.rank).enumerate() {
            let along = dot(template, rest);
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
