//! How fast the touches move, by the ends of whole frames, and how the readings change along their ways.
//!
//! A reading of a moving finger is brought to another time by the difference of the responses at the places where the finger is at both
//! times. A cubic through the responses a frame before, at, and a frame after the present gives them for each channel: a finger that crosses
//! a channel of the pad within a frame changes a reading far from evenly.
//!
//! Completed frames already contain the velocity that was assumed, so places between two whole frames would confirm it
//! whatever it is: only places a whole frame apart are compared, which makes errors of the velocity die out.

use crate::touch::Locator;
use crate::types::{Nanos, PointMm, Touch, TouchId};

/// A slower touch rests, mm/s: noise moves it as well.
const MOVING_MM_PER_S: f64 = 30.0;
/// No finger is faster, mm/s.
const FASTEST_MM_PER_S: f64 = 1500.0;
/// Along a longer way within a frame, mm, readings change evenly.
const LONGEST_WAY_MM: f64 = 8.0;
/// A located touch belongs to a tracked one that is at most so far, mm.
const SAME_MM: f64 = 6.0;

/// The places at the end of the last whole frame, and the velocities since the one before.
#[derive(Clone, Debug, Default)]
pub(super) struct Drift {
    at_ns: Nanos,
    /// Time between the last two whole frames, s.
    period_s: f64,
    places: Vec<(TouchId, PointMm)>,
    moving: Vec<(TouchId, PointMm, [f64; 2])>,
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
                self.moving.push((touch.id, at_mm, velocity));
            }
        }
        self.at_ns = t_ns;
        self.period_s = elapsed_s;
        self.places.clear();
        self.places
            .extend(down.iter().map(|touch| (touch.id, touch.contact.centre_mm)));
    }

    /// Forgets a touch that has lifted.
    pub(super) fn forget(&mut self, gone: &Touch) {
        self.places.retain(|(id, _)| *id != gone.id);
        self.moving.retain(|(id, ..)| *id != gone.id);
    }

    /// A touch went down: what is known is out of date.
    pub(super) fn clear(&mut self) {
        self.places.clear();
        self.moving.clear();
    }

    /// How the readings change along the ways of the touches, which are located at this time; empty if every touch rests.
    pub(super) fn ways(&self, t_ns: Nanos, locator: Option<&Locator>, ways: &mut Ways) {
        ways.clear();
        let Some(locator) = locator.filter(|_| !self.moving.is_empty()) else {
            return;
        };
        let velocity_at = |[x, y]: PointMm| {
            let near = self.moving.iter().map(|(_, at, velocity)| {
                let distance_mm = libm::hypot(at[0] - x, at[1] - y);
                (distance_mm, *velocity)
            });
            near.filter(|(distance_mm, _)| *distance_mm < SAME_MM)
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .map(|(_, velocity)| velocity)
        };
        let speeds = self.moving.iter();
        let fastest = speeds.fold(0.0, |most: f64, (.., [x, y])| most.max(libm::hypot(*x, *y)));
        ways.at_ns = t_ns;
        ways.period_s = self.period_s as f32;
        let [linear, square, cubic] = &mut ways.terms;
        let mut now = Vec::new();
        locator.moving_responses(velocity_at, 0.0, &mut now, linear);
        square.resize(linear.len(), 0.0);
        cubic.resize(linear.len(), 0.0);
        if fastest * self.period_s > LONGEST_WAY_MM {
            return;
        }
        let (mut after, mut before, mut rates) = (Vec::new(), Vec::new(), Vec::new());
        locator.moving_responses(velocity_at, self.period_s, &mut after, &mut rates);
        locator.moving_responses(velocity_at, -self.period_s, &mut before, &mut rates);
        let period = ways.period_s;
        for channel in 0..linear.len() {
            let even = after[channel] + before[channel] - 2.0 * now[channel];
            let odd = after[channel] - before[channel] - 2.0 * period * linear[channel];
            square[channel] = even / (2.0 * period * period);
            cubic[channel] = odd / (2.0 * period * period * period);
        }
    }
}

/// How the reading of each channel changes with time while touches move.
#[derive(Clone, Debug, Default)]
pub(super) struct Ways {
    at_ns: Nanos,
    /// The cubics hold for so long before and after.
    period_s: f32,
    /// Coefficients of time, its square and its cube, by channel; empty if every touch rests.
    terms: [Vec<f32>; 3],
}

impl Ways {
    /// Whether no touch moves.
    pub(super) fn is_empty(&self) -> bool {
        self.terms[0].is_empty()
    }

    /// Every touch rests.
    pub(super) fn clear(&mut self) {
        for terms in &mut self.terms {
            terms.clear();
        }
    }

    /// The relative change of a channel from one time to another; 0 if every touch rests.
    pub(super) fn change(&self, channel: usize, from_ns: Nanos, to_ns: Nanos) -> f32 {
        if self.is_empty() {
            return 0.0;
        }
        self.since(channel, to_ns) - self.since(channel, from_ns)
    }

    /// The relative change of a channel since the time at which the touches were located.
    fn since(&self, channel: usize, t_ns: Nanos) -> f32 {
        let time_s = (t_ns as f64 - self.at_ns as f64) as f32 * 1e-9;
        // Beyond the cubic, the change goes on as fast as in the middle.
        let near_s = time_s.clamp(-self.period_s, self.period_s);
        let [linear, square, cubic] = [0, 1, 2].map(|k| self.terms[k][channel]);
        linear * time_s + near_s * near_s * (square + near_s * cubic)
    }
}
