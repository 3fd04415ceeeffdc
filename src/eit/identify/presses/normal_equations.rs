//! What readings tell of a pad's unknowns, added up, and the pad that is most likely by it.
//!
//! With A the sum of J' R^-1 J over all readings and b that of J' R^-1 y, the estimate is (S^-1 + A)^-1 b, and the evidence is
//! (b' (S^-1 + A)^-1 b - log|S| - log|S^-1 + A|) / 2 but for a constant (Bishop 2006, 3.5). With presses there are fewer unknowns than
//! readings, so the sums run over unknowns, unlike those for the pad at rest alone (`fit`).

use faer::linalg::solvers::{DenseSolveCore, Llt, Solve};
use faer::{Mat, Side};

use crate::eit::identify::fit::{Estimate, usual};
use crate::eit::identify::prior::Prior;

/// Factors of a component's deviations that are tried, relative to the present one.
const TIMES: [f64; 4] = [0.4, 0.7, 1.4, 2.5];

/// Readings about a present estimate.
pub(super) struct Linearised<'a> {
    /// Readings x unknowns of the pad.
    pub(super) slopes: &'a Mat<f64>,
    /// What the model with the present estimate leaves of each reading.
    pub(super) residuals: &'a [f64],
    /// Variance of each reading.
    pub(super) variances: &'a [f64],
    /// Readings x other unknowns, which are integrated out, ...
    pub(super) other_slopes: &'a Mat<f64>,
    /// ... and their standard deviations.
    pub(super) other_deviations: &'a [f64],
}

/// What readings tell of the unknowns: A and b of the module's description.
pub(super) struct NormalEquations {
    matrix: Mat<f64>,
    right_side: Mat<f64>,
}

impl NormalEquations {
    /// Of no readings.
    pub(super) fn empty(unknowns: usize) -> Self {
        Self {
            matrix: Mat::zeros(unknowns, unknowns),
            right_side: Mat::zeros(unknowns, 1),
        }
    }

    /// Adds what other readings tell.
    pub(super) fn merge(&mut self, other: &Self) {
        self.matrix += &other.matrix;
        self.right_side += &other.right_side;
    }

    /// Adds readings that are linearised about these values of the unknowns. Other unknowns widen their covariance (Woodbury's identity).
    pub(super) fn add(&mut self, readings: &Linearised<'_>, values: &[f64]) {
        let count = readings.residuals.len();
        let weights: Vec<f64> = readings
            .variances
            .iter()
            .map(|variance| 1.0 / libm::sqrt(*variance))
            .collect();
        let slopes = Mat::from_fn(count, readings.slopes.ncols(), |reading, unknown| {
            readings.slopes[(reading, unknown)] * weights[reading]
        });
        let others = Mat::from_fn(count, readings.other_slopes.ncols(), |reading, unknown| {
            let slope = readings.other_slopes[(reading, unknown)];
            slope * weights[reading] * readings.other_deviations[unknown]
        });
        // The readings are linear about the present values: this is what the unknowns must explain from zero.
        let mut target = &slopes * Mat::from_fn(values.len(), 1, |unknown, _| values[unknown]);
        for (reading, residual) in readings.residuals.iter().enumerate() {
            target[(reading, 0)] += residual * weights[reading];
        }
        let mut inner = others.transpose() * &others;
        for other in 0..inner.nrows() {
            inner[(other, other)] += 1.0;
        }
        // Not finite: such readings tell nothing.
        let Ok(factor) = inner.llt(Side::Lower) else {
            return;
        };
        let cross = others.transpose() * &slopes;
        let along = others.transpose() * &target;
        self.matrix += slopes.transpose() * &slopes - cross.transpose() * factor.solve(&cross);
        self.right_side += slopes.transpose() * &target - cross.transpose() * factor.solve(&along);
    }

    /// The most likely estimate, with the most likely spreads of the prior's components near the present ones.
    pub(super) fn most_likely(&self, prior: &Prior, present: &Estimate) -> Estimate {
        let mut spreads = present.spreads.clone();
        let Some(mut best) = self.weigh(prior, &spreads) else {
            return present.clone();
        };
        for component in 0..spreads.len() {
            let from = spreads[component];
            for times in TIMES {
                let mut tried = spreads.clone();
                tried[component] = from * times;
                if let Some(other) = self.weigh(prior, &tried).filter(|other| other.0 > best.0) {
                    (best, spreads) = (other, tried);
                }
            }
        }
        Estimate {
            values: best.1.col(0).iter().copied().collect(),
            spreads,
        }
    }

    /// The evidence of the readings with these spreads, and the estimate. Nothing if the matrices are not positive definite.
    fn weigh(&self, prior: &Prior, spreads: &[f64]) -> Option<(f64, Mat<f64>)> {
        let prior_factor = prior.covariance(spreads).llt(Side::Lower).ok()?;
        let precision = prior_factor.inverse() + &self.matrix;
        let factor = precision.llt(Side::Lower).ok()?;
        let values = factor.solve(&self.right_side);
        let explained = (self.right_side.transpose() * &values)[(0, 0)];
        let evidence =
            0.5 * (explained - log_determinant(&prior_factor) - log_determinant(&factor));
        Some((evidence + usual(spreads), values))
    }
}

/// Of the matrix that was factored.
fn log_determinant(factor: &Llt<f64>) -> f64 {
    let lower = factor.L();
    let diagonal = (0..lower.nrows()).map(|i| 2.0 * libm::log(lower[(i, i)]));
    diagonal.sum()
}
