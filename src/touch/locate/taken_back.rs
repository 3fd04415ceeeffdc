//! Takes deformations back that were none.
//!
//! What the model does not know of a touch looks like a bend of the pad, and a part of it is taken for one. When the finger lifts, that bend
//! is gone at once, and what is left of it would look like a faint finger. So the locator remembers what the pad has bent by since the first
//! finger landed, and takes back the share of it that explains a frame better: one unknown, where a new bend has twenty and a new touch
//! four.

use super::deformed::ERROR_SHARE;
use super::locator::Locator;
use super::metric::{dot, energy};
use crate::eit::cholesky::add_scaled;

/// What is taken back explains at least this many squared deviations: twice what noise explains in one of a thousand frames.
const LEAST_GAIN: f64 = 20.0;

impl Locator {
    /// Remembers the deformation of the frame, which the detector has followed.
    pub(in crate::touch) fn keep_deformation(&mut self) {
        let was_untouched = self.before.is_empty();
        if was_untouched {
            self.bent.clear();
        }
        if self.deformation.is_empty() || was_untouched && self.fit.touches.is_empty() {
            return;
        }
        self.bent.resize(self.deformation.len(), 0.0);
        add_scaled(&mut self.bent, &self.deformation, 1.0);
    }

    /// Takes back the share of what the pad has bent by under touches that explains the frame better; fits the touches again.
    pub(super) fn take_back_bend(&mut self, noise: f64) {
        if self.bent.is_empty() {
            return;
        }
        let mut whitened = self.bent.clone();
        self.model.metric.whiten_coordinates(&mut whitened);
        let along = f64::from(-dot(&self.fit.residual, &whitened));
        let square = energy(&whitened).max(f64::MIN_POSITIVE);
        let share = (along / square).clamp(0.0, 1.0);
        let gain = share * (2.0 * along - share * square);
        if gain < LEAST_GAIN * noise + ERROR_SHARE * self.model_error() {
            return;
        }
        let before = energy(&self.frame.coordinates);
        add_scaled(&mut self.frame.coordinates, &whitened, share as f32);
        self.frame.energy += energy(&self.frame.coordinates) - before;
        self.deformation.resize(self.bent.len(), 0.0);
        add_scaled(&mut self.deformation, &self.bent, -share as f32);
        self.fit_again();
    }
}
