//! What a calibration reports: why presses are refused, why it failed, or how far places are off.

use crate::stats::quantile;
use crate::types::PointMm;

/// Why nothing can be learned from presses.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrateError {
    /// The kernel matrix cannot be factored.
    #[error(
        "the presses are too similar to learn from: press different places, and release the pad between presses"
    )]
    Alike,
    /// Presses left out are located no better than by guessing.
    #[error(
        "the presses disagree: from their readings they are located no better than by guessing. Check that each place belongs to its row, that all presses come from one pad, and that the untouched readings were taken just before each press"
    )]
    Disagree,
    /// Places are worse with the correction than without.
    #[error(
        "the correction would move places away: {with_mm:.2} mm with it, {without_mm:.2} mm without. Play without a calibration, or record the presses again"
    )]
    Worse {
        /// Mean error of lone touches that were left out, corrected, mm.
        with_mm: f64,
        /// Mean error of the model's places, mm.
        without_mm: f64,
    },
    /// Too few presses to leave some out.
    #[error(
        "{found} presses, but at least {FEWEST_TO_LEARN} are needed to learn a pad: press more places"
    )]
    TooFewToLearn {
        /// Number of presses.
        found: usize,
    },
    /// The presses lack the untouched readings.
    #[error(
        "these presses hold differences, but not what the untouched pad reads: play sees relative changes. Add a row without a place (`,,v0,v1,...`) with the untouched readings, in the same unit"
    )]
    NotRelative,
    /// The presses lack the places that the pad's model found.
    #[error(
        "these presses contain only voltages, not the places that the pad's model found: record them with `gelpad calibrate --source ...`, or learn a pad from them: `-o FILE.toml`, with `--size` if there is no drawing"
    )]
    NotModelled,
}

/// Least number of presses to learn a pad from: a fifth is left out.
pub(super) const FEWEST_TO_LEARN: usize = 10;

/// Least number of presses to learn from.
pub const FEWEST_PRESSES: usize = 8;

/// Why presses are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PressesError {
    /// The header is wrong.
    #[error("{name}:1: not a file of presses: the header must be x_mm,y_mm,d0,d1,...")]
    Header {
        /// The file.
        name: String,
    },
    /// A row is wrong.
    #[error("{name}:{line}: {problem}")]
    Row {
        /// The file.
        name: String,
        /// The line, from 1.
        line: u64,
        /// The reason.
        problem: String,
    },
    /// Too few to learn from.
    #[error("{name}: {found} presses, but at least {FEWEST_PRESSES} are needed: press more places")]
    TooFew {
        /// The file.
        name: String,
        /// Number of presses.
        found: usize,
    },
    /// The presses do not span the pad, or no channel changes.
    #[error("{name}: {problem}")]
    Flat {
        /// The file.
        name: String,
        /// What does not vary.
        problem: &'static str,
    },
}

/// Distances of predicted places from the true ones, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaceErrors {
    /// Mean distance.
    pub mean_mm: f64,
    /// Median distance.
    pub median_mm: f64,
    /// 95th percentile.
    pub p95_mm: f64,
}

impl PlaceErrors {
    /// Compares predicted places with the true ones.
    ///
    /// # Panics
    /// If there are none.
    #[must_use]
    pub fn between(predicted: &[PointMm], truth: &[PointMm]) -> Self {
        let distances: Vec<f64> = predicted
            .iter()
            .zip(truth)
            .map(|(a, b)| libm::hypot(a[0] - b[0], a[1] - b[1]))
            .collect();
        let quantile = |share| quantile(distances.iter().copied(), share).expect("a prediction");
        Self {
            mean_mm: distances.iter().sum::<f64>() / distances.len() as f64,
            median_mm: quantile(0.5),
            p95_mm: quantile(0.95),
        }
    }
}
