//! Gaussian process regression with a Matern 5/2 kernel; hyperparameters are chosen by leave-one-out.
//!
//! Leave-one-out residuals come in closed form from the inverse of the kernel matrix: r_i = (K^-1 y)_i / (K^-1)_ii
//! (Rasmussen and Williams 2006, eq. 5.12). Outputs (columns of `targets`) share the kernel; their mean is subtracted first.
//! The prior variance is 1: only the ratio of the noise to it matters.

use faer::linalg::solvers::{DenseSolveCore, Llt, Solve};
use faer::{Mat, Side};

use super::error::CalibrateError;
use crate::touch::correction::matern;

/// Start of the search: length (in median distances) and noise (variance ratio).
const START: Hyperparameters = Hyperparameters {
    length: 1.5,
    noise: 1e-2,
};
/// Factors of the search on length and noise; their logarithms are halved in each round.
const STEPS: (f64, f64) = (2.0, 3.2);
/// Rounds of the search, and steps in each.
const ROUNDS: (usize, usize) = (4, 8);
/// Limits of the search, in median distances and prior variances.
const LENGTHS: (f64, f64) = (0.05, 100.0);
const NOISES: (f64, f64) = (1e-8, 10.0);

/// Hyperparameters of the kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hyperparameters {
    /// Length scale, in the unit of the points.
    pub length: f64,
    /// Variance of the noise over that of the prior.
    pub noise: f64,
}

/// A fitted process.
#[derive(Clone, Debug)]
pub(super) struct Process {
    /// Points by dimensions.
    points: Mat<f64>,
    /// Points by outputs.
    weights: Mat<f64>,
    mean: Vec<f64>,
    hyper: Hyperparameters,
}

/// Result of leaving each point out.
pub(super) struct LeaveOneOut {
    /// Points by outputs: target minus prediction.
    pub residuals: Mat<f64>,
    /// 1 / (K^-1)_ii: variance of the prediction including noise, over the prior's.
    pub variance: Vec<f64>,
}

impl LeaveOneOut {
    /// The mean squared residual of an output over the variance that the process predicts: the variance of its prior.
    pub(super) fn scale(&self, output: usize) -> f64 {
        let residuals = self.residuals.col(output).iter();
        let sum: f64 = residuals.zip(&self.variance).map(|(r, v)| r * r / v).sum();
        sum / self.variance.len() as f64
    }
}

impl Process {
    /// Fits the weights.
    pub(super) fn fit(
        points: Mat<f64>,
        targets: &Mat<f64>,
        hyper: Hyperparameters,
    ) -> Result<Self, CalibrateError> {
        let (centred, mean) = centred(targets);
        let factor = factor(&squared_distances(&points, &points), hyper)?;
        Ok(Self {
            weights: factor.solve(&centred),
            points,
            mean,
            hyper,
        })
    }

    /// Predicts the outputs at other points.
    pub(super) fn predict(&self, points: &Mat<f64>) -> Mat<f64> {
        let mut kernel = squared_distances(points, &self.points);
        apply(&mut kernel, |d2| matern(d2, self.hyper.length));
        let mut outputs = kernel * &self.weights;
        for (output, mean) in self.mean.iter().enumerate() {
            for row in 0..outputs.nrows() {
                outputs[(row, output)] += mean;
            }
        }
        outputs
    }

    /// Variance of the prediction without noise over the prior's, at other points.
    pub(super) fn variance(&self, points: &Mat<f64>) -> Result<Vec<f64>, CalibrateError> {
        let factor = factor(&squared_distances(&self.points, &self.points), self.hyper)?;
        let mut kernel = squared_distances(&self.points, points);
        apply(&mut kernel, |d2| matern(d2, self.hyper.length));
        let solved = factor.solve(&kernel);
        Ok((0..points.nrows())
            .map(|column| {
                let explained: f64 = (0..kernel.nrows())
                    .map(|row| kernel[(row, column)] * solved[(row, column)])
                    .sum();
                (1.0 - explained).max(0.0)
            })
            .collect())
    }

    /// Mean outer product of the prediction's gradients at its own points, dimensions by dimensions: the directions in which
    /// the outputs change (Trivedi et al. 2014; Radhakrishnan et al. 2024).
    pub(super) fn gradient_outer_product(&self) -> Mat<f64> {
        let (count, dimensions) = (self.points.nrows(), self.points.ncols());
        let mut slope = squared_distances(&self.points, &self.points);
        apply(&mut slope, |d2| matern_slope(d2, self.hyper.length));
        let mut sum = Mat::<f64>::zeros(dimensions, dimensions);
        for output in 0..self.weights.ncols() {
            // Gradient at i: sum_j s_ij w_j (x_i - x_j).
            let weighted = Mat::from_fn(count, count, |i, j| {
                slope[(i, j)] * self.weights[(j, output)]
            });
            let totals: Vec<f64> = (0..count)
                .map(|i| (0..count).map(|j| weighted[(i, j)]).sum())
                .collect();
            let pulled = &weighted * &self.points;
            let gradients = Mat::from_fn(count, dimensions, |i, d| {
                totals[i] * self.points[(i, d)] - pulled[(i, d)]
            });
            sum += gradients.transpose() * &gradients;
        }
        apply(&mut sum, |value| value / count as f64);
        sum
    }
}

