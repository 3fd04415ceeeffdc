//! The responses of a pad that only presses describe, from its learned maps.
//!
//! A map tells what a typical press does at each place, and nothing about wider or harder ones. Responses are taken to grow with area
//! and strength alone, and falling touches to be the opposite of rising ones.

use std::sync::Arc;

use super::places::Places;
use super::terms::{POWERS, SIGNS};
use super::touch_model::strength_from_rise;
use crate::pad::{LearnedMaps, Pad};
use crate::types::PointMm;

/// Rise of conductivity x area that a typical press counts as, mm2: half of full force.
pub const TYPICAL_PRESS_MM2: f64 = 75.0;

/// Learned maps on the grid of a table.
#[derive(Clone, Debug)]
pub(super) struct LearnedResponses {
    maps: Arc<LearnedMaps>,
    size_mm: [f64; 2],
    /// One over radius squared (mm2) and strength of a typical press.
    scale: f64,
}

impl LearnedResponses {
    /// Prepares the maps of a pad.
    pub(super) fn new(pad: &Pad, maps: &Arc<LearnedMaps>) -> Self {
        let size_mm = pad.outline.size_mm();
        let radii_mm = Places::new(size_mm).radii_mm();
        let radius_mm = radii_mm[radii_mm.len() / 2];
        let area_mm2 = 0.5 * std::f64::consts::PI * radius_mm * radius_mm;
        let strength = strength_from_rise(TYPICAL_PRESS_MM2 / area_mm2);
        Self {
            maps: Arc::clone(maps),
            size_mm,
            scale: 1.0 / (radius_mm * radius_mm * strength),
        }
    }

    /// Responses at a place (mm), divided by radius squared and strength, the same for every radius and strength: signs x strengths x
    /// channels.
    pub(super) fn samples(&self, centre_mm: PointMm) -> Vec<f32> {
        let changes = self.maps.changes_at(centre_mm, self.size_mm);
        let mut samples = Vec::with_capacity(SIGNS * POWERS * changes.len());
        for sign in [1.0, -1.0] {
            for _ in 0..POWERS {
                samples.extend(
                    changes
                        .iter()
                        .map(|change| (sign * self.scale * change) as f32),
                );
            }
        }
        samples
    }
}
