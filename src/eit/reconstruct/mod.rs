//! Relative voltage changes to an image.
//!
//! Set-up (f64, once a pad) turns the model into one f32 matrix; a frame is one product with it, summed in an
//! order that `kernel` fixes, negative values cut. The scaling of the hyperparameter is the project's (see
//! `quadratic`): it does not move with the size of a pixel or the units of a voltage.

mod kernel;
mod quadratic;

use faer::Mat;

use super::forward::{ContactModel, ForwardError, ForwardModel};
use super::jacobian::{PixelJacobian, pixel_jacobian};
use super::{Mesh, MeshSize};
use crate::pad::{Pad, TouchSign};
use crate::types::{Image, PixelGrid};
use kernel::RowMatrix;

/// Edge of a reconstruction pixel, mm: about 1,000 pixels of the shipped pad hold conductor.
pub const PIXEL_MM: f64 = 2.5;

/// The hyperparameter of the paper, in the scaling of this module.
pub const LAMBDA: f64 = 0.01;

/// How an image is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Prior: identity.
    Tikhonov,
    /// Prior: the inverse root of each pixel's sensitivity, which evens out depth.
    #[default]
    Noser,
}

impl Method {
    /// All of them.
    pub const ALL: &[Self] = &[Self::Tikhonov, Self::Noser];

    /// The word on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Tikhonov => "tikhonov",
            Self::Noser => "noser",
        }
    }
}

/// Why a pad gives no image.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SetupError {
    /// The forward model fails.
    #[error(transparent)]
    Forward(#[from] ForwardError),
    /// A reading of the untouched pad is so near zero that no relative change can be told.
    #[error(
        "channel {channel} reads almost nothing on the untouched pad: leave it out of the protocol"
    )]
    DeadChannel {
        /// Its place in the frame.
        channel: usize,
    },
    /// The system of channels has no solution.
    #[error("the reconstruction has no solution: lambda must be above zero")]
    Singular,
}

/// The linearised pad: what every reconstruction starts from.
#[derive(Clone, Debug)]
pub struct Linearised {
    /// Where the pixels lie.
    pub grid: PixelGrid,
    /// Pixels that hold conductor, ascending.
    pub active: Vec<usize>,
    /// Share of each pixel that is conductor.
    pub coverage: Vec<f64>,
    /// Channels by active pixels: relative change of a reading for a relative rise of conductivity.
    pub jacobian: Mat<f64>,
}

impl Linearised {
    /// Solves the pad's forward model once and linearises it about the even background.
    ///
    /// # Errors
    /// See [`SetupError`].
    pub fn of_pad(pad: &Pad) -> Result<Self, SetupError> {
        let mesh = Mesh::of_pad(pad, MeshSize::reconstruction(pad));
        let model = ForwardModel::new(mesh, &ContactModel::of_pad(pad))?;
        let fields = model.solve_even(pad.background_s_per_m)?;
        let volts = fields.voltages(&pad.protocol);
        if let Some(channel) = dead_channel(&volts) {
            return Err(SetupError::DeadChannel { channel });
        }
        let grid = pixel_grid(pad);
        let PixelJacobian {
            active,
            coverage,
            matrix: mut jacobian,
        } = pixel_jacobian(&model, &fields, &pad.protocol, &grid);
        for column in 0..jacobian.ncols() {
            for (entry, volt) in jacobian.col_mut(column).iter_mut().zip(&volts) {
                *entry *= pad.background_s_per_m / volt;
            }
        }
        Ok(Self {
            grid,
            active,
            coverage,
            jacobian,
        })
    }
}

/// The first reading that is nothing beside the others, if there is one.
fn dead_channel(volts: &[f64]) -> Option<usize> {
    let largest = volts
        .iter()
        .fold(0.0_f64, |most, volt| most.max(volt.abs()));
    volts.iter().position(|volt| volt.abs() < 1e-9 * largest)
}

/// The grid of reconstruction pixels over a pad's box.
#[must_use]
pub fn pixel_grid(pad: &Pad) -> PixelGrid {
    let cells = |length: f64| libm::ceil(length / PIXEL_MM - 1e-9).max(1.0) as usize;
    let [width, height] = pad.outline.size_mm();
    PixelGrid {
        origin_mm: [0.0, 0.0],
        pixel_mm: PIXEL_MM,
        columns: cells(width),
        rows: cells(height),
    }
}

/// A pad's reconstruction matrix and what is needed to apply it.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// How it was made.
    pub method: Method,
    /// Where the pixels of its images lie.
    pub grid: PixelGrid,
    /// Share of each pixel of the grid that is conductor, 0 to 1.
    pub coverage: Vec<f32>,
    /// The pixel of each row of the matrix.
    active: Vec<usize>,
    matrix: RowMatrix,
    sign: f32,
}

impl Reconstruction {
    /// Builds the matrix of a pad with the hyperparameter [`LAMBDA`].
    ///
    /// # Errors
    /// See [`SetupError`].
    pub fn of_pad(pad: &Pad, method: Method) -> Result<Self, SetupError> {
        Self::from_linearised(&Linearised::of_pad(pad)?, method, LAMBDA, pad.touch_sign)
    }

    /// Builds the matrix from a linearised pad.
    ///
    /// # Errors
    /// [`SetupError::Singular`] if lambda is not above zero.
    pub fn from_linearised(
        pad: &Linearised,
        method: Method,
        lambda: f64,
        touch_sign: TouchSign,
    ) -> Result<Self, SetupError> {
        let prior = match method {
            Method::Tikhonov => quadratic::even_prior(&pad.jacobian),
            Method::Noser => quadratic::noser_prior(&pad.jacobian),
        };
        let matrix = quadratic::one_step(&pad.jacobian, &prior, lambda)?;
        Ok(Self {
            method,
            grid: pad.grid,
            coverage: pad.coverage.iter().map(|share| *share as f32).collect(),
            active: pad.active.clone(),
            matrix: RowMatrix::transposed(&matrix),
            sign: touch_sign.factor(),
        })
    }

    /// Number of voltages in a frame.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.matrix.columns()
    }

    /// Number of pixels that hold conductor.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.active.len()
    }

    /// The image of relative voltage changes: signed by the pad's touch sign, then cut at zero.
    ///
    /// # Panics
    /// If there is not one change a channel, or the image lies on another grid.
    pub fn apply(&self, changes: &[f32], image: &mut Image) {
        assert_eq!(image.grid, self.grid, "the image lies on the matrix' grid");
        for (row, pixel) in self.active.iter().enumerate() {
            let value = self.sign * self.matrix.row_dot(row, changes);
            image.values[*pixel] = value.max(0.0);
        }
    }
}
