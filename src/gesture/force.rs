//! Force: a level with hysteresis, and an axis.

use super::stick::answer;
use crate::profile::Trigger;

/// Whether a level that was down or up is down at a force.
pub(super) fn is_down(was_down: bool, force: f64, press: f64, release: f64) -> bool {
    force >= if was_down { release } else { press }
}

/// A trigger's value, 0 to 1.
pub(super) fn pulled(own: &Trigger, force: f64) -> f32 {
    (answer(&own.curve, force) * own.gain).clamp(0.0, 1.0) as f32
}
