//! How fast the touches move, by the ends of whole frames: readings of a moving finger are moved on with it.
//!
//! Completed frames already contain the velocity that was assumed, so places between two whole frames would confirm it
//! whatever it is: only places a whole frame apart are compared, which makes errors of the velocity die out.

use crate::touch::Locator;
use crate::types::{Nanos, PointMm, Touch, TouchId};

/// A slower touch rests, mm/s: noise moves it as well.
const MOVING_MM_PER_S: f64 = 30.0;
/// No finger is faster, mm/s.
const FASTEST_MM_PER_S: f64 = 1500.0;
/// A located touch belongs to a tracked one that is at most so far, mm.
const SAME_MM: f64 = 6.0;

/// The places at the end of the last whole frame, and the velocities since the one before.
#[derive(Clone, Debug, Default)]
pub(super) struct Drift {
    at_ns: Nanos,
    places: Vec<(TouchId, PointMm)>,
    moving: Vec<(PointMm, [f64; 2])>,
}

impl Drift {
    /// Takes the touches at the end of a whole frame.
    pub(super) fn take(&mut self, t_ns: Nanos, down: &[Touch]) {
        let elapsed_s = t_ns.saturating_sub(self.at_ns) as f64 * 1e-9;
        self.moving.clear();
        for touch in down {
            let before = self.places.iter().find(|(id, _)| *id == touch.id);
            let Some((_, [x, y])) = before.filter(|_| elapsed_s > 0.0) else {
                continue;
            };
            let at_mm = touch.contact.centre_mm;
            let velocity = [(at_mm[0] - x) / elapsed_s, (at_mm[1] - y) / elapsed_s];
            let mm_per_s = libm::hypot(velocity[0], velocity[1]);
            if (MOVING_MM_PER_S..FASTEST_MM_PER_S).contains(&mm_per_s) {
                self.moving.push((at_mm, velocity));
            }
        }
        self.at_ns = t_ns;
        self.places.clear();
        self.places
            .extend(down.iter().map(|touch| (touch.id, touch.contact.centre_mm)));
    }

    /// A touch went down or lifted: what is known is out of date.
    pub(super) fn clear(&mut self) {
        self.places.clear();
        self.moving.clear();
    }

    /// How fast the readings change, 1/s; empty if every touch rests.
    pub(super) fn rates(&self, locator: Option<&Locator>, rates: &mut Vec<f32>) {
        rates.clear();
        let Some(locator) = locator.filter(|_| !self.moving.is_empty()) else {
            return;
        };
        let velocity_at = |[x, y]: PointMm| {
            let near = self.moving.iter().map(|(at, velocity)| {
                let distance_mm = libm::hypot(at[0] - x, at[1] - y);
                (distance_mm, *velocity)
            });
            near.filter(|(distance_mm, _)| *distance_mm < SAME_MM)
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .map(|(_, velocity)| velocity)
        };
        locator.explained_rates(velocity_at, rates);
    }
}
