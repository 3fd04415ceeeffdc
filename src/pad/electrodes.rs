//! Electrodes: stretches of the outline.

use super::{Conductor, Outline};
use crate::types::PointMm;

/// One electrode: a stretch of the edge, counter-clockwise from `start_mm`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Electrode {
    /// Start along the edge, mm.
    pub start_mm: f64,
    /// Length along the edge, mm.
    pub width_mm: f64,
}

impl Electrode {
    /// An electrode around a place on the edge.
    #[must_use]
    pub fn centred_at(centre_mm: f64, width_mm: f64) -> Self {
        Self {
            start_mm: centre_mm - width_mm / 2.0,
            width_mm,
        }
    }

    /// End along the edge, mm; may exceed the perimeter.
    #[must_use]
    pub fn end_mm(&self) -> f64 {
        self.start_mm + self.width_mm
    }

    /// Centre on the pad, mm.
    #[must_use]
    pub fn centre_mm(&self, outline: &Outline) -> PointMm {
        outline.point_at(self.start_mm + self.width_mm / 2.0)
    }

    /// Whether a distance along the edge lies within the electrode.
    #[must_use]
    pub fn covers(&self, outline: &Outline, along_mm: f64) -> bool {
        (along_mm - self.start_mm).rem_euclid(outline.perimeter_mm()) <= self.width_mm
    }

    /// Share of its length that touches conductor, 0 to 1, sampled.
    #[must_use]
    pub fn contact_share(&self, outline: &Outline, conductor: &Conductor) -> f64 {
        const SAMPLES: usize = 64;
        let touching = (0..SAMPLES).filter(|sample| {
            let share = (*sample as f64 + 0.5) / SAMPLES as f64;
            conductor.contains(outline.point_at(self.start_mm + share * self.width_mm))
        });
        touching.count() as f64 / SAMPLES as f64
    }
}
