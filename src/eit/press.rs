//! The model of a press that simulated pads, studies and the response table share.

use crate::pad::TouchSign;
use crate::types::PointMm;

/// Unknowns of a press: x, y, radius, rise.
pub const PRESS_UNKNOWNS: usize = 4;

/// A press: within its radius, at distance d from its centre, the conductivity is multiplied by
/// 1 + rise (1 - (d / radius)^2), or divided by it on pads whose touches conduct worse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Press {
    /// Centre, mm.
    pub centre_mm: PointMm,
    /// Radius, mm.
    pub radius_mm: f64,
    /// Relative rise of conductivity at the centre.
    pub rise: f64,
}

impl Press {
    /// Factor of the conductivity at a point, on a pad whose touches conduct better.
    #[must_use]
    pub fn factor(&self, point: PointMm) -> f64 {
        1.0 + self.rise * self.rise_share(point)
    }

    /// Relative change of conductivity at a point.
    #[must_use]
    pub fn change(&self, point: PointMm, sign: TouchSign) -> f64 {
        Self::change_of(self.rise * self.rise_share(point), sign)
    }

    /// Relative change of conductivity where a press rises by so much.
    pub(crate) fn change_of(rise: f64, sign: TouchSign) -> f64 {
        match sign {
            TouchSign::Rise => rise,
            TouchSign::Fall => -rise / (1.0 + rise),
        }
    }

    /// Volume, relative rise x mm2: the quantity that `force` measures.
    #[must_use]
    pub fn volume_mm2(&self) -> f64 {
        self.rise * std::f64::consts::PI * self.radius_mm * self.radius_mm / 2.0
    }

    /// Share of the rise at a point, 0 to 1.
    #[must_use]
    pub fn rise_share(&self, [x, y]: PointMm) -> f64 {
        let (dx, dy) = (x - self.centre_mm[0], y - self.centre_mm[1]);
        (1.0 - (dx * dx + dy * dy) / (self.radius_mm * self.radius_mm)).max(0.0)
    }

    /// Derivatives of the factor by x, y (1/mm), radius (1/mm) and rise.
    #[must_use]
    pub fn derivatives(&self, [x, y]: PointMm) -> [f64; PRESS_UNKNOWNS] {
        let share = self.rise_share([x, y]);
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

/// Factor of the conductivity at a point under several presses.
#[must_use]
pub fn conductivity_factor(presses: &[Press], sign: TouchSign, point: PointMm) -> f64 {
    let factor: f64 = presses.iter().map(|press| press.factor(point)).product();
    match sign {
        TouchSign::Rise => factor,
        TouchSign::Fall => 1.0 / factor,
    }
}
