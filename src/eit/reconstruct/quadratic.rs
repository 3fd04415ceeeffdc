//! One-step reconstruction with a quadratic prior.
//!
//! Minimises |Jn x - dv|2 + lambda_abs x' P^-1 x. In the space of channels (M x M) that is
//! x = P Jn' (Jn P Jn' + lambda_abs I)^-1 dv (Adler and Guardo 1996, eq. 6; Adler, Dai and Lionheart 2007),
//! with lambda_abs = lambda trace(Jn P Jn') / M: lambda is then the share of noise in the mean power of a
//! channel, independent of pixel size and units.

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};

use super::linearised::{Linearised, SetupError};
use crate::types::{Method, PixelGrid};

/// Standard deviation of the smooth prior's Gaussian, mm: half the pitch of a lattice, about the size of a fingertip.
const SMOOTH_MM: f64 = 5.0;

/// Jn P (channels x pixels) for the prior P of a method; `None` for a method without a quadratic prior.
pub(super) fn prior_times_jacobian(pad: &Linearised, method: Method) -> Option<Mat<f64>> {
    let jacobian = &pad.jacobian;
    let scaled = |prior: &dyn Fn(usize) -> f64| {
        let priors: Vec<f64> = (0..jacobian.ncols()).map(prior).collect();
        Mat::from_fn(jacobian.nrows(), jacobian.ncols(), |m, p| {
            jacobian[(m, p)] * priors[p]
        })
    };
    match method {
        // P = I.
        Method::Tikhonov => Some(jacobian.clone()),
        // Cheney et al. 1990 with exponent 1/2: P = 1 / diag(Jn' Jn)^0.5.
        Method::Noser => Some(scaled(&|p| {
            1.0 / jacobian.col(p).norm_l2().max(f64::MIN_POSITIVE)
        })),
        // P_ij = exp(-d_ij2 / 2 s2): a Gaussian covariance, which is separable on the grid.
        Method::Smooth => Some(smoothed(jacobian, &pad.active, &pad.grid)),
        Method::L1 => None,
    }
}

/// Every row of the Jacobian, convolved with a Gaussian over the grid.
fn smoothed(jacobian: &Mat<f64>, active: &[usize], grid: &PixelGrid) -> Mat<f64> {
    let kernel = |length: usize| -> Vec<f64> {
        (0..length)
            .map(|cells| {
                let z = cells as f64 * grid.pixel_mm / SMOOTH_MM;
                libm::exp(-0.5 * z * z)
            })
            .collect()
    };
    let (along_x, along_y) = (kernel(grid.columns), kernel(grid.rows));
    let mut smooth = Mat::zeros(jacobian.nrows(), active.len());
    let mut plane = vec![0.0; grid.len()];
    let mut half = vec![0.0; grid.len()];
    for channel in 0..jacobian.nrows() {
        for (column, pixel) in active.iter().enumerate() {
            plane[*pixel] = jacobian[(channel, column)];
        }
        for (index, value) in half.iter_mut().enumerate() {
            let (row, column) = (index / grid.columns, index % grid.columns);
            let line = &plane[row * grid.columns..(row + 1) * grid.columns];
            *value = line
                .iter()
                .enumerate()
                .map(|(x, v)| v * along_x[x.abs_diff(column)])
                .sum();
        }
        for (column, pixel) in active.iter().enumerate() {
            let (row, x) = (pixel / grid.columns, pixel % grid.columns);
            smooth[(channel, column)] = (0..grid.rows)
                .map(|y| half[y * grid.columns + x] * along_y[y.abs_diff(row)])
                .sum();
        }
    }
    smooth
}

/// The transpose of the reconstruction matrix (channels x pixels), from Jn and Jn P.
pub(super) fn one_step(
    jacobian: &Mat<f64>,
    weighted: Mat<f64>,
    lambda: f64,
) -> Result<Mat<f64>, SetupError> {
    let channels = jacobian.nrows();
    let mut system = &weighted * jacobian.transpose();
    let trace: f64 = (0..channels).map(|m| system[(m, m)]).sum();
    let lambda_abs = lambda * trace / channels as f64;
    for m in 0..channels {
        system[(m, m)] += lambda_abs;
    }
    let factor = Llt::new(system.as_ref(), Side::Lower).map_err(|_| SetupError::Singular)?;
    let mut solution = weighted;
    factor.solve_in_place(solution.as_mut());
    Ok(solution)
}
