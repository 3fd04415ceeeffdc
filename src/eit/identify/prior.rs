//! How pads of a kind usually differ from their drawing: covariances of the unknowns.
//!
//! Cells differ by themselves (casting), along a channel (its width), smoothly over the pad (thickness, drying) and along a gradient. Electrodes
//! are placed and cut by hand.

use faer::Mat;

use crate::pad::{Conductor, Pad};
use crate::types::PointMm;

/// Standard deviations of the logarithm of a cell's conductance: by itself, ...
const CELL_SD: f64 = 0.1;
/// ... along a channel, ...
const CHANNEL_SD: f64 = 0.05;
/// ... smoothly over the pad, with this length as a share of its longer side, ...
const SMOOTH_SD: f64 = 0.1;
const SMOOTH_SHARE: f64 = 0.35;
/// ... and of a gradient, from the middle to the edge.
const GRADIENT_SD: f64 = 0.08;
/// Standard deviations of an electrode's place and, as a share, length: mm.
const SHIFT_SD_MM: f64 = 0.5;
const STRETCH_SD: f64 = 0.1;
/// Cells on one channel lie this near its centre line, mm.
const SAME_LINE_MM: f64 = 1e-6;

/// The prior of all unknowns: cells (dense), shifts and stretches of the electrodes (independent).
pub(super) struct Prior {
    /// Covariance of the logarithms of the cells' conductance.
    pub(super) cells: Mat<f64>,
    /// Variances of the electrodes' shifts, then stretches, mm2.
    pub(super) electrodes: Vec<f64>,
}

impl Prior {
    /// Number of unknowns.
    pub(super) fn len(&self) -> usize {
        self.cells.nrows() + self.electrodes.len()
    }
}

/// The prior of a pad with cells at these sites.
pub(super) fn covariance(pad: &Pad, sites: &[PointMm]) -> Prior {
    let size = pad.outline.size_mm();
    let longer = size[0].max(size[1]);
    let smooth_mm = SMOOTH_SHARE * longer;
    let from_middle = |site: PointMm| [0, 1].map(|k| 2.0 * site[k] / longer - size[k] / longer);
    let on_one_channel = |a: PointMm, b: PointMm| {
        let Conductor::Lattice(lattice) = &pad.conductor else {
            return false;
        };
        let lines = [&lattice.x_lines_mm, &lattice.y_lines_mm];
        (0..2).any(|axis| {
            let is_on = |at: f64| {
                lines[axis]
                    .iter()
                    .any(|line| (line - at).abs() < SAME_LINE_MM)
            };
            is_on(a[axis]) && (a[axis] - b[axis]).abs() < SAME_LINE_MM
        })
    };
    let cells = Mat::from_fn(sites.len(), sites.len(), |i, j| {
        let (a, b) = (sites[i], sites[j]);
        let [dx, dy] = [a[0] - b[0], a[1] - b[1]];
        let smooth = libm::exp(-0.5 * (dx * dx + dy * dy) / (smooth_mm * smooth_mm));
        let (u, v) = (from_middle(a), from_middle(b));
        let mut covariance = SMOOTH_SD * SMOOTH_SD * smooth
            + GRADIENT_SD * GRADIENT_SD * (u[0] * v[0] + u[1] * v[1]);
        if on_one_channel(a, b) {
            covariance += CHANNEL_SD * CHANNEL_SD;
        }
        if i == j {
            covariance += CELL_SD * CELL_SD;
        }
        covariance
    });
    let shifts = pad.electrodes.iter().map(|_| SHIFT_SD_MM * SHIFT_SD_MM);
    let stretches = pad.electrodes.iter().map(|electrode| {
        let sd = STRETCH_SD * electrode.width_mm;
        sd * sd
    });
    Prior {
        cells,
        electrodes: shifts.chain(stretches).collect(),
    }
}
