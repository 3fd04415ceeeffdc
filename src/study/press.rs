//! A press as gels show it, and what several of them make of a pad.

use crate::pad::TouchSign;
use crate::types::PointMm;

/// Unknowns of a press: x, y, radius, rise.
pub(super) const UNKNOWNS: usize = 4;

/// A press as gels show it: the conductivity is multiplied by 1 + rise (1 - (d / radius)^2) within its radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Press {
    /// Its middle, mm.
    pub centre_mm: PointMm,
    /// Its radius, mm.
    pub radius_mm: f64,
    /// Relative rise in its middle.
    pub rise: f64,
}

impl Press {
    /// The factor at a point.
    #[must_use]
    pub fn factor(&self, point: PointMm) -> f64 {
        1.0 + self.rise * self.bump(point)
    }

    /// Its volume, relative rise x mm2: what `force` measures.
    #[must_use]
    pub fn volume_mm2(&self) -> f64 {
        self.rise * std::f64::consts::PI * self.radius_mm * self.radius_mm / 2.0
    }

    /// Height of the press at a point as a share of its height in the middle.
    pub(super) fn bump(&self, [x, y]: PointMm) -> f64 {
        let (dx, dy) = (x - self.centre_mm[0], y - self.centre_mm[1]);
        (1.0 - (dx * dx + dy * dy) / (self.radius_mm * self.radius_mm)).max(0.0)
    }

    /// Derivatives of the factor for x, y (1/mm), radius (1/mm) and rise.
    pub(super) fn derivatives(&self, [x, y]: PointMm) -> [f64; UNKNOWNS] {
        let bump = self.bump([x, y]);
        if bump == 0.0 {
            return [0.0; UNKNOWNS];
        }
        let (dx, dy) = (x - self.centre_mm[0], y - self.centre_mm[1]);
        let r2 = self.radius_mm * self.radius_mm;
        [
            2.0 * self.rise * dx / r2,
            2.0 * self.rise * dy / r2,
            2.0 * self.rise * (1.0 - bump) / self.radius_mm,
            bump,
        ]
    }
}

/// What several presses make of the conductivity at a point: each multiplies it, or divides it where a touch conducts
/// worse.
#[must_use]
pub fn pressed(presses: &[Press], sign: TouchSign, point: PointMm) -> f64 {
    let factor: f64 = presses.iter().map(|press| press.factor(point)).product();
    match sign {
        TouchSign::Rise => factor,
        TouchSign::Fall => 1.0 / factor,
    }
}
