//! One-step reconstruction with a quadratic prior.
//!
//! Minimises |Jn x - dv|2 + lambda_abs x' P^-1 x. In the space of channels (M x M) that is
//! x = P Jn' (Jn P Jn' + lambda_abs I)^-1 dv (Adler and Guardo 1996, eq. 6; Adler, Dai and Lionheart 2007),
//! with lambda_abs = lambda trace(Jn P Jn') / M: lambda is then the share of noise in the mean power of a
//! channel, whatever the pixel or the unit.

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};

use super::SetupError;

/// Tikhonov: every pixel alike.
pub(super) fn even_prior(jacobian: &Mat<f64>) -> Vec<f64> {
    vec![1.0; jacobian.ncols()]
}

/// NOSER (Cheney et al. 1990) with exponent 1/2: P = 1 / diag(Jn' Jn)^0.5.
pub(super) fn noser_prior(jacobian: &Mat<f64>) -> Vec<f64> {
    (0..jacobian.ncols())
        .map(|pixel| 1.0 / jacobian.col(pixel).norm_l2().max(f64::MIN_POSITIVE))
        .collect()
}

/// The transpose of the reconstruction matrix (channels by pixels) for a diagonal prior.
pub(super) fn one_step(
    jacobian: &Mat<f64>,
    prior: &[f64],
    lambda: f64,
) -> Result<Mat<f64>, SetupError> {
    let channels = jacobian.nrows();
    let weighted = Mat::from_fn(channels, jacobian.ncols(), |m, p| {
        jacobian[(m, p)] * prior[p]
    });
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
