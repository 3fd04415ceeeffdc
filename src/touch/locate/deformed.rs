//! Frames of a pad that has deformed: where patterns of deformation explain a residual better than a finger does, they are
//! taken out of the frame, and the detector moves the reference by them.

use super::locator::Locator;
use super::metric::{dot, energy};
use super::motion::Motion;

/// A deformation explains at least this many squared deviations: noise does once in minutes, and then it costs nothing.
const LEAST_GAIN: f64 = 60.0;
/// While channels are excluded, a reference that noise has moved is wrong near the lost electrodes and looks like a touch there. So a
/// deformation must explain more than noise does in a day.
const LEAST_GAIN_BLIND: f64 = 85.0;
/// Under touches it explains this share of their model error as well.
const ERROR_SHARE: f64 = 0.25;
/// A frame of which more than this many times noise and model error is nothing that a change of conductivity explains shows a
/// bad electrode.
const SOUND_OUTSIDE: f64 = 2.0;
/// Touches that leave more than this many times noise and model error are not yet found.
const SETTLED_REST: f64 = 3.0;
/// It explains, beyond noise, this many times what a finger explains.
const BETTER: f64 = 1.2;
/// Steps of the fit of that finger.
const FIT_STEPS: usize = 15;
/// It changes readings by less than this share from one frame to the next (root mean square); a palm changes them by more.
const MOST_CHANGE: f64 = 4e-3;
/// Under touches it changes them by less than this: more is what the model does not know of the touches.
const MOST_CHANGE_UNDER_TOUCHES: f64 = 1.2e-3;

impl Locator {
    /// Whether a deformation of the pad may explain a residual better than a finger does; `noise` is the variance of the
    /// residual's readings. [`Self::take_deformation`] then decides.
    pub(super) fn may_be_deformed(&self, residual: &[f32], noise: f64) -> bool {
        let gain = self.model.deformations.gain(residual);
        let least_gain = match self.model.is_blind() {
            true => LEAST_GAIN_BLIND,
            false => LEAST_GAIN,
        };
        gain >= least_gain * noise + ERROR_SHARE * self.model_error()
            && self
                .peak(residual)
                .is_none_or(|peak| BETTER * peak.gain < self.beyond_noise(gain, noise))
    }

    /// What the patterns explain beyond what they explain of noise.
    fn beyond_noise(&self, gain: f64, noise: f64) -> f64 {
        let patterns = &self.model.deformations;
        gain - noise * (patterns.whitened.len() / patterns.rank) as f64
    }

    /// Whether one finger, of any size, explains a residual about as well as the patterns do.
    fn is_finger(&mut self, residual: &[f32], noise: f64) -> bool {
        let Some(peak) = self.peak(residual) else {
            return false;
        };
        let frame = std::mem::replace(&mut self.frame.coordinates, residual.to_vec());
        let touch = self.bounds.typical(peak.place_mm);
        self.try_fit(&[touch], FIT_STEPS);
        self.frame.coordinates = frame;
        let by_finger = energy(residual) - energy(&self.trial.residual);
        let gain = self.model.deformations.gain(residual);
        BETTER * by_finger >= self.beyond_noise(gain, noise)
    }

    /// Whether the touches of the fit explain the frame well enough to look for a deformation in what they leave: no electrode is
    /// bad, and the touches are found and do not move.
    pub(super) fn is_settled(&self, noise: f64) -> bool {
        let quality = self.quality(noise);
        let is_still = |motion: &Motion| motion.step_mm() == [0.0; 2];
        quality.outside < SOUND_OUTSIDE
            && (self.fit.touches.is_empty()
                || quality.rest < SETTLED_REST && self.motions.iter().all(is_still))
    }

    /// Takes a frame in which no touch is down, and a deformation out of it.
    pub fn take_untouched(&mut self, changes: &[f32], noise: f64) {
        self.deformation.clear();
        if self.model.deformations.whitened.is_empty() || !self.fit.touches.is_empty() {
            return;
        }
        let outside = self.take_frame(changes, noise).outside;
        if outside < SOUND_OUTSIDE && self.may_be_deformed(&self.frame.coordinates, noise) {
            let residual = self.frame.coordinates.clone();
            self.take_deformation(&residual, noise);
        }
    }

