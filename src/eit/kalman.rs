//! A Kalman filter's covariance for a level that changes at a nearly constant rate.
//!
//! Model: Bar-Shalom, Li and Kirubarajan 2001, section 6.2 (nearly constant velocity).

/// Random walk of the rate, share per second within a second.
const RATE_WALK_PER_S: f64 = 5e-5;
/// Random walk of the level beside its rate, share within a second.
const LEVEL_WALK: f64 = 1e-4;

/// Covariance of level and rate, relative to the level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Covariance {
    pub(super) level: f64,
    cross: f64,
    rate: f64,
}

impl Covariance {
    /// Of a known level and a rate with the given standard deviation.
    pub(super) fn from_rate(rate_per_s: f64) -> Self {
        Self {
            level: 0.0,
            cross: 0.0,
            rate: rate_per_s * rate_per_s,
        }
    }

    /// Predicts: the uncertainty grows with time.
    pub(super) fn advance(&mut self, elapsed_s: f64) {
        let Self { level, cross, rate } = *self;
        *self = Self {
            level: level
                + elapsed_s * (2.0 * cross + elapsed_s * rate)
                + LEVEL_WALK * LEVEL_WALK * elapsed_s,
            cross: cross + elapsed_s * rate,
            rate: rate + RATE_WALK_PER_S * RATE_WALK_PER_S * elapsed_s,
        };
    }

    /// Scales the estimate of the rate by `keep`.
    pub(super) fn shrink_rate(&mut self, keep: f64) {
        self.cross *= keep;
        self.rate *= keep * keep;
    }

    /// Updates with a measurement of the given variance; returns the corrections of level and rate.
    pub(super) fn measure(&mut self, surprise: f64, variance: f64) -> (f64, f64) {
        let Self { level, cross, rate } = *self;
        let total = level + variance;
        let (level_gain, rate_gain) = (level / total, cross / total);
        *self = Self {
            level: level - level_gain * level,
            cross: cross - level_gain * cross,
            rate: rate - rate_gain * cross,
        };
        (level_gain * surprise, rate_gain * surprise)
    }
}
