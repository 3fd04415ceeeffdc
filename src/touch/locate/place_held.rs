//! Places held fingers by one fit to the mean of their frames (`held.rs`).

use super::fit::Bounds;
use super::locator::Locator;
use crate::eit::response::TouchModel;

/// Steps of the fit.
const STEPS: usize = 8;

impl Locator {
    /// Starts the means of all touches again: they hold a damaged frame, or were made with other weights.
    pub(super) fn forget_held(&mut self) {
        for motion in &mut self.motions {
            motion.forget_held();
        }
    }

    /// Places every touch that does not move by the mean of its frames.
    pub(super) fn place_held(&mut self, noise: f64) {
        for (index, motion) in self.motions.iter_mut().enumerate() {
            let response = &self.fit.responses[index].value;
            let Some(held) = motion.hold(response, &self.fit.residual) else {
                continue;
            };
            let bounds = Bounds {
                prior_weight: noise / f64::from(held.frames()),
                ..self.bounds
            };
            let problem = self.model.problem(held.mean(), &bounds);
            // A single frame's fit may have ended beside the least cost.
            let peak = || {
                let found = self
                    .model
                    .templates
                    .peak(&held.mean().coordinates, bounds.sign);
                found.map(|peak| bounds.typical(peak.place_mm))
            };
            let starts = [
                Some(self.fit.touches[index]),
                held.touch().copied().or_else(peak),
            ];
            let mut best: Option<(f64, TouchModel)> = None;
            for start in starts.into_iter().flatten() {
                self.trial.set_touches(&[start], problem);
                self.trial.descend(STEPS, problem);
                if best.is_none_or(|(cost, _)| self.trial.cost < cost) {
                    best = Some((self.trial.cost, self.trial.touches[0]));
                }
            }
            if let Some((_, touch)) = best {
                held.set_touch(touch);
            }
            motion.leave_lagging_mean();
        }
    }
}
