//! The linearised pad, from which every reconstruction starts.

use faer::Mat;

use crate::eit::forward::{ContactModel, ForwardError, ForwardModel};
use crate::eit::jacobian::{PixelJacobian, pixel_jacobian};
use crate::eit::{Mesh, MeshSize, TYPICAL_PRESS_MM2};
use crate::pad::{LearnedMaps, Pad};
use crate::types::PixelGrid;

/// Edge of a reconstruction pixel, mm: about 1,000 pixels of the shipped pad hold conductor.
pub const PIXEL_MM: f64 = 2.5;
/// Most pixels along a side; larger pads get larger pixels.
pub(super) const MOST_PIXELS: f64 = 80.0;

/// The hyperparameter of the paper, scaled as in `quadratic`.
pub const LAMBDA: f64 = 0.01;

/// Why no image can be made of a pad.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SetupError {
    /// The forward model fails.
    #[error(transparent)]
    Forward(#[from] ForwardError),
    /// A reading of the untouched pad is too close to zero for relative changes.
    #[error(
        "channel {channel} of the untouched pad reads almost zero: remove it from the protocol"
    )]
    DeadChannel {
        /// Its index in the frame.
        channel: usize,
    },
    /// Every channel is excluded.
    #[error("no reading can be used: is the pad connected, and is the board powered?")]
    NoChannel,
    /// The linear system is singular.
    #[error("the reconstruction has no solution: lambda must be above zero")]
    Singular,
}

/// A pad linearised about its uniform background.
#[derive(Clone, Debug)]
pub struct Linearised {
    /// Where the pixels lie.
    pub grid: PixelGrid,
    /// Pixels that hold conductor, ascending.
    pub active: Vec<usize>,
    /// Share of each pixel that is conductor.
    pub coverage: Vec<f64>,
    /// Channels x active pixels: relative change of a reading per relative rise of conductivity.
    pub jacobian: Mat<f64>,
}

impl Linearised {
    /// Solves the pad's forward model once and linearises it. A pad that was learned from presses has its maps instead.
    ///
    /// # Errors
    /// See [`SetupError`].
    pub fn from_pad(pad: &Pad) -> Result<Self, SetupError> {
        if let Some(maps) = &pad.learned {
            return Ok(Self::from_maps(pad, maps));
        }
        let mesh = Mesh::from_pad(pad, MeshSize::reconstruction(pad));
        let model = ForwardModel::new(mesh, &ContactModel::from_pad(pad))?;
        let fields = model.solve(&model.mesh().background_s_per_m(pad))?;
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
        for (column, pixel) in active.iter().enumerate() {
            let background = pad.conductivity_at(grid.centre_mm(*pixel));
            for (entry, volt) in jacobian.col_mut(column).iter_mut().zip(&volts) {
                *entry *= background / volt;
            }
        }
        Ok(Self {
            grid,
            active,
            coverage,
            jacobian,
        })
    }

    /// Each pixel's share of a typical press there.
    fn from_maps(pad: &Pad, maps: &LearnedMaps) -> Self {
        let grid = pixel_grid(pad);
        let pixels = 0..grid.columns * grid.rows;
        let is_active = |pixel: &usize| pad.outline.contains(grid.centre_mm(*pixel));
        let active: Vec<usize> = pixels.clone().filter(is_active).collect();
        let share = grid.pixel_mm * grid.pixel_mm / TYPICAL_PRESS_MM2;
        let changes: Vec<Vec<f64>> = active
            .iter()
            .map(|pixel| maps.changes_at(grid.centre_mm(*pixel), pad.outline.size_mm()))
            .collect();
        Self {
            jacobian: Mat::from_fn(pad.channels(), active.len(), |channel, column| {
                share * changes[column][channel]
            }),
            coverage: pixels
                .map(|pixel| f64::from(u8::from(is_active(&pixel))))
                .collect(),
            active,
            grid,
        }
    }
}

/// The first reading that is negligible compared with the largest.
pub(in crate::eit) fn dead_channel(volts: &[f64]) -> Option<usize> {
    let largest = volts
        .iter()
        .fold(0.0_f64, |most, volt| most.max(volt.abs()));
    volts.iter().position(|volt| volt.abs() < 1e-9 * largest)
}

/// The reconstruction pixels over a pad's bounding box.
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
