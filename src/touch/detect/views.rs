//! What others may know of a detector: its touches, the state of the channels.

use super::Detector;
use crate::eit::{ElectrodeMonitor, Reference};
use crate::touch::{Locator, Sensing};
use crate::types::{Contact, Nanos, Touch};

impl Detector {
    /// The contacts that are down, at the places that the model found: before any [`crate::touch::Correction`].
    #[must_use]
    pub fn uncorrected_contacts(&self) -> &[Contact] {
        if self.tracker.down().is_empty() {
            &[]
        } else {
            &self.uncorrected
        }
    }

    /// What touches are found with at present.
    #[must_use]
    pub fn sensing(&self) -> &Sensing {
        &self.sensing
    }

    /// Muted channels: dead, loose or of a lost electrode.
    #[must_use]
    pub fn muted_channels(&self) -> Vec<usize> {
        self.reference.muted_channels()
    }

    /// Lost electrodes, ascending, counted from 0.
    #[must_use]
    pub fn lost_electrodes(&self) -> Vec<usize> {
        let electrodes = self.electrodes.as_ref();
        electrodes.map(ElectrodeMonitor::lost).unwrap_or_default()
    }

    /// How often the reference was taken again, because it had been taken under a finger or a palm.
    #[must_use]
    pub fn references_retaken(&self) -> u64 {
        self.references_retaken
    }

    /// Whether the reference is taken: only then are changes meaningful.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.reference.is_ready()
    }

    /// Number of readings of a frame.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.changes.len()
    }

    /// The reference.
    pub(in crate::touch) fn reference(&self) -> &Reference {
        &self.reference
    }

    /// What locates touches in the voltages, if the pad has a table.
    pub(in crate::touch) fn locator(&self) -> Option<&Locator> {
        self.locator.as_ref().filter(|_| self.knows_both_signs())
    }

    /// The relative change of each channel that the touches explain.
    pub(in crate::touch) fn explained(&self) -> &[f32] {
        &self.explained
    }

    /// Time of the last frame that its touches explained.
    pub(in crate::touch) fn explained_ns(&self) -> Nanos {
        self.explained_ns
    }

    /// The response of each located touch, one value per channel.
    pub(in crate::touch) fn responses(&self, responses: &mut Vec<Vec<f32>>) {
        match &self.locator {
            Some(locator) if !self.tracker.down().is_empty() => locator.responses(responses),
            _ => responses.clear(),
        }
    }

    /// The relative changes of the last frame, and the part that its touches explain; one value per channel.
    #[must_use]
    pub fn changes_and_explained(&self) -> (&[f32], &[f32]) {
        (&self.changes, &self.explained)
    }

    /// Reading of the untouched pad and relative standard deviation, one value per channel; infinite for a muted channel.
    #[must_use]
    pub fn rest_volts_and_deviations(&self) -> [Vec<f32>; 2] {
        let single = |values: &[f64]| values.iter().map(|value| *value as f32).collect();
        [
            single(self.reference.volts()),
            single(&self.reference.deviations()),
        ]
    }

    /// The touches that are down.
    #[must_use]
    pub fn touches_down(&self) -> &[Touch] {
        self.tracker.down()
    }
}
