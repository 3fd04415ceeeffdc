//! Frames of a pad that has deformed: where patterns of deformation explain a residual better than a finger does, they are
//! taken out of the frame, and the detector moves the reference by them.

use super::locator::{Locator, stay_ratio};
use super::metric::{dot, energy};
use super::motion::{Motion, nearest};
use crate::eit::cholesky::add_scaled;

/// A deformation explains at least this many squared deviations: noise does once in minutes, and then it costs nothing. While electrodes are
/// lost it may cost a short touch in hours; but with 85, a bend that is followed later makes several times as many.
const LEAST_GAIN: f64 = 60.0;
/// Under touches it explains this share of their model error as well.
pub(super) const ERROR_SHARE: f64 = 0.25;
/// A frame of which more than this many times noise and model error is nothing that a change of conductivity explains shows a
/// bad electrode.
const SOUND_OUTSIDE: f64 = 2.0;
/// Touches that leave more than this many times noise and model error are not yet found.
const SETTLED_REST: f64 = 3.0;
/// It explains, beyond noise, this many times what a finger explains, ...
const BETTER: f64 = 1.2;
/// ... and this many times what a touch explains that has just become much weaker: rather it has lifted.
const BETTER_THAN_LIFTING: f64 = 1.0;
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
        gain >= LEAST_GAIN * noise + ERROR_SHARE * self.model_error()
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

    /// Ends touches where a deformation explains the frame better: a finger has lifted, and what is left of its touch explains a
    /// part of what the pad has bent by while it lay there. Not while channels are excluded: what the patterns extrapolate to them
    /// would end touches, and they would begin again.
    pub(super) fn end_deformed(&mut self, noise: f64) {
        if self.model.deformations.whitened.is_empty()
            || self.model.is_blind()
            || self.quality(noise).outside >= SOUND_OUTSIDE
        {
            return;
        }
        let mut index = 0;
        while index < self.fit.touches.len() {
            let mut without = self.fit.residual.clone();
            add_scaled(&mut without, &self.fit.responses[index].value, 1.0);
            let by_touch = energy(&without) - energy(&self.fit.residual);
            let gain = self.model.deformations.gain(&without);
            let better = if self.is_lifting(index, noise) {
                BETTER_THAN_LIFTING
            } else {
                BETTER
            };
            // Other touches leave of the frame what the model does not know of them, and patterns explain that, too.
            let by_patterns = self.beyond_noise(gain, noise) - self.model_error();
            let is_deformed = gain >= LEAST_GAIN * noise
                && by_patterns > better * by_touch
                && self.seen_change(&self.change_by_patterns(&without, 1.0)) <= MOST_CHANGE;
            if is_deformed {
                self.fit.touches.remove(index);
                self.fit_again();
                index = 0;
            } else {
                index += 1;
            }
        }
    }

    /// A share of the change that the patterns explain of a residual, in the table's coordinates.
    fn change_by_patterns(&self, residual: &[f32], share: f32) -> Vec<f32> {
        let patterns = &self.model.deformations;
        let mut change = vec![0.0f32; patterns.rank];
        for (pattern, coordinates) in (patterns.whitened.chunks_exact(patterns.rank))
            .zip(patterns.coordinates.chunks_exact(patterns.rank))
        {
            add_scaled(&mut change, coordinates, share * dot(pattern, residual));
        }
        change
    }

    /// Whether a touch of the fit has just become much weaker.
    fn is_lifting(&self, index: usize, noise: f64) -> bool {
        let touch = &self.fit.touches[index];
        let ratio = stay_ratio(touch, &self.fit.responses[index], noise);
        nearest(&self.motions, touch.centre_mm)
            .is_some_and(|which| self.motions[which].fades(ratio))
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

    /// Takes what the patterns explain of a residual beyond noise out of the frame, and fits the touches again. Returns whether it did:
    /// not if a finger explains it as well, or if it is more than a pad deforms by.
    ///
    /// Of the readings of a coarse converter, whose noise is not known well, the amplitudes are taken by that share only (James and Stein
    /// 1961): the whole would carry this frame's noise into the reference, and the next frame would show it as another deformation, and
    /// so on. Otherwise this is rare, and the whole follows a pad that bends better.
    pub(super) fn take_deformation(&mut self, residual: &[f32], noise: f64) -> bool {
        if self.is_finger(residual, noise) {
            return false;
        }
        let model = &self.model;
        let gain = model.deformations.gain(residual);
        let share = match self.is_rounded {
            true => (self.beyond_noise(gain, noise) / gain).max(0.0) as f32,
            false => 1.0,
        };
        let change = self.change_by_patterns(residual, share);
        let mut rest = self.frame.coordinates.clone();
        for pattern in model
            .deformations
            .whitened
            .chunks_exact(model.deformations.rank)
        {
            add_scaled(&mut rest, pattern, -share * dot(pattern, residual));
        }
        let most_change = if self.fit.touches.is_empty() {
            MOST_CHANGE
        } else {
            MOST_CHANGE_UNDER_TOUCHES
        };
        if self.seen_change(&change) > most_change {
            return false;
        }
        self.frame.energy += energy(&rest) - energy(&self.frame.coordinates);
        self.frame.coordinates = rest;
        self.deformation.resize(change.len(), 0.0);
        add_scaled(&mut self.deformation, &change, 1.0);
        self.fit_again();
        true
    }

    /// The relative change of the channels that are not excluded, root mean square, of a change in the table's coordinates. What
    /// the patterns extrapolate to excluded channels can be many times larger, and is nothing that was measured.
    fn seen_change(&self, coordinates: &[f32]) -> f64 {
        let model = &self.model;
        let mut changes = vec![0.0; model.table.channels()];
        model.table.expand(coordinates, &mut changes);
        let seen: Vec<f32> = (changes.iter().zip(model.metric.are_counted()))
            .filter_map(|(change, is_counted)| is_counted.then_some(*change))
            .collect();
        libm::sqrt(energy(&seen) / seen.len().max(1) as f64)
    }

    /// The relative change of each channel by the deformation of the last frame, if there is one; 0 for excluded channels, of which
    /// nothing was measured.
    pub fn deformation(&self) -> Option<Vec<f32>> {
        if self.deformation.is_empty() {
            return None;
        }
        let mut changes = vec![0.0; self.model.table.channels()];
        self.model.table.expand(&self.deformation, &mut changes);
        for (change, is_counted) in changes.iter_mut().zip(self.model.metric.are_counted()) {
            if !is_counted {
                *change = 0.0;
            }
        }
        Some(changes)
    }
}
