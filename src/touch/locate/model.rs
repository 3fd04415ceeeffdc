//! The table and the channel weights that touches are located with.

use std::sync::Arc;

use super::deformation::Deformations;
use super::fit::{Bounds, Problem};
use super::metric::{Metric, Whitened};
use super::templates::Templates;
use crate::eit::ResponseTable;
use crate::pad::{LearnedMaps, Outline, TouchSign};
use crate::touch::ChannelNoise;
use crate::types::ByteReader;

/// Model error as a share of the frame's amplitude, because pads differ from their models. A new touch explains at least
/// the energy of this error.
const MODEL_ERROR: f64 = 0.04;

/// Most touches: the fingers of two hands.
const MOST_TOUCHES: usize = 10;
/// On learned maps more touches cannot be told apart, and an odd frame would be explained by a crowd of them.
const MOST_LEARNED_TOUCHES: usize = 4;

/// What a pad's touches are located with: its response table and the weights of its channels.
#[derive(Clone, Debug)]
pub struct LocatorModel {
    pub(super) table: Arc<ResponseTable>,
    pub(super) bounds: Bounds,
    pub(super) metric: Metric,
    pub(super) templates: Templates,
    pub(super) deformations: Deformations,
    /// Model error as a share of the frame's amplitude.
    error_share: f64,
}

impl LocatorModel {
    /// A model for channels of the given noise; a deviation that is not finite excludes its channel. `drives` is the drive of
    /// each channel, `sign` that of the touches that are expected, `learned` the maps of a pad that was learned from presses.
    ///
    /// # Panics
    /// If there is not one deviation per channel.
    #[must_use]
    pub fn new(
        table: Arc<ResponseTable>,
        outline: &Outline,
        sign: TouchSign,
        noise: &ChannelNoise,
        drives: &[u16],
        learned: Option<&LearnedMaps>,
    ) -> Self {
        let metric = Metric::new(&table, noise, drives, learned);
        Self::with_metric(table, outline, sign, metric, learned)
    }

    /// Appends the weights of the channels; the rest follows from table and outline.
    pub(crate) fn to_bytes(&self, bytes: &mut Vec<u8>) {
        self.metric.to_bytes(bytes);
    }

    /// Reads a model for a table and an outline; `None` if the bytes are anything else, or values are out of range.
    #[must_use]
    pub(crate) fn from_bytes(
        bytes: &mut ByteReader<'_>,
        table: Arc<ResponseTable>,
        outline: &Outline,
        sign: TouchSign,
        learned: Option<&LearnedMaps>,
    ) -> Option<Self> {
        let metric = Metric::from_bytes(bytes, &table)?;
        Some(Self::with_metric(table, outline, sign, metric, learned))
    }

    /// The response table.
    #[must_use]
    pub fn table(&self) -> &Arc<ResponseTable> {
        &self.table
    }

    /// Whether the responses were learned from presses.
    pub(in crate::touch) fn is_learned(&self) -> bool {
        self.error_share > MODEL_ERROR
    }

    /// How many touches may be down at once.
    pub(super) fn most_touches(&self) -> usize {
        match self.is_learned() {
            true => MOST_LEARNED_TOUCHES,
            false => MOST_TOUCHES,
        }
    }

    /// Energy of the model error of touches that change the readings by an energy.
    pub(super) fn error_energy(&self, energy: f64) -> f64 {
        self.error_share * self.error_share * energy
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

    fn with_metric(
        table: Arc<ResponseTable>,
        outline: &Outline,
        sign: TouchSign,
        metric: Metric,
        learned: Option<&LearnedMaps>,
    ) -> Self {
        let [least, most] = table.radii_mm();
        let bounds = Bounds {
            size_mm: outline.size_mm(),
            reach_mm: table.reach_mm(),
            sign,
            log_radius: [libm::log(least), libm::log(most)],
            typical_log_radius: 0.5 * (libm::log(least) + libm::log(most)),
            prior_weight: 1.0,
        };
        Self {
            templates: Templates::new(&table, &metric, &bounds, outline),
            deformations: Deformations::new(&table, &metric, bounds.size_mm),
            table,
            bounds,
            metric,
            error_share: learned.map_or(MODEL_ERROR, LearnedMaps::error_share),
        }
    }
}
