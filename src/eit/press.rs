//! A press as gels show it: the model that simulated pads, studies and the table of responses share.

use crate::pad::TouchSign;
use crate::types::PointMm;

/// Unknowns of a press: x, y, radius, rise.
pub const PRESS_UNKNOWNS: usize = 4;

/// A press as gels show it: the conductivity is multiplied (or, where touches conduct worse, divided) by
/// 1 + rise (1 - (d / radius)^2) within its radius.
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
    /// The factor at a point, of a pad whose touches conduct better.
    #[must_use]
    pub fn factor(&self, point: PointMm) -> f64 {
        1.0 + self.rise * self.share(point)
    }

    /// Relative change of conductivity at a point.
    #[must_use]
    pub fn change(&self, point: PointMm, sign: TouchSign) -> f64 {
        let rise = self.rise * self.share(point);
        match sign {
            TouchSign::Rise => rise,
            TouchSign::Fall => -rise / (1.0 + rise),
        }
    }

    /// Its volume, relative rise x mm2: what `force` measures.
    #[must_use]
    pub fn volume_mm2(&self) -> f64 {
        self.rise * std::f64::consts::PI * self.radius_mm * self.radius_mm / 2.0
    }

    /// The share of the rise at a point, 0 to 1.
    #[must_use]
    pub fn share(&self, [x, y]: PointMm) -> f64 {
        let (dx, dy) = (x - self.centre_mm[0], y - self.centre_mm[1]);
        (1.0 - (dx * dx + dy * dy) / (self.radius_mm * self.radius_mm)).max(0.0)
    }

    /// Derivatives of the factor for x, y (1/mm), radius (1/mm) and rise.
    #[must_use]
    pub fn derivatives(&self, [x, y]: PointMm) -> [f64; PRESS_UNKNOWNS] {
        let share = self.share([x, y]);
        if share == 0.0 {
            return [0.0; PRESS_UNKNOWNS];
        }
        let (dx, dy) = (x - self.centre_mm[0], y - self.centre_mm[1]);
        let r2 = self.radius_mm * self.radius_mm;
        [
            2.0 * self.rise * dx / r2,
            2.0 * self.rise * dy / r2,
            2.0 * self.rise * (1.0 - share) / self.radius_mm,
            share,
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
