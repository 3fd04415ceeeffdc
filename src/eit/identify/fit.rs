//! The most likely unknowns of a linear model with Gaussian priors, and how wide the prior should be.
//!
//! With y the readings, J their derivatives, S the prior's covariance and R the readings': the estimate is S J' (J S J' + R)^-1 y, and the
//! evidence of y is the density of a Gaussian with covariance J S J' + R (Bishop 2006, 3.5). The sums run over readings, which are fewer than
//! unknowns.

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};

use super::prior::Prior;
use super::{Compared, MODEL_ERROR};

/// Factors of the prior's deviations that are tried.
const SPREADS: [f64; 7] = [0.1, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0];
/// Standard deviation of the logarithm of the board's gain, beside the gain that fits best.
const GAIN_SD: f64 = 0.1;

/// Values of the unknowns.
#[derive(Clone, Debug)]
pub(super) struct Estimate {
    /// Cells, shifts, stretches.
    pub(super) values: Vec<f64>,
    /// Factor of the prior's deviations.
    pub(super) spread: f64,
}

impl Estimate {
    /// The drawing.
    pub(super) fn none(unknowns: usize) -> Self {
        Self {
            values: vec![0.0; unknowns],
            spread: 1.0,
        }
    }
}

/// Readings and their derivatives at the present estimate.
pub(super) struct LinearModel {
    /// Usable readings x unknowns, in the readings' units.
    slopes: Mat<f64>,
    /// What a change of the gain does to each reading.
    gain: Vec<f64>,
    /// Differences that are to be explained.
    residuals: Vec<f64>,
    /// Variance of each reading.
    variances: Vec<f64>,
}

impl LinearModel {
    /// `cells` is in V/A per relative change, `electrodes` relative per mm; `deviations` are relative.
    pub(super) fn new(
        compared: &Compared,
        cells: &Mat<f64>,
        electrodes: &Mat<f64>,
        deviations: &[f64],
    ) -> Self {
        let unknowns = cells.ncols() + electrodes.ncols();
        let of_reading = |reading: usize| (compared.usable[reading], compared.units[reading]);
        let size = |reading: usize| {
            let (channel, unit) = of_reading(reading);
            compared.model[channel] / unit
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
                    MODEL_ERROR * MODEL_ERROR + noise * noise
                })
                .collect(),
        }
    }
}

/// The most likely estimate with the most likely spread of the prior.
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
    let spread_readings = prior_times_slopes(model, prior);
    let explained = &model.slopes * &spread_readings;
    let fits = SPREADS.into_iter().filter_map(|spread| {
        let covariance = Mat::from_fn(count, count, |i, j| {
            let gain = GAIN_SD * GAIN_SD * model.gain[i] * model.gain[j];
            let own = if i == j { model.variances[i] } else { 0.0 };
            spread * spread * explained[(i, j)] + gain + own
        });
        let factor = covariance.llt(Side::Lower).ok()?;
        let weighted = factor.solve(&target);
        Some((spread, evidence(&factor, &weighted, &target), weighted))
    });
    let best = fits.max_by(|a, b| a.1.total_cmp(&b.1));
    let Some((spread, _, weighted)) = best else {
        return present.clone();
    };
    let values = &spread_readings * &weighted;
    Estimate {
        values: values
            .col(0)
            .iter()
            .map(|value| spread * spread * value)
            .collect(),
        spread,
    }
}

/// The prior's covariance times the transposed slopes: unknowns x readings.
fn prior_times_slopes(model: &LinearModel, prior: &Prior) -> Mat<f64> {
    let cells = prior.cells.nrows();
    let count = model.residuals.len();
    let of_cells = &prior.cells * model.slopes.get(.., ..cells).transpose();
    Mat::from_fn(prior.len(), count, |unknown, reading| {
        match unknown.checked_sub(cells) {
            None => of_cells[(unknown, reading)],
            Some(electrode) => prior.electrodes[electrode] * model.slopes[(reading, unknown)],
        }
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
