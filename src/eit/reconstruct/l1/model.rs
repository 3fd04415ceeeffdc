//! The L1 model of a pad, and FISTA as in the paper.

use faer::Mat;

use crate::eit::cholesky::{add_scaled, dot};
use crate::types::ByteReader;

/// Most iterations, as in the paper; for [`super::L1State`], sweeps over the working set.
pub const ITERATIONS: usize = 200;
/// Noise alone reaches this many of its standard deviations in max |A' dv| of about a thousand pixels: sqrt(2 ln 1000).
pub(super) const NOISE_REACH: f64 = 3.7;

/// What the solver needs of a pad; computed once and shared.
#[derive(Clone, Debug, PartialEq)]
pub struct L1Model {
    pub(super) channels: usize,
    /// Columns of A, one after the other.
    columns: Vec<f64>,
    /// A' A in row-major order.
    gram: Vec<f64>,
    /// Norms of the Jacobian's columns.
    norms: Vec<f64>,
    pub(super) lambda: f64,
    pub(super) nonnegative: bool,
}

impl L1Model {
    /// The model of a Jacobian (channels x pixels).
    #[must_use]
    pub fn new(jacobian: &Mat<f64>, lambda: f64, nonnegative: bool) -> Self {
        let (channels, pixels) = (jacobian.nrows(), jacobian.ncols());
        let norms: Vec<f64> = (0..pixels)
            .map(|p| jacobian.col(p).norm_l2().max(f64::MIN_POSITIVE))
            .collect();
        let unit = Mat::from_fn(channels, pixels, |m, p| jacobian[(m, p)] / norms[p]);
        let product = unit.transpose() * &unit;
        Self {
            channels,
            columns: (0..pixels)
                .flat_map(|p| unit.col(p).iter().copied().collect::<Vec<_>>())
                .collect(),
            gram: (0..pixels * pixels)
                .map(|i| product[(i / pixels, i % pixels)])
                .collect(),
            norms,
            lambda,
            nonnegative,
        }
    }

    /// Appends the number of channels (u32), `nonnegative` (one byte), lambda, columns, Gram matrix and norms (f64).
    pub(in crate::eit::reconstruct) fn to_bytes(&self, bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(&(self.channels as u32).to_le_bytes());
        bytes.push(u8::from(self.nonnegative));
        let lambda = std::iter::once(&self.lambda);
        for value in lambda
            .chain(&self.columns)
            .chain(&self.gram)
            .chain(&self.norms)
        {
            bytes.extend_from_slice(&value.to_le_bytes());
        }
    }

    /// Reads a model of `pixels` pixels; `None` if there are too few bytes, or a value is out of range.
    pub(in crate::eit::reconstruct) fn from_bytes(
        bytes: &mut ByteReader<'_>,
        pixels: usize,
    ) -> Option<Self> {
        let channels = bytes.count()?;
        let nonnegative = bytes.u8()? == 1;
        let lambda = bytes.f64()?;
        let columns = bytes.f64s(channels.checked_mul(pixels)?)?;
        let gram = bytes.f64s(pixels.checked_mul(pixels)?)?;
        let norms = bytes.f64s(pixels)?;
        let all_finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        let is_valid = channels > 0
            && (lambda.is_finite() && lambda >= 0.0)
            && (all_finite(&columns) && all_finite(&gram) && all_finite(&norms))
            && norms.iter().all(|norm| *norm > 0.0);
        is_valid.then_some(Self {
            channels,
            columns,
            gram,
            norms,
            lambda,
            nonnegative,
        })
    }

    /// Number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Number of pixels.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.norms.len()
    }

    /// The column of A of a pixel.
    #[must_use]
    pub fn column(&self, pixel: usize) -> &[f64] {
        &self.columns[pixel * self.channels..(pixel + 1) * self.channels]
    }

    /// Norm of the Jacobian's column of a pixel: x / norm is the change of conductivity.
    #[must_use]
    pub fn norm(&self, pixel: usize) -> f64 {
        self.norms[pixel]
    }

    /// The paper's method: accelerated iterations from zero (FISTA: Beck and Teboulle 2009), in units of A's columns.
    /// Where the iterations end before the optimum, as for wide shapes, the answer is less spiky than [`Self::solve`]'s.
    ///
    /// # Panics
    /// If there is not one change per channel.
    #[must_use]
    pub fn solve_fista(&self, changes: &[f64], lambda_abs: f64, iterations: usize) -> Vec<f64> {
        assert_eq!(changes.len(), self.channels);
        let pixels = self.pixels();
        let step = 1.0 / self.largest_eigenvalue();
        let (mut x, mut y, mut momentum) = (vec![0.0; pixels], vec![0.0; pixels], 1.0_f64);
        let mut residual = vec![0.0; self.channels];
        for _ in 0..iterations {
            residual.copy_from_slice(changes);
            for (pixel, value) in y.iter().enumerate().filter(|(_, value)| **value != 0.0) {
                add_scaled(&mut residual, self.column(pixel), -value);
            }
            let next_momentum = 0.5 * (1.0 + libm::sqrt(1.0 + 4.0 * momentum * momentum));
            let carry = (momentum - 1.0) / next_momentum;
            momentum = next_momentum;
            for pixel in 0..pixels {
                let target = y[pixel] + step * dot(self.column(pixel), &residual);
                let next = self.shrunk(target, step * lambda_abs);
                y[pixel] = next + carry * (next - x[pixel]);
                x[pixel] = next;
            }
        }
        x
    }

    /// Weight of the penalty for a frame: a share of max |A' dv|, and never below what noise alone would reach.
    #[must_use]
    pub fn lambda_abs(&self, changes: &[f64], noise: f64) -> f64 {
        let reach = (0..self.pixels())
            .map(|pixel| dot(self.column(pixel), changes).abs())
            .fold(0.0, f64::max);
        (self.lambda * reach).max(NOISE_REACH * noise)
    }

    /// A value slightly above the largest eigenvalue of A' A, by power iteration.
    fn largest_eigenvalue(&self) -> f64 {
        let mut x = vec![1.0; self.pixels()];
        let mut size = 0.0;
        for _ in 0..60 {
            let next: Vec<f64> = (0..self.pixels())
                .map(|pixel| dot(self.gram_row(pixel), &x))
                .collect();
            size = libm::sqrt(dot(&next, &next));
            for (x, next) in x.iter_mut().zip(&next) {
                *x = next / size;
            }
        }
        1.001 * size
    }

    /// The proximal step of the penalty.
    pub(super) fn shrunk(&self, target: f64, weight: f64) -> f64 {
        if self.nonnegative {
            (target - weight).max(0.0)
        } else {
            libm::copysign((target.abs() - weight).max(0.0), target)
        }
    }

    pub(super) fn gram_row(&self, pixel: usize) -> &[f64] {
        &self.gram[pixel * self.pixels()..(pixel + 1) * self.pixels()]
    }
}
