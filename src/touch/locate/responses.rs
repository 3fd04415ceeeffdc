//! The responses of the located touches, by channel: for frames that are read in parts.

use super::locator::Locator;
use crate::eit::ResponseTable;
use crate::eit::response::{Response, TouchModel};
use crate::types::PointMm;

impl Locator {
    /// The response table.
    pub(in crate::touch) fn table(&self) -> &std::sync::Arc<ResponseTable> {
        self.model.table()
    }

    /// The pad's width and height, mm.
    pub(in crate::touch) fn size_mm(&self) -> [f64; 2] {
        self.bounds.size_mm
    }

    /// A typical finger at a place.
    pub(in crate::touch) fn typical_touch(&self, centre_mm: PointMm) -> TouchModel {
        self.bounds.typical(centre_mm)
    }

    /// The response of each touch, one relative change per channel.
    pub(in crate::touch) fn responses(&self, responses: &mut Vec<Vec<f32>>) {
        let table = self.table();
        let mut response = Response::default();
        responses.resize_with(self.fit.touches.len(), Vec::new);
        for (touch, changes) in self.fit.touches.iter().zip(responses) {
            table.respond(touch, &mut response);
            changes.resize(table.channels(), 0.0);
            table.expand(&response.value, changes);
        }
    }

    /// How the response of each touch changes with its x and y (1/mm), log radius and strength: four in a row for each touch, one value per
    /// channel.
    pub(in crate::touch) fn slopes(&self, slopes: &mut Vec<Vec<f32>>) {
        let table = self.table();
        let mut response = Response::default();
        slopes.resize_with(4 * self.fit.touches.len(), Vec::new);
        for (touch, slopes) in self.fit.touches.iter().zip(slopes.chunks_exact_mut(4)) {
            table.respond(touch, &mut response);
            for (derivative, slope) in response.derivatives.iter().zip(slopes) {
                slope.resize(table.channels(), 0.0);
                table.expand(derivative, slope);
            }
        }
    }

    /// The response of the touches that move with the given velocities, mm/s, and how fast it changes, 1/s, some time from now: one value
    /// per channel.
    pub(in crate::touch) fn moving_responses(
        &self,
        velocity_at: impl Fn(PointMm) -> Option<[f64; 2]>,
        ahead_s: f64,
        changes: &mut Vec<f32>,
        rates: &mut Vec<f32>,
    ) {
        let table = self.table();
        let mut sums = [vec![0.0; table.rank()], vec![0.0; table.rank()]];
        let mut response = Response::default();
        for touch in &self.fit.touches {
            let Some(velocity) = velocity_at(touch.centre_mm) else {
                continue;
            };
            let mut touch = *touch;
            for (at_mm, (mm_per_s, size_mm)) in touch
                .centre_mm
                .iter_mut()
                .zip(velocity.iter().zip(self.bounds.size_mm))
            {
                *at_mm = (*at_mm + ahead_s * mm_per_s).clamp(0.0, size_mm);
            }
            table.respond(&touch, &mut response);
            let [by_x, by_y, ..] = &response.derivatives;
            let [vx, vy] = velocity.map(|mm_per_s| mm_per_s as f32);
            for (k, value) in response.value.iter().enumerate() {
                sums[0][k] += value;
                sums[1][k] += vx * by_x[k] + vy * by_y[k];
            }
        }
        for (sum, out) in sums.iter().zip([changes, rates]) {
            out.resize(table.channels(), 0.0);
            table.expand(sum, out);
        }
    }
}
