//! The most likely unknowns of a linear model with Gaussian priors, and how wide each part of the prior should be.
//!
//! With y the readings, J their derivatives, S the prior's covariance and R the readings': the estimate is S J' (J S J' + R)^-1 y, and the
//! evidence of y is the density of a Gaussian with covariance J S J' + R (Bishop 2006, 3.5). S is a sum over the ways in which pads differ,
//! each with a factor; the factors that make the readings most likely are searched one after another. The sums run over readings,
//! which are fewer than unknowns.

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};

use super::Compared;
use super::prior::{Component, Prior};

/// Factors of a component's deviations that are tried, ...
const SPREADS: [f64; 8] = [0.03, 0.1, 0.25, 0.5, 1.0, 1.6, 2.5, 4.0];
/// ... so many times for each component in the first search, and once in the others, ...
const FIRST_SWEEPS: usize = 2;
/// ... with this standard deviation of their logarithms beforehand: a pad is seldom ten times worse than usual.
const LOG_SPREAD_SD: f64 = 1.5;
/// Standard deviation of the logarithm of the board's gain, beside the gain that fits best.
pub(super) const GAIN_SD: f64 = 0.1;

/// Values of the unknowns.
#[derive(Clone, Debug)]
pub(super) struct Estimate {
    /// Cells, shifts, stretches.
    pub(super) values: Vec<f64>,
    /// Factors of the components' deviations; none before the first search.
    pub(super) spreads: Vec<f64>,
}

impl Estimate {
    /// The drawing.
    pub(super) fn none(prior: &Prior) -> Self {
        Self {
            values: vec![0.0; prior.len()],
            spreads: Vec::new(),
        }
    }

    /// The mean of two estimates.
    pub(super) fn halfway_to(&self, other: &Self) -> Self {
        let pairs = self.values.iter().zip(&other.values);
        Self {
            values: pairs.map(|(a, b)| 0.5 * (a + b)).collect(),
            spreads: self.spreads.clone(),
        }
    }
}

/// Readings and their derivatives at the present estimate.
pub(super) struct LinearModel {
    /// Usable readings x unknowns, in the readings' units.
    pub(super) slopes: Mat<f64>,
    /// What a change of the gain does to each reading.
    pub(super) gain: Vec<f64>,
    /// Differences that are to be explained.
    pub(super) residuals: Vec<f64>,
    /// Variance of each reading.
    pub(super) variances: Vec<f64>,
}

impl LinearModel {
    /// `volts` are those of the model, V/A. The slopes by cells are in V/A per relative change, those by electrodes relative per mm;
    /// `deviations` and `model_error` are relative.
    pub(super) fn new(
        compared: &Compared,
        volts: &[f64],
        [cells, electrodes]: [&Mat<f64>; 2],
        deviations: &[f64],
        model_error: f64,
    ) -> Self {
        let unknowns = cells.ncols() + electrodes.ncols();
        let of_reading = |reading: usize| (compared.usable[reading], compared.units[reading]);
        let size = |reading: usize| {
            let (channel, unit) = of_reading(reading);
            volts[channel] / unit
        };
        let count = compared.usable.len();
        Self {
            slopes: Mat::from_fn(count, unknowns, |reading, unknown| {
                let (channel, unit) = of_reading(reading);
                match unknown.checked_sub(cells.ncols()) {
                    None => cells[(channel, unknown)] / unit,
                    Some(electrode) => electrodes[(channel, electrode)] * size(reading),
                }
            }),
            gain: (0..count).map(size).collect(),
            residuals: compared.residuals.clone(),
            variances: (0..count)
                .map(|reading| {
                    let noise = deviations[compared.usable[reading]] * size(reading);
                    model_error * model_error + noise * noise
                })
                .collect(),
        }
    }
}

