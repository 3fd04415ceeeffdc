//! New touches are fitted again from other sizes.
//!
//! Where a finger lies over a hole of a lattice, a small hard one and a wide soft one beside it change the readings nearly alike,
//! and a fit that starts from a typical finger may end at the wrong one.

use super::locator::{Locator, volume_mm2};
use super::new_touches::NEW_TOUCH_STEPS;
use crate::eit::cholesky::add_scaled;
use crate::eit::response::{MOST_STRENGTH, Shape, TouchModel, strength_from_rise};

/// Where the fits start between the least and the largest log radius.
const STARTS: [f64; 3] = [0.1, 0.5, 0.9];
/// Another size explains at least this many squared deviations more: less is noise, and a typical finger is likelier.
const LEAST_GAIN: f64 = 9.0;
/// A fit that starts closer than this (log radius) to the one so far would end there, too.
const LEAST_STEP: f64 = 0.1;

impl Locator {
    /// Fits each round touch of the fit again, from other sizes of the same volume while the others stay, and takes what explains the
    /// frame much better and may be a new finger.
    pub(super) fn try_other_sizes(&mut self, noise: f64) {
        let frame = self.frame.coordinates.clone();
        let mut is_better = false;
        for index in 0..self.fit.touches.len() {
            let touch = self.fit.touches[index];
            if touch.shape != Shape::Round {
                continue;
            }
            self.frame.coordinates.clone_from(&self.fit.residual);
            let own = &self.fit.responses[index].value;
            add_scaled(&mut self.frame.coordinates, own, 1.0);
            self.try_fit(&[touch], 0);
            std::mem::swap(&mut self.trial, &mut self.best);
            let cost = self.best.cost;
            for start in self.sizes_like(&touch) {
                self.try_fit(&[start], NEW_TOUCH_STEPS);
                let mut touches = self.fit.touches.clone();
                touches[index] = self.trial.touches[0];
                if self.trial.cost < self.best.cost && self.may_be_fingers(&touches) {
                    std::mem::swap(&mut self.trial, &mut self.best);
                }
            }
            let best = self.best.touches[0];
            if best != touch && self.best.cost < cost - LEAST_GAIN * noise {
                is_better = true;
                self.fit.touches[index] = best;
                self.fit.responses[index].clone_from(&self.best.responses[0]);
                self.fit.residual.clone_from(&self.best.residual);
            }
        }
        self.frame.coordinates = frame;
        if is_better {
            self.fit_again();
        }
    }

    /// The touch with other radii, and rises that keep its volume.
    fn sizes_like(&self, touch: &TouchModel) -> Vec<TouchModel> {
        let [least, most] = self.bounds.log_radius;
        STARTS
            .iter()
            .map(|share| least + share * (most - least))
            .filter(|log_radius| (log_radius - touch.log_radius).abs() > LEAST_STEP)
            .map(|log_radius| {
                let area_mm2 = 0.5 * std::f64::consts::PI * libm::exp(2.0 * log_radius);
                let strength = strength_from_rise(volume_mm2(touch) / area_mm2);
                TouchModel {
                    log_radius,
                    strength: strength.min(MOST_STRENGTH),
                    ..*touch
                }
            })
            .collect()
    }
}