/// Leaves each point out in turn.
pub(super) fn leave_one_out(
    distances2: &Mat<f64>,
    targets: &Mat<f64>,
    hyper: Hyperparameters,
) -> Result<LeaveOneOut, CalibrateError> {
    let (centred, _) = centred(targets);
    let inverse = factor(distances2, hyper)?.inverse();
    let mut residuals = &inverse * &centred;
    let variance: Vec<f64> = (0..inverse.nrows())
        .map(|i| 1.0 / inverse[(i, i)])
        .collect();
    for output in 0..residuals.ncols() {
        for (row, variance) in variance.iter().enumerate() {
            residuals[(row, output)] *= variance;
        }
    }
    Ok(LeaveOneOut {
        residuals,
        variance,
    })
}

/// The length and noise with the least mean error of place when each press is left out.
pub(super) fn choose(
    points: &Mat<f64>,
    places: &Mat<f64>,
) -> Result<Hyperparameters, CalibrateError> {
    let distances2 = squared_distances(points, points);
    let unit = median_distance(&distances2).max(f64::MIN_POSITIVE);
    let error = |hyper: Hyperparameters| -> Result<f64, CalibrateError> {
        let hyper = Hyperparameters {
            length: hyper.length * unit,
            ..hyper
        };
        let left_out = leave_one_out(&distances2, places, hyper)?;
        Ok(mean_norm(&left_out.residuals))
    };
    let mut best = (error(START)?, START);
    let (mut length_step, mut noise_step) = STEPS;
    for _ in 0..ROUNDS.0 {
        for _ in 0..ROUNDS.1 {
            let before = best.0;
            for (by_length, by_noise) in [
                (length_step, 1.0),
                (1.0 / length_step, 1.0),
                (1.0, noise_step),
                (1.0, 1.0 / noise_step),
            ] {
                let hyper = Hyperparameters {
                    length: (best.1.length * by_length).clamp(LENGTHS.0, LENGTHS.1),
                    noise: (best.1.noise * by_noise).clamp(NOISES.0, NOISES.1),
                };
                // A step to a matrix that cannot be factored is not taken.
                if let Ok(found) = error(hyper)
                    && found < best.0
                {
                    best = (found, hyper);
                }
            }
            if best.0 > before * (1.0 - 1e-4) {
                break;
            }
        }
        length_step = libm::sqrt(length_step);
        noise_step = libm::sqrt(noise_step);
    }
    Ok(Hyperparameters {
        length: best.1.length * unit,
        ..best.1
    })
}

/// Mean length of the rows.
pub(super) fn mean_norm(rows: &Mat<f64>) -> f64 {
    (0..rows.nrows()).map(|row| norm(rows, row)).sum::<f64>() / rows.nrows() as f64
}

/// Length of a row.
pub(super) fn norm(rows: &Mat<f64>, row: usize) -> f64 {
    libm::sqrt(
        (0..rows.ncols())
            .map(|c| rows[(row, c)] * rows[(row, c)])
            .sum(),
    )
}

/// Squared distances of the rows of one matrix to those of another.
pub(super) fn squared_distances(a: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
    let lengths2 = |rows: &Mat<f64>| -> Vec<f64> {
        let mut sums = vec![0.0; rows.nrows()];
        for column in 0..rows.ncols() {
            for (sum, value) in sums.iter_mut().zip(rows.col(column).iter()) {
                *sum += value * value;
            }
        }
        sums
    };
    let (a2, b2) = (lengths2(a), lengths2(b));
    let mut product = a * b.transpose();
    for (column, b2) in b2.iter().enumerate() {
        for (value, a2) in product.col_mut(column).iter_mut().zip(&a2) {
            *value = (a2 + b2 - 2.0 * *value).max(0.0);
        }
    }
    product
}

fn factor(distances2: &Mat<f64>, hyper: Hyperparameters) -> Result<Llt<f64>, CalibrateError> {
    let mut kernel = distances2.clone();
    apply(&mut kernel, |d2| matern(d2, hyper.length));
    for i in 0..kernel.nrows() {
        kernel[(i, i)] = 1.0 + hyper.noise;
    }
    Llt::new(kernel.as_ref(), Side::Lower).map_err(|_| CalibrateError::Alike)
}