/// The most likely estimate with the most likely spreads of the prior's components.
pub(super) fn most_likely(model: &LinearModel, prior: &Prior, present: &Estimate) -> Estimate {
    let count = model.residuals.len();
    // The model is linear about the present estimate: this is what it must explain from nothing.
    let target: Vec<f64> = (0..count)
        .map(|reading| {
            let slopes = model.slopes.row(reading);
            let present = slopes.iter().zip(&present.values);
            model.residuals[reading] + present.map(|(slope, value)| slope * value).sum::<f64>()
        })
        .collect();
    let target = Mat::from_fn(count, 1, |reading, _| target[reading]);
    let gains: Vec<Mat<f64>> = prior
        .components
        .iter()
        .map(|component| covariance_with_readings(component, prior, model))
        .collect();
    let explained: Vec<Mat<f64>> = gains.iter().map(|gain| &model.slopes * gain).collect();
    let weigh = |spreads: &[f64]| -> Option<(f64, Mat<f64>)> {
        let covariance = Mat::from_fn(count, count, |i, j| {
            let gain = GAIN_SD * GAIN_SD * model.gain[i] * model.gain[j];
            let own = if i == j { model.variances[i] } else { 0.0 };
            let parts = explained.iter().zip(spreads);
            gain + own
                + parts
                    .map(|(part, spread)| spread * spread * part[(i, j)])
                    .sum::<f64>()
        });
        let factor = covariance.llt(Side::Lower).ok()?;
        let weighted = factor.solve(&target);
        let likely = evidence(&factor, &weighted, &target) + usual(spreads);
        Some((likely, weighted))
    };
    let is_first = present.spreads.is_empty();
    let mut spreads = if is_first {
        vec![1.0; gains.len()]
    } else {
        present.spreads.clone()
    };
    let sweeps = if is_first { FIRST_SWEEPS } else { 1 };
    let Some(mut best) = weigh(&spreads) else {
        return present.clone();
    };
    for component in (0..sweeps).flat_map(|_| 0..gains.len()) {
        for spread in SPREADS {
            let mut tried = spreads.clone();
            tried[component] = spread;
            if let Some(other) = weigh(&tried).filter(|other| other.0 > best.0) {
                (best, spreads) = (other, tried);
            }
        }
    }
    let mut values = vec![0.0; prior.len()];
    for (gain, spread) in gains.iter().zip(&spreads) {
        let part = gain * &best.1;
        for (value, part) in values.iter_mut().zip(part.col(0).iter()) {
            *value += spread * spread * part;
        }
    }
    Estimate { values, spreads }
}

/// Logarithm of how usual spreads are, without its constant.
pub(super) fn usual(spreads: &[f64]) -> f64 {
    spreads
        .iter()
        .map(|spread| libm::log(*spread) / LOG_SPREAD_SD)
        .map(|log| -0.5 * log * log)
        .sum()
}

/// A component's covariance times the transposed slopes: unknowns x readings.
fn covariance_with_readings(component: &Component, prior: &Prior, model: &LinearModel) -> Mat<f64> {
    let count = model.residuals.len();
    let (cells, electrodes) = (prior.cells, prior.electrodes);
    match component {
        Component::Cells(covariance) => {
            let of_cells = covariance * model.slopes.get(.., ..cells).transpose();
            Mat::from_fn(prior.len(), count, |unknown, reading| {
                if unknown < cells {
                    of_cells[(unknown, reading)]
                } else {
                    0.0
                }
            })
        }
        Component::Shifts(variances) => independent(variances, cells, prior.len(), model),
        Component::Stretches(variances) => {
            independent(variances, cells + electrodes, prior.len(), model)
        }
    }
}

/// The same for independent unknowns from `first` on.
fn independent(variances: &[f64], first: usize, unknowns: usize, model: &LinearModel) -> Mat<f64> {
    Mat::from_fn(unknowns, model.residuals.len(), |unknown, reading| {
        let variance = unknown
            .checked_sub(first)
            .and_then(|index| variances.get(index));
        variance.map_or(0.0, |variance| variance * model.slopes[(reading, unknown)])
    })
}

/// Logarithm of the readings' density, without its constant.
fn evidence(factor: &Llt<f64>, weighted: &Mat<f64>, target: &Mat<f64>) -> f64 {
    let lower = factor.L();
    let log_determinant: f64 = (0..lower.nrows())
        .map(|i| 2.0 * libm::log(lower[(i, i)]))
        .sum();
    let explained = target.transpose() * weighted;
    -0.5 * (explained[(0, 0)] + log_determinant)
}
