//! What happens to a pad while fingers play on it: the hand's heel, bending, drying.
//!
//! Each is solved once at its full size; what it changes is then scaled in time and multiplied with the readings under the
//! fingers, which is exact to first order.

use std::f64::consts::TAU;

use super::super::specimen::Specimen;
use crate::pad::Pad;
use crate::study::StudyError;
use crate::types::PointMm;

/// When it begins, s.
const START_S: f64 = 4.0;
/// How long the heel lies there, s.
const HEEL_S: f64 = 10.0;
/// How long the heel takes to land or lift, s.
const HEEL_EDGE_S: f64 = 0.05;
/// Half-axes of the heel of a hand, mm, and its relative rise.
const HEEL_MM: [f64; 2] = [20.0, 12.0];
const HEEL_RISE: f64 = 1.0;
/// Where the middle of the heel lies, as shares of the pad's width and height.
const HEEL_AT: [f64; 2] = [0.7, 0.2];
/// Fingers beside the heel are at least this far from its middle, mm.
const BESIDE_HEEL_MM: f64 = 40.0;
/// Relative change of the conductivity where the pad bends most, and the time of one bend and back, s.
const BENT: f64 = 0.01;
const BEND_S: f64 = 3.0;
/// Share that dries at an edge, within so many mm, in how many s.
const DRIED: f64 = 0.1;
const DRY_WIDTH_MM: f64 = 15.0;
const DRY_S: f64 = 10.0;

/// What happens around the fingers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surroundings {
    /// Nothing.
    Still,
    /// The heel of the hand, 40 x 24 mm, lies on the pad for ten seconds.
    Heel,
    /// The pad is bent back and forth: the conductivity changes smoothly by up to 1 %.
    Bending,
    /// An edge dries by 10 % in ten seconds.
    DryingEdge,
}

impl Surroundings {
    /// The relative change of each reading at full size; empty if nothing happens.
    pub(super) fn solve(
        self,
        pad: &Pad,
        scale: f64,
        specimen: &Specimen,
    ) -> Result<Vec<f64>, StudyError> {
        let size_mm = pad.outline.size_mm();
        let factor = move |[x, y]: PointMm| match self {
            Self::Still => 1.0,
            Self::Heel => {
                let [dx, dy] = heel_offset_mm(size_mm, [x, y]);
                let [u, v] = [dx / HEEL_MM[0] / scale, dy / HEEL_MM[1] / scale];
                1.0 + HEEL_RISE * (1.0 - u * u - v * v).max(0.0)
            }
            Self::Bending => 1.0 + BENT * libm::sin(TAU * (x / size_mm[0] + 0.5 * y / size_mm[1])),
            Self::DryingEdge => 1.0 - DRIED * (1.0 - x / (scale * DRY_WIDTH_MM)).max(0.0),
        };
        if self == Self::Still {
            return Ok(Vec::new());
        }
        let volts = specimen.touched(factor)?.voltages(&pad.protocol);
        let changes = volts.iter().zip(&specimen.rest);
        Ok(changes.map(|(volt, rest)| volt / rest - 1.0).collect())
    }

    /// The share of its full size at a time.
    pub(super) fn share(self, t_s: f64) -> f64 {
        let t_s = t_s - START_S;
        if t_s < 0.0 {
            return 0.0;
        }
        match self {
            Self::Still => 0.0,
            Self::Heel => {
                let from_ends_s = t_s.min(HEEL_S - t_s);
                (from_ends_s / HEEL_EDGE_S).clamp(0.0, 1.0)
            }
            Self::Bending => libm::sin(TAU * t_s / BEND_S),
            Self::DryingEdge => (t_s / DRY_S).min(1.0),
        }
    }

    /// Whether a finger may press at a place: not on the heel.
    pub(super) fn leaves_room(self, pad: &Pad, scale: f64, place_mm: PointMm) -> bool {
        let [dx, dy] = heel_offset_mm(pad.outline.size_mm(), place_mm);
        self != Self::Heel || libm::hypot(dx, dy) >= scale * BESIDE_HEEL_MM
    }
}

/// A place as seen from the middle of the heel, mm.
fn heel_offset_mm(size_mm: [f64; 2], place_mm: PointMm) -> PointMm {
    [0, 1].map(|k| place_mm[k] - HEEL_AT[k] * size_mm[k])
}
