//! Calibration from presses: a regression from voltages to places, and the correction of live contacts made from it.
//!
//! A user presses known places once each. [`Regression`] learns places from voltages alone, whatever the protocol, the outline
//! and the unit; [`correction`](fn@correction) learns what a pad's model gets wrong, as the plain data that the engine applies.
//! Everything is chosen by leaving presses out; nothing is random.

mod blend;
mod correct;
mod curve;
mod features;
mod maps;
pub mod orientation;
mod presses;
mod process;
pub mod recommend;
mod regression;

pub use correct::{Fitted, correction};
pub use curve::{Curve, learning_curve};
pub use presses::{FEWEST_PRESSES, Modelled, Press, Presses, PressesError};
pub use regression::Regression;

use crate::types::PointMm;

/// Why nothing can be learned.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CalibrateError {
    /// The kernel matrix cannot be factored.
    #[error(
        "the presses read too much alike to learn from: press places that differ, and leave the pad alone between presses"
    )]
    Alike,
    /// The correction needs what the model made of the presses.
    #[error(
        "these presses tell only voltages, not what the pad's model made of them: record them with `gelpad calibrate --source ...`"
    )]
    NotModelled,
}

/// How far places are off, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Mean distance from the truth.
    pub mean_mm: f64,
    /// Half of them are nearer.
    pub median_mm: f64,
    /// Nineteen of twenty are nearer.
    pub p95_mm: f64,
}

impl Errors {
    /// Distances of guesses from the truth.
    ///
    /// # Panics
    /// If there is no guess.
    #[must_use]
    pub fn of(guesses: &[PointMm], truth: &[PointMm]) -> Self {
        let mut distances: Vec<f64> = guesses
            .iter()
            .zip(truth)
            .map(|(a, b)| libm::hypot(a[0] - b[0], a[1] - b[1]))
            .collect();
        distances.sort_by(f64::total_cmp);
        let quantile = |share: f64| {
            let last = distances.len() - 1;
            distances[libm::round(share * last as f64) as usize]
        };
        Self {
            mean_mm: distances.iter().sum::<f64>() / distances.len() as f64,
            median_mm: quantile(0.5),
            p95_mm: quantile(0.95),
        }
    }
}
