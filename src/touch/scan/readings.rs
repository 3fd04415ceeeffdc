//! The readings of a part, as changes beside the touches that are down.

use std::ops::Range;

use crate::touch::Detector;
use crate::types::Part;

/// Model error as a share of the change that touches explain.
pub(super) const MODEL_ERROR: f64 = 0.05;

/// Changes of consecutive channels, and one over the variance of each; 0 for a channel that does not count.
#[derive(Clone, Debug, Default)]
pub(super) struct PartReadings {
    pub(super) first: usize,
    pub(super) changes: Vec<f32>,
    pub(super) precisions: Vec<f32>,
}

impl PartReadings {
    /// The channels.
    pub(super) fn span(&self) -> Range<usize> {
        self.first..self.first + self.changes.len()
    }

    /// Copies other readings, into the memory that is there.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.first = other.first;
        self.changes.clone_from(&other.changes);
        self.precisions.clone_from(&other.precisions);
    }

    /// Channel, change and precision of each reading.
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, f64, f64)> + '_ {
        let values = self.changes.iter().zip(&self.precisions);
        values.enumerate().map(|(k, (change, precision))| {
            (self.first + k, f64::from(*change), f64::from(*precision))
        })
    }

    /// Takes a part, without the relative change of each channel that is expected.
    pub(super) fn take(
        &mut self,
        detector: &Detector,
        part: &Part,
        expected: impl Fn(usize) -> f32,
    ) {
        let reference = detector.reference();
        self.first = part.first;
        self.changes.clear();
        self.precisions.clear();
        for (k, volt) in part.volts.iter().enumerate() {
            let channel = part.first + k;
            let expected = f64::from(expected(channel));
            let change = f64::from(*volt) / reference.volts()[channel] - 1.0 - expected;
            let [noise, doubt] = reference.variances(channel);
            let model = MODEL_ERROR * expected;
            let variance = noise + doubt + model * model;
            let is_used = !reference.is_muted(channel) && change.is_finite() && variance > 0.0;
            let (change, precision) = if is_used {
                (change, 1.0 / variance)
            } else {
                (0.0, 0.0)
            };
            self.changes.push(change as f32);
            self.precisions.push(precision as f32);
        }
    }
}
