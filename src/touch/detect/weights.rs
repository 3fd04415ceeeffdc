//! Which channels count, and how much: electrodes lost and back, channels that grow noisier.
//!
//! What should count is known here at once; the matrix and the weights for it are made elsewhere and taken when they are
//! there.

use super::Detector;
use crate::eit::Verdict;
use crate::types::Frame;

/// Channels are weighed anew when the noise of some (this many) has changed by this factor beside the median's; looked at
/// every so many frames.
const NOISIER: (usize, f64) = (4, 2.0);
const WEIGH_EVERY: u64 = 128;

impl Detector {
    /// Finds the electrode that spoils a frame.
    pub(super) fn blame(&mut self, frame: &Frame) {
        let Some(faults) = &mut self.faults else {
            return;
        };
        let (changes, explained) = (&self.changes, &self.explained);
        let reference = &self.reference;
        let verdict = faults.unexplained(|channel| {
            let [noise, doubt] = reference.variances(channel);
            f64::from(changes[channel] - explained[channel]) / libm::sqrt(noise + doubt)
        });
        if let Some(Verdict::Lost(electrode)) = verdict {
            for channel in faults.channels(electrode) {
                self.reference.mute(*channel, true, 0.0);
            }
        }
        self.want_if_lost();
        self.watch_lost(frame);
    }

    /// Watches the lost electrodes for their return.
    pub(super) fn watch_lost(&mut self, frame: &Frame) {
        let Some(faults) = self.faults.as_mut().filter(|faults| faults.any_lost()) else {
            return;
        };
        let (reference, explained) = (&self.reference, &self.explained);
        let change = |channel: usize| {
            let volt = f64::from(frame.volts[channel]);
            let change = volt / reference.volts()[channel] - 1.0 - f64::from(explained[channel]);
            if change.is_finite() { change } else { 1.0 }
        };
        let verdict = faults.watch(change, |channel| {
            libm::sqrt(reference.variances(channel)[0])
        });
        if let Some(Verdict::Back(electrode)) = verdict {
            for channel in faults.channels(electrode).to_vec() {
                if !faults.cuts(channel) {
                    self.reference.mute(channel, false, faults.moved(channel));
                }
            }
        }
        self.want_if_lost();
    }

    /// Asks for other weights if the channels that count are not those that should.
    pub(super) fn want_if_lost(&mut self) {
        let differ = (0..self.changes.len())
            .any(|channel| self.reference.is_muted(channel) == self.sensing.counts(channel));
        if differ && self.sensing.locating.is_some() {
            self.wanted = Some(self.reference.deviations());
        }
    }

    /// Asks for other weights if some channels have grown noisier beside the others, or quieter.
    pub(super) fn weigh_now_and_then(&mut self) {
        if self.frames.is_multiple_of(WEIGH_EVERY) {
            self.want_if_noisier();
        }
    }

    pub(super) fn want_if_noisier(&mut self) {
        if self.wanted.is_some() || self.sensing.locating.is_none() {
            return;
        }
        let now = self.reference.deviations();
        let mut ratios: Vec<f64> = now
            .iter()
            .zip(&self.sensing.deviations)
            .filter(|(now, then)| now.is_finite() && then.is_finite())
            .map(|(now, then)| now / then)
            .collect();
        ratios.sort_by(f64::total_cmp);
        let Some(median) = ratios.get(ratios.len() / 2).copied() else {
            return;
        };
        let (some, factor) = NOISIER;
        let changed = ratios
            .iter()
            .filter(|ratio| **ratio > factor * median || **ratio * factor < median)
            .count();
        if changed >= some {
            self.wanted = Some(now);
        }
    }
}
