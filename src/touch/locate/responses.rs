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

    /// How fast the response of all touches changes, 1/s by channel, while they move with the given velocities, mm/s.
    pub(in crate::touch) fn explained_rates(
        &self,
        velocity_at: impl Fn(PointMm) -> Option<[f64; 2]>,
        rates: &mut Vec<f32>,
    ) {
        let table = self.table();
        let mut sum = vec![0.0; table.rank()];
        let mut response = Response::default();
        for touch in &self.fit.touches {
            let Some([vx, vy]) = velocity_at(touch.centre_mm) else {
                continue;
            };
            table.respond(touch, &mut response);
            let [by_x, by_y, ..] = &response.derivatives;
            for (sum, (x, y)) in sum.iter_mut().zip(by_x.iter().zip(by_y)) {
                *sum += vx as f32 * x + vy as f32 * y;
            }
        }
        rates.resize(table.channels(), 0.0);
        table.expand(&sum, rates);
    }
}
