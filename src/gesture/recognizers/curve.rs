//! The response of sticks and triggers.

use crate::profile::Curve;

/// The value of an axis, 0..1, at a share 0..1 of its way.
pub(super) fn response(curve: &Curve, share: f64) -> f64 {
    if share < curve.dead_zone || share == 0.0 {
        return 0.0;
    }
    libm::pow(
        (share - curve.dead_zone) / (1.0 - curve.dead_zone),
        curve.exponent,
    )
}
