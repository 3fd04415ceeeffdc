//! A finger that landed less than a frame ago: its place is fitted again with every part, until each channel has been read under it.

use super::fit::{FitMemory, Fitted};
use super::onset::OnsetModel;
use super::readings::PartReadings;
use crate::touch::Detector;
use crate::types::Part;

/// The finger and the readings since it landed, as changes beside the others.
#[derive(Clone, Debug, Default)]
pub(super) struct Landing {
    /// None while no finger lands.
    finger: Option<Fitted>,
    /// The relative change of each channel by the finger, ...
    response: Vec<f32>,
    /// ... and by the touches that were down before.
    base: Vec<f32>,
    /// Parts beyond `count` are scratch memory.
    parts: Vec<PartReadings>,
    count: usize,
}

impl Landing {
    /// Whether a finger lands.
    pub(super) fn is_active(&self) -> bool {
        self.finger.is_some()
    }

    /// The finger has landed, or lifted again.
    pub(super) fn end(&mut self) {
        self.finger = None;
        self.count = 0;
    }

    /// A finger that was fitted to some readings lands, beside touches that change the channels by `base`.
    pub(super) fn begin<'a>(
        &mut self,
        finger: Fitted,
        model: &OnsetModel,
        readings: impl Iterator<Item = &'a PartReadings>,
        base: &[f32],
        memory: &mut FitMemory,
    ) {
        self.end();
        model.respond(&finger, memory, &mut self.response);
        self.finger = Some(finger);
        self.base.clear();
        self.base.extend_from_slice(base);
        for part in readings {
            self.next_part().copy_from(part);
        }
    }

    /// Adds a part. Whether every channel was read under the finger.
    pub(super) fn add(&mut self, detector: &Detector, part: &Part) -> bool {
        let base = std::mem::take(&mut self.base);
        self.next_part()
            .take(detector, part, |channel| base[channel]);
        self.base = base;
        let parts = self.parts[..self.count].iter();
        let read: usize = parts.map(|part| part.changes.len()).sum();
        read >= self.base.len()
    }

    /// Fits the finger again, to the readings since it landed.
    pub(super) fn fit(&mut self, model: &OnsetModel, memory: &mut FitMemory) {
        let parts = self.parts[..self.count].iter();
        let fitted = self
            .finger
            .and_then(|before| model.fit_again(&before, parts, memory));
        if let Some(fitted) = fitted {
            model.respond(&fitted, memory, &mut self.response);
            self.finger = Some(fitted);
        }
    }

    fn next_part(&mut self) -> &mut PartReadings {
        if self.parts.len() == self.count {
            self.parts.push(PartReadings::default());
        }
        self.count += 1;
        &mut self.parts[self.count - 1]
    }

    /// The relative change of a channel by all touches.
    pub(super) fn expected(&self, channel: usize) -> f32 {
        self.base[channel] + self.response[channel]
    }
}
