//! The table and the channel weights that touches are located with.

use std::sync::Arc;

use super::deformation::Deformations;
use super::fit::{Bounds, Problem};
use super::located_pad::LocatedPad;
use super::metric::{Metric, Whitened};
use super::templates::Templates;
use crate::eit::ResponseTable;
use crate::touch::ChannelNoise;
use crate::types::ByteReader;

/// What a pad's touches are located with: its response table and the weights of its channels.
#[derive(Clone, Debug)]
pub struct LocatorModel {
    pub(super) table: Arc<ResponseTable>,
    pub(super) bounds: Bounds,
    pub(super) metric: Metric,
    pub(super) templates: Templates,
    pub(super) deformations: Deformations,
    pub(super) pad: LocatedPad,
}

impl LocatorModel {
    /// A model for channels of the given noise; a deviation that is not finite excludes its channel. `drives` is the drive of
    /// each channel.
    ///
    /// # Panics
    /// If there is not one deviation per channel.
    #[must_use]
    pub(in crate::touch) fn new(
        table: Arc<ResponseTable>,
        pad: &LocatedPad,
        noise: &ChannelNoise,
        drives: &[u16],
    ) -> Self {
        let metric = Metric::new(&table, noise, drives, pad.learned.as_deref());
        Self::with_metric(table, pad, metric)
    }

    /// Appends the weights of the channels; the rest follows from table and outline.
    pub(crate) fn to_bytes(&self, bytes: &mut Vec<u8>) {
        self.metric.to_bytes(bytes);
    }

    /// Reads a model for a table of a pad; `None` if the bytes are anything else, or values are out of range.
    #[must_use]
    pub(in crate::touch) fn from_bytes(
        bytes: &mut ByteReader<'_>,
        table: Arc<ResponseTable>,
        pad: &LocatedPad,
    ) -> Option<Self> {
        let metric = Metric::from_bytes(bytes, &table)?;
        Some(Self::with_metric(table, pad, metric))
    }

    /// The response table.
    #[must_use]
    pub fn table(&self) -> &Arc<ResponseTable> {
        &self.table
    }

    /// Whether the responses were learned from presses.
    pub(in crate::touch) fn is_learned(&self) -> bool {
        self.pad.learned.is_some()
    }

    /// Energy of the model error of touches that change the readings by an energy.
    pub(super) fn error_energy(&self, energy: f64) -> f64 {
        self.pad.error_share * self.pad.error_share * energy
    }

    /// Whether channels are excluded: near their electrodes little is seen.
    pub(super) fn is_blind(&self) -> bool {
        self.metric.counted() < self.table.channels()
    }

    /// A frame to fit touches to.
    pub(super) fn problem<'a>(&'a self, frame: &'a Whitened, bounds: &'a Bounds) -> Problem<'a> {
        Problem {
            frame,
            table: &self.table,
            metric: &self.metric,
            bounds,
        }
    }

    fn with_metric(table: Arc<ResponseTable>, pad: &LocatedPad, metric: Metric) -> Self {
        let [least, most] = table.radii_mm();
        let bounds = Bounds {
            size_mm: pad.outline.size_mm(),
            reach_mm: table.reach_mm(),
            sign: pad.sign,
            log_radius: [libm::log(least), libm::log(most)],
            typical_log_radius: 0.5 * (libm::log(least) + libm::log(most)),
            prior_weight: 1.0,
        };
        Self {
            templates: Templates::new(&table, &metric, &bounds, &pad.outline),
            deformations: Deformations::new(&table, &metric, bounds.size_mm),
            table,
            bounds,
            metric,
            pad: pad.clone(),
        }
    }
}
