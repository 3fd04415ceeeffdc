//! The residuals of the last few frames with the same touches.

use super::metric::energy;

/// A touch too faint for one frame is searched for in the mean of this many.
pub(super) const MEAN_FRAMES: usize = 4;
/// After a failed search, the next one waits until the residual has grown by this factor.
pub(super) const REFUSED_GROWTH: f64 = 1.3;
/// Frames after a touch began or ended, during which the reference still finds its level: a faint touch could not be
/// distinguished from its error.
const SETTLING_FRAMES: usize = 20;

/// Weight of a frame in the share that a mean keeps: a time constant of two seconds. The first frames count alike, so that wandering
/// noise is known as soon as the first means are searched.
const KEPT_WEIGHT: f64 = 0.005;
/// Noise counts as wandering if its mean keeps this many times the share of independent frames.
const WANDERS: f64 = 1.3;

/// The last residuals and their mean.
#[derive(Clone, Debug, Default)]
pub(super) struct RecentResiduals {
    touches: usize,
    pushed: usize,
    residuals: [Vec<f32>; MEAN_FRAMES],
    mean: Vec<f32>,
    /// The gain of the last failed search with these touches.
    refused_gain: f64,
    /// Share of a residual's energy that its mean over the frames keeps on an untouched pad: a quarter if the noise of
    /// frames is independent, more if it wanders.
    kept_share: f64,
    /// Number of frames in that share.
    kept_frames: u32,
}

impl RecentResiduals {
    /// Forgets all residuals.
    pub(super) fn clear(&mut self) {
        self.pushed = 0;
        self.refused_gain = 0.0;
    }

    /// Whether a gain is far above that of the last failed search. If so, it is stored, as the next search may fail too.
    pub(super) fn exceeds_refused(&mut self, gain: f64) -> bool {
        let exceeds = gain > REFUSED_GROWTH * self.refused_gain;
        if exceeds {
            self.refused_gain = gain;
        }
        exceeds
    }

    /// Adds the residual of a frame with the given number of touches. Returns the number of residuals in the mean: 0
    /// while the reference settles.
    pub(super) fn push(&mut self, touches: usize, residual: &[f32]) -> usize {
        if touches != self.touches {
            self.touches = touches;
            self.clear();
        }
        let slot = &mut self.residuals[self.pushed % MEAN_FRAMES];
        slot.clear();
        slot.extend_from_slice(residual);
        self.pushed += 1;
        if self.pushed < SETTLING_FRAMES {
            return 0;
        }
        let count = self.pushed.min(MEAN_FRAMES);
        self.mean.clear();
        self.mean.resize(residual.len(), 0.0);
        for residual in &self.residuals[..count] {
            for (sum, value) in self.mean.iter_mut().zip(residual) {
                *sum += value / count as f32;
            }
        }
        if touches == 0 {
            let kept = energy(&self.mean) / energy(residual).max(f64::MIN_POSITIVE);
            self.kept_frames = self.kept_frames.saturating_add(1);
            let weight = KEPT_WEIGHT.max(1.0 / f64::from(self.kept_frames));
            self.kept_share += weight * (kept.min(1.0) - self.kept_share);
        }
        count
    }

    /// The share of a single frame's noise that is left in the mean: at least what independent frames leave.
    pub(super) fn noise_share(&self) -> f64 {
        let independent = 1.0 / MEAN_FRAMES as f64;
        if self.kept_share > WANDERS * independent {
            self.kept_share
        } else {
            independent
        }
    }

    /// The mean of the last residuals.
    pub(super) fn mean(&self) -> &[f32] {
        &self.mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wandering_noise_is_known_from_the_first_mean_on() {
        let mut recent = RecentResiduals::default();
        for _ in 0..SETTLING_FRAMES + MEAN_FRAMES {
            recent.push(0, &[1.0, -1.0]);
        }
        assert_eq!(recent.noise_share(), 1.0, "all of it stays in the mean");
    }

    #[test]
    fn the_mean_is_of_the_last_residuals_with_the_same_touches() {
        let mut recent = RecentResiduals::default();
        for value in 1..SETTLING_FRAMES {
            assert_eq!(recent.push(1, &[value as f32]), 0, "settling");
        }
        assert_eq!(recent.push(1, &[SETTLING_FRAMES as f32]), MEAN_FRAMES);
        assert_eq!(recent.mean(), [SETTLING_FRAMES as f32 - 1.5]);
        assert_eq!(recent.push(2, &[9.0]), 0, "another touch");
    }
}
