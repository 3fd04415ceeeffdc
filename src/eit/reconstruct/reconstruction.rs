//! How the images of a pad are computed.

use super::kernel::RowMatrix;
use super::l1::L1Model;
use super::linearised::{LAMBDA, Linearised, SetupError};
use super::quadratic;
use crate::pad::{Pad, TouchSign};
use crate::types::{Method, PixelGrid};

/// The reconstruction of one pad: a matrix, or the model of L1.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// The method.
    pub method: Method,
    /// Where the pixels of its images lie.
    pub grid: PixelGrid,
    /// Share of each pixel of the grid that is conductor, 0 to 1.
    pub coverage: Vec<f32>,
    /// The pixel of each unknown.
    pub(super) active: Vec<usize>,
    pub(super) solver: Solver,
    pub(super) sign: f32,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Solver {
    OneStep(RowMatrix),
    L1(L1Model),
}

impl Reconstruction {
    /// The reconstruction of a pad with the hyperparameter [`LAMBDA`].
    ///
    /// # Errors
    /// See [`SetupError`].
    pub fn from_pad(pad: &Pad, method: Method) -> Result<Self, SetupError> {
        Self::from_linearised(&Linearised::from_pad(pad)?, method, LAMBDA, pad.touch_sign)
    }

    /// The reconstruction of a linearised pad.
    ///
    /// # Errors
    /// [`SetupError::Singular`] if lambda is not above zero.
    pub fn from_linearised(
        pad: &Linearised,
        method: Method,
        lambda: f64,
        touch_sign: TouchSign,
    ) -> Result<Self, SetupError> {
        let solver = match quadratic::prior_times_jacobian(pad, method) {
            Some(weighted) => {
                let matrix = quadratic::one_step(&pad.jacobian, weighted, lambda)?;
                Solver::OneStep(RowMatrix::transposed(&matrix))
            }
            None => Solver::L1(L1Model::new(&pad.jacobian, lambda, true)),
        };
        Ok(Self {
            method,
            grid: pad.grid,
            coverage: pad.coverage.iter().map(|share| *share as f32).collect(),
            active: pad.active.clone(),
            solver,
            sign: touch_sign.factor(),
        })
    }

    /// Number of voltages in a frame.
    #[must_use]
    pub fn channels(&self) -> usize {
        match &self.solver {
            Solver::OneStep(matrix) => matrix.columns(),
            Solver::L1(model) => model.channels(),
        }
    }

    /// Sign of the touches that are bright in images.
    #[must_use]
    pub fn touch_sign(&self) -> TouchSign {
        if self.sign < 0.0 {
            TouchSign::Fall
        } else {
            TouchSign::Rise
        }
    }

    /// Number of pixels that hold conductor.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.active.len()
    }
}
