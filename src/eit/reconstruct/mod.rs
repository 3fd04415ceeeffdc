//! Relative voltage changes to an image.
//!
//! Set-up (f64, once a pad) turns the model into one f32 matrix; a frame is one product with it, summed in an
//! order that `kernel` fixes, negative values cut. `l1` is the exception: it iterates, from the last frame's answer.
//! The scaling of the hyperparameter is the project's (see `quadratic`): it does not move with the size of a pixel or
//! the units of a voltage.

mod bytes;
mod kernel;
pub mod l1;
mod quadratic;

use std::sync::Arc;

use faer::Mat;

use super::forward::{ContactModel, ForwardError, ForwardModel};
use super::jacobian::{PixelJacobian, pixel_jacobian};
use super::{Mesh, MeshSize};
use crate::pad::{Pad, TouchSign};
use crate::types::{Image, Method, PixelGrid};
use kernel::{Padded, RowMatrix};
use l1::{L1Model, L1State, Quality};

/// Edge of a reconstruction pixel, mm: about 1,000 pixels of the shipped pad hold conductor.
pub const PIXEL_MM: f64 = 2.5;
/// Larger pads get larger pixels: at most this many along a side.
const MOST_PIXELS: f64 = 80.0;

/// The hyperparameter of the paper, in the scaling of this module.
pub const LAMBDA: f64 = 0.01;

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
pub(super) fn dead_channel(volts: &[f64]) -> Option<usize> {
    let largest = volts
        .iter()
        .fold(0.0_f64, |most, volt| most.max(volt.abs()));
    volts.iter().position(|volt| volt.abs() < 1e-9 * largest)
}

/// The grid of reconstruction pixels over a pad's box.
#[must_use]
pub fn pixel_grid(pad: &Pad) -> PixelGrid {
    let [width, height] = pad.outline.size_mm();
    let pixel_mm = PIXEL_MM.max(width.max(height) / MOST_PIXELS);
    let cells = |length: f64| libm::ceil(length / pixel_mm - 1e-9).max(1.0) as usize;
    PixelGrid {
        origin_mm: [0.0, 0.0],
        pixel_mm,
        columns: cells(width),
        rows: cells(height),
    }
}

/// How a pad's images are made: its matrix, or what L1 needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// The method that it was made for.
    pub method: Method,
    /// Where the pixels of its images lie.
    pub grid: PixelGrid,
    /// Share of each pixel of the grid that is conductor, 0 to 1.
    pub coverage: Vec<f32>,
    /// The pixel of each unknown.
    active: Vec<usize>,
    solver: Solver,
    sign: f32,
}

#[derive(Clone, Debug, PartialEq)]
enum Solver {
    OneStep(RowMatrix),
    L1(L1Model),
}

impl Reconstruction {
    /// Prepares a pad with the hyperparameter [`LAMBDA`].
    ///
    /// # Errors
    /// See [`SetupError`].
    pub fn of_pad(pad: &Pad, method: Method) -> Result<Self, SetupError> {
        Self::from_linearised(&Linearised::of_pad(pad)?, method, LAMBDA, pad.touch_sign)
    }

    /// Prepares a linearised pad.
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

    /// +1 where a touch conducts better, -1 where it conducts worse.
    #[must_use]
    pub fn touch_factor(&self) -> f32 {
        self.sign
    }

    /// Number of pixels that hold conductor.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.active.len()
    }
}

/// Makes images, one frame after the other.
#[derive(Clone, Debug)]
pub struct Imager {
    reconstruction: Arc<Reconstruction>,
    padded: Padded,
    products: Vec<f32>,
    l1: L1State,
    signed: Vec<f64>,
    quality: Option<Quality>,
}

impl Imager {
    /// An imager that has seen no frame.
    #[must_use]
    pub fn new(reconstruction: Arc<Reconstruction>) -> Self {
        Self {
            reconstruction,
            padded: Padded::default(),
            products: Vec::new(),
            l1: L1State::default(),
            signed: Vec::new(),
            quality: None,
        }
    }

    /// What its images are made with.
    #[must_use]
    pub fn reconstruction(&self) -> &Arc<Reconstruction> {
        &self.reconstruction
    }

    /// How good the last answer of L1 was; `None` for the other methods.
    #[must_use]
    pub fn quality(&self) -> Option<Quality> {
        self.quality
    }

    /// The image of relative voltage changes: signed by the pad's touch sign, then cut at zero. `noise` is the
    /// deviation of a change, which L1 needs (0 if unknown).
    ///
    /// # Panics
    /// If there is not one change a channel, or the image lies on another grid.
    pub fn image(&mut self, changes: &[f32], noise: f64, image: &mut Image) {
        self.uncut(changes, noise, image);
        for value in &mut image.values {
            *value = value.max(0.0);
        }
    }

    /// The image before negative values are cut: what ringing is measured on.
    ///
    /// # Panics
    /// As [`Self::image`].
    pub fn uncut(&mut self, changes: &[f32], noise: f64, image: &mut Image) {
        let Reconstruction {
            grid,
            active,
            solver,
            sign,
            ..
        } = &*self.reconstruction;
        assert_eq!(image.grid, *grid, "the image lies on the matrix' grid");
        match solver {
            Solver::OneStep(matrix) => {
                assert_eq!(changes.len(), matrix.columns(), "one change a channel");
                self.padded.set(changes);
                matrix.times(&self.padded, &mut self.products);
                for (pixel, product) in active.iter().zip(&self.products) {
                    image.values[*pixel] = sign * product;
                }
            }
            Solver::L1(model) => {
                self.signed.clear();
                self.signed
                    .extend(changes.iter().map(|change| f64::from(sign * change)));
                self.quality = Some(model.solve(&self.signed, noise, &mut self.l1));
                for (column, pixel) in active.iter().enumerate() {
                    let change = self.l1.answer()[column] / model.norm(column);
                    image.values[*pixel] = change as f32;
                }
            }
        }
    }
}