    /// Takes what the patterns explain of a residual out of the frame, and fits the touches again. Returns whether it did: not
    /// if a finger explains it as well, or if it is more than a pad deforms by.
    pub(super) fn take_deformation(&mut self, residual: &[f32], noise: f64) -> bool {
        if self.is_finger(residual, noise) {
            return false;
        }
        let model = &self.model;
        let rank = model.deformations.rank;
        let mut change = vec![0.0f32; rank];
        let mut rest = self.frame.coordinates.clone();
        for (pattern, coordinates) in model
            .deformations
            .whitened
            .chunks_exact(rank)
            .zip(model.deformations.coordinates.chunks_exact(rank))
        {
            let along = dot(pattern, residual);
            for (total, value) in change.iter_mut().zip(coordinates) {
                *total += along * value;
            }
            for (value, part) in rest.iter_mut().zip(pattern) {
                *value -= along * part;
            }
        }
        // The table's basis is orthonormal: this is the sum over all channels.
        let channels = model.table.channels() as f64;
        let most_change = if self.fit.touches.is_empty() {
            MOST_CHANGE
        } else {
            MOST_CHANGE_UNDER_TOUCHES
        };
        if energy(&change) > most_change * most_change * channels {
            return false;
        }
        self.frame.energy += energy(&rest) - energy(&self.frame.coordinates);
        self.frame.coordinates = rest;
        if self.deformation.is_empty() {
            self.deformation = change;
        } else {
            for (total, value) in self.deformation.iter_mut().zip(&change) {
                *total += value;
            }
        }
        self.fit_again();
        true
    }

    /// The relative change of each channel by the deformation of the last frame, if there is one.
    pub fn deformation(&self) -> Option<Vec<f32>> {
        if self.deformation.is_empty() {
            return None;
        }
        let mut changes = vec![0.0; self.model.table.channels()];
        self.model.table.expand(&self.deformation, &mut changes);
        Some(changes)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::model::LocatorModel;
    use super::*;
    use crate::eit::ResponseTable;
    use crate::pad::{Outline, TouchSign};
    use crate::touch::ChannelNoise;

    /// A locator without, or with, excluded channels.
    fn locator(is_blind: bool) -> Locator {
        let table = Arc::new(ResponseTable::small());
        let mut noise = ChannelNoise::from(vec![1e-3; table.channels()]);
        if is_blind {
            noise.deviations[0] = f64::INFINITY;
        }
        let outline = Outline::Rectangle {
            width_mm: 60.0,
            height_mm: 40.0,
        };
        let model = LocatorModel::new(table, &outline, TouchSign::Rise, &noise, &[], None);
        Locator::new(Arc::new(model))
    }

    /// A residual of which the patterns explain so many squared deviations, in all of them alike.
    fn residual(locator: &Locator, gain: f64) -> Vec<f32> {
        let patterns = &locator.model.deformations;
        let count = patterns.whitened.len() / patterns.rank;
        let along = libm::sqrt(gain / count as f64) as f32;
        let mut residual = vec![0.0; patterns.rank];
        for pattern in patterns.whitened.chunks_exact(patterns.rank) {
            for (total, value) in residual.iter_mut().zip(pattern) {
                *total += along * value;
            }
        }
        residual
    }

    #[test]
    fn with_excluded_channels_what_noise_does_once_in_minutes_is_no_deformation() {
        for (is_blind, gain, expected) in [
            (false, 55.0, false),
            (false, 75.0, true),
            (true, 75.0, false),
            (true, 95.0, true),
        ] {
            let locator = locator(is_blind);
            let residual = residual(&locator, gain);
            let is_deformed = locator.may_be_deformed(&residual, 1.0);
            assert_eq!(is_deformed, expected, "blind: {is_blind}, gain {gain}");
        }
    }
}
