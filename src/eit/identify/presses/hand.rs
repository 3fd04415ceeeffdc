//! How a person presses: how far from the shown places, with how large a finger, and how hard.
//!
//! This is learned together with the pad. Every press has its own place, size and strength (`Finger`); their means and spreads over all
//! presses are the person's (`Hand`).

use crate::eit::{PRESS_UNKNOWNS, Press};
use crate::pad::TouchSign;
use crate::types::PointMm;

/// Radius of a typical finger as a share of the pad's longer side, and its rise.
const RADIUS_SHARE: f64 = 0.07;
const RISE: f64 = 1.0;
/// A hand that is not known yet: standard deviations of how far each coordinate is beside the place, mm, and of the logarithms of radius
/// and rise. ...
const UNKNOWN_HAND: [f64; PRESS_UNKNOWNS] = [0.5, 0.5, 0.3, 0.6];
/// ... Those of the known one are within these limits.
const STEADIEST: [f64; PRESS_UNKNOWNS] = [0.1, 0.1, 0.08, 0.15];
const LEAST_STEADY: [f64; PRESS_UNKNOWNS] = [3.0, 3.0, 0.35, 0.8];

/// How a person presses.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hand {
    /// Means of the logarithms of radius (mm) and rise.
    log_radius_and_rise: [f64; 2],
    /// Standard deviations of a finger's unknowns.
    pub(super) deviations: [f64; PRESS_UNKNOWNS],
}

impl Hand {
    /// Before any press, on a pad of this size.
    pub(super) fn unknown([width_mm, height_mm]: [f64; 2]) -> Self {
        let radius_mm = RADIUS_SHARE * width_mm.max(height_mm);
        Self {
            log_radius_and_rise: [libm::log(radius_mm), libm::log(RISE)],
            deviations: UNKNOWN_HAND,
        }
    }

    /// The unknowns of a typical finger that presses exactly at a place.
    pub(super) fn typical(&self, [x, y]: PointMm) -> [f64; PRESS_UNKNOWNS] {
        let [log_radius, log_rise] = self.log_radius_and_rise;
        [x, y, log_radius, log_rise]
    }

    /// The hand that pressed these places with these fingers; itself if there are none. One step of expectation maximisation (Dempster,
    /// Laird and Rubin 1977).
    pub(super) fn learned(self, presses: &[(PointMm, Finger)]) -> Self {
        if presses.is_empty() {
            return self;
        }
        let mean = |of: &dyn Fn(&(PointMm, Finger)) -> f64| {
            presses.iter().map(of).sum::<f64>() / presses.len() as f64
        };
        let hand = Self {
            log_radius_and_rise: [2, 3].map(|k| mean(&|(_, finger)| finger.unknowns[k])),
            ..self
        };
        let variance = |k: usize| {
            mean(&|(place_mm, finger)| {
                let off = finger.unknowns[k] - hand.typical(*place_mm)[k];
                off * off + finger.variances[k]
            })
        };
        // A hand misses places in both directions alike.
        let place = 0.5 * (variance(0) + variance(1));
        let variances = [place, place, variance(2), variance(3)];
        Self {
            deviations: std::array::from_fn(|k| {
                libm::sqrt(variances[k]).clamp(STEADIEST[k], LEAST_STEADY[k])
            }),
            ..hand
        }
    }
}

/// The finger of one press, as far as it is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Finger {
    /// x and y, mm, and the logarithms of radius in mm and rise.
    pub(super) unknowns: [f64; PRESS_UNKNOWNS],
    /// Their variances, if the pad is as estimated.
    pub(super) variances: [f64; PRESS_UNKNOWNS],
    /// Whether the press raises or lowers the conductivity.
    pub(super) sign: TouchSign,
}

impl Finger {
    /// A typical finger of a hand at a place.
    pub(super) fn typical(hand: &Hand, place_mm: PointMm) -> Self {
        Self {
            unknowns: hand.typical(place_mm),
            variances: [0.0; PRESS_UNKNOWNS],
            sign: TouchSign::Rise,
        }
    }

    /// Its distance from a place.
    pub(super) fn distance_mm(&self, place_mm: PointMm) -> f64 {
        libm::hypot(
            self.unknowns[0] - place_mm[0],
            self.unknowns[1] - place_mm[1],
        )
    }

    /// Its press.
    pub(super) fn press(&self) -> Press {
        let [x, y, log_radius, log_rise] = self.unknowns;
        Press {
            centre_mm: [x, y],
            radius_mm: libm::exp(log_radius),
            rise: libm::exp(log_rise),
        }
    }
}
