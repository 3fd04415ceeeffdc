//! A finger that landed less than a frame ago: its place is fitted again with every part, until each channel has been read under it.

use super::fit::Fitted;
use super::onset::OnsetModel;
use super::readings::PartReadings;
use crate::touch::Detector;
use crate::types::Part;

/// The finger and the readings since it landed, as changes beside the others.
#[derive(Clone, Debug)]
pub(super) struct Landing {
    /// The relative change of each channel by the touches that were down before.
    base: Vec<f32>,
    parts: Vec<PartReadings>,
    pub(super) fitted: Fitted,
}

impl Landing {
    /// A finger that was fitted to some readings, beside touches that change the channels by `base`.
    pub(super) fn new<'a>(
        fitted: Fitted,
        readings: impl Iterator<Item = &'a PartReadings>,
        base: &[f32],
    ) -> Self {
        Self {
            base: base.to_vec(),
            parts: readings.cloned().collect(),
            fitted,
        }
    }

    /// Adds a part and fits the finger again. Whether every channel was read under it.
    pub(super) fn add(&mut self, detector: &Detector, model: &OnsetModel, part: &Part) -> bool {
        let mut readings = PartReadings::default();
        readings.take(detector, part, |channel| self.base[channel]);
        self.parts.push(readings);
        if let Some(fitted) = model.fit(self.fitted.touch, self.parts.iter()) {
            self.fitted = fitted;
        }
        let read: usize = self.parts.iter().map(|part| part.changes.len()).sum();
        read >= self.base.len()
    }

    /// The relative change of a channel by all touches.
    pub(super) fn expected(&self, channel: usize) -> f32 {
        self.base[channel] + self.fitted.response[channel]
    }
}
