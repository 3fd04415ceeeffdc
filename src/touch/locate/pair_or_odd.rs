//! Whether two touches close together are two fingers, or one of odd shape.
//!
//! Two touches explain a long finger, or the heel of a hand, nearly as well as two fingers. So two new touches count only if they explain
//! the frame better than a finger of odd shape does (`odd.rs`), by the more the closer they are and the less the pad is known.

use super::located_pad::FOUND_ERROR;
use super::locator::{DOWN_GAIN, Locator};
use super::metric::energy;
use super::new_touches::{NEW_TOUCH_STEPS, edited};
use crate::eit::cholesky::add_scaled;
use crate::eit::response::{Shape, TouchModel};
use crate::types::distance_mm;

/// Two touches closer than the first of [`FINGER_WIDTH_MM`] must explain more than one odd finger does: more by this many times what a
/// new touch must explain. ...
const ODD_GAINS: f64 = 2.0;
/// ... Farther apart less, and nothing from the second distance on, mm: fingers are seldom closer than they are wide.
const FINGER_WIDTH_MM: [f64; 2] = [11.0, 12.5];
/// Two touches must in any case explain more than one odd finger by this share of the model error, ...
const ODD_ERROR_SHARE: f64 = 0.35;
/// ... and of no poorer model than that of a pad as found. The share falls to nothing between these distances, mm: odd fingers are rarer
/// the longer they are.
const LONG_FINGER_MM: [f64; 2] = [15.0, 18.0];
/// What a poor model leaves of a heel is two touches of which one is as wide as touches get, above this share of the greatest radius. They
/// must explain more by this share of the pad's own model error, ...
const WIDE_SHARE: f64 = 0.95;
const WIDE_ERROR_SHARE: f64 = 0.8;
/// ... which falls to nothing between these distances, mm.
const WIDE_PAIR_MM: [f64; 2] = [18.0, 20.0];
/// Two touches closer than this, mm, may be one odd finger.
const ODD_REACH_MM: f64 = 20.0;

impl Locator {
    /// The touches of the best trial with one finger of odd shape instead of the two nearest ones, if that explains the frame about as
    /// well.
    pub(super) fn odd_instead(&self, noise: f64) -> Option<Vec<TouchModel>> {
        if !self.model.table.has_both_signs() {
            return None;
        }
        let touches = &self.best.touches;
        let pairs = (0..touches.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        let (apart_mm, i, j) = pairs
            .map(|(i, j)| {
                let apart_mm = distance_mm(touches[i].centre_mm, touches[j].centre_mm);
                (apart_mm, i, j)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))?;
        if apart_mm >= ODD_REACH_MM {
            return None;
        }
        let mut target = self.best.residual.clone();
        for index in [i, j] {
            add_scaled(&mut target, &self.best.responses[index].value, 1.0);
        }
        let odd = self.odd_finger(&target, [touches[i].centre_mm, touches[j].centre_mm]);
        let pair = energy(&self.best.residual) - self.interaction_gain([i, j]);
        let error = self.model.error_energy(energy(&target));
        let widest = libm::exp(self.bounds.log_radius[1]);
        let is_wide = |index: usize| libm::exp(touches[index].log_radius) >= WIDE_SHARE * widest;
        let more = if is_wide(i) || is_wide(j) {
            WIDE_ERROR_SHARE * fading(apart_mm, WIDE_PAIR_MM) * error
        } else if matches!(odd.touch.shape, Shape::Palm { .. }) {
            // Two fingers are commoner than palms, which have to explain the frame better.
            0.0
        } else {
            let long_error = error.min(FOUND_ERROR * FOUND_ERROR * energy(&target));
            let long = ODD_ERROR_SHARE * fading(apart_mm, LONG_FINGER_MM) * long_error;
            let narrow = ODD_GAINS * fading(apart_mm, FINGER_WIDTH_MM);
            long.max(narrow * (DOWN_GAIN * noise + error))
        };
        let is_odd = odd.cost < pair + more;
        is_odd.then(|| {
            let others = edited(touches, &[odd.touch], Some(i));
            edited(&others, &[], Some(j))
        })
    }

    /// Takes touches with a finger of odd shape if they explain enough more than those so far.
    pub(super) fn take_odd(&mut self, touches: &[TouchModel], least_gain: f64) -> bool {
        self.try_fit(touches, NEW_TOUCH_STEPS);
        let is_better = self.fit.cost - self.trial.cost >= least_gain;
        if is_better {
            std::mem::swap(&mut self.fit, &mut self.trial);
        }
        is_better
    }
}

/// One up to the first distance, nothing from the second one on.
fn fading(apart_mm: f64, [from_mm, to_mm]: [f64; 2]) -> f64 {
    ((to_mm - apart_mm) / (to_mm - from_mm)).clamp(0.0, 1.0)
}