/// Derivative of the Matern 5/2 kernel by the distance, over the distance.
fn matern_slope(d2: f64, length: f64) -> f64 {
    let s = libm::sqrt(5.0 * d2) / length;
    -(5.0 / 3.0) * (1.0 + s) * libm::exp(-s) / (length * length)
}

/// Applies a function to every entry.
fn apply(matrix: &mut Mat<f64>, f: impl Fn(f64) -> f64) {
    for column in 0..matrix.ncols() {
        for value in matrix.col_mut(column).iter_mut() {
            *value = f(*value);
        }
    }
}

/// The targets without their mean, and the mean.
fn centred(targets: &Mat<f64>) -> (Mat<f64>, Vec<f64>) {
    let mean: Vec<f64> = (0..targets.ncols())
        .map(|c| targets.col(c).iter().sum::<f64>() / targets.nrows() as f64)
        .collect();
    let centred = Mat::from_fn(targets.nrows(), targets.ncols(), |r, c| {
        targets[(r, c)] - mean[c]
    });
    (centred, mean)
}

fn median_distance(distances2: &Mat<f64>) -> f64 {
    let mut values: Vec<f64> = (0..distances2.ncols())
        .flat_map(|c| (0..c).map(move |r| distances2[(r, c)]))
        .collect();
    values.sort_by(f64::total_cmp);
    values
        .get(values.len() / 2)
        .map_or(1.0, |d2| libm::sqrt(*d2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> (Mat<f64>, Mat<f64>) {
        let points = Mat::from_fn(40, 3, |i, d| libm::sin((i * (2 * d + 3)) as f64 * 0.37));
        let targets = Mat::from_fn(40, 2, |i, o| {
            points[(i, o)] + 0.3 * points[(i, 0)] * points[(i, 1)]
        });
        (points, targets)
    }

    #[test]
    fn the_closed_form_equals_leaving_out() {
        let (points, targets) = sample();
        let hyper = Hyperparameters {
            length: 1.1,
            noise: 0.01,
        };
        // Without a mean, which would change when a point is left out.
        let (targets, _) = centred(&targets);
        let distances2 = squared_distances(&points, &points);
        let quick = leave_one_out(&distances2, &targets, hyper).expect("sound");
        for out in [0, 17, 39] {
            let rest: Vec<usize> = (0..40).filter(|i| *i != out).collect();
            let some = Mat::from_fn(39, 3, |r, c| points[(rest[r], c)]);
            let factor = factor(&squared_distances(&some, &some), hyper).expect("sound");
            let weights = factor.solve(Mat::from_fn(39, 2, |r, c| targets[(rest[r], c)]));
            let at = Mat::from_fn(1, 3, |_, c| points[(out, c)]);
            let mut kernel = squared_distances(&at, &some);
            apply(&mut kernel, |d2| matern(d2, hyper.length));
            let predicted = kernel * weights;
            for output in 0..2 {
                let residual = targets[(out, output)] - predicted[(0, output)];
                assert!((residual - quick.residuals[(out, output)]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn gradients_match_the_prediction() {
        let (points, targets) = sample();
        let hyper = Hyperparameters {
            length: 1.3,
            noise: 0.05,
        };
        let process = Process::fit(points.clone(), &targets, hyper).expect("sound");
        let step = 1e-5;
        let mut sum = Mat::<f64>::zeros(3, 3);
        let shifted = |d: usize, by: f64| {
            process.predict(&Mat::from_fn(40, 3, |r, c| {
                points[(r, c)] + if c == d { by } else { 0.0 }
            }))
        };
        let slopes: Vec<Mat<f64>> = (0..3)
            .map(|d| (shifted(d, step) - shifted(d, -step)) * faer::Scale(0.5 / step))
            .collect();
        for (a, left) in slopes.iter().enumerate() {
            for (b, right) in slopes.iter().enumerate() {
                for i in 0..40 {
                    for output in 0..2 {
                        sum[(a, b)] += left[(i, output)] * right[(i, output)] / 40.0;
                    }
                }
            }
        }
        let found = process.gradient_outer_product();
        for a in 0..3 {
            for b in 0..3 {
                assert!((found[(a, b)] - sum[(a, b)]).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn the_choice_is_near_the_optimum() {
        let (points, targets) = sample();
        let chosen = choose(&points, &targets).expect("sound");
        let distances2 = squared_distances(&points, &points);
        let error = |hyper| {
            mean_norm(
                &leave_one_out(&distances2, &targets, hyper)
                    .expect("sound")
                    .residuals,
            )
        };
        for length in [0.3, 1.0, 3.0, 10.0] {
            for noise in [1e-6, 1e-4, 1e-2, 1.0] {
                assert!(error(chosen) <= 1.05 * error(Hyperparameters { length, noise }));
            }
        }
    }
}
