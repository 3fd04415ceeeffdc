//! How pads usually differ from their drawing: covariances of the unknowns, one for each way to differ.
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

/// A way in which pads differ, independent of the others; how much they do is found from the readings.
pub(super) enum Component {
    /// Covariance of the logarithms of the cells' conductance.
    Cells(Mat<f64>),
    /// Variances of the electrodes' shifts, mm2.
    Shifts(Vec<f64>),
    /// Variances of the electrodes' stretches, mm2.
    Stretches(Vec<f64>),
}

/// The prior of all unknowns: cells, then shifts and stretches of the electrodes.
pub(super) struct Prior {
    /// Cells by themselves, along channels, smoothly and along a gradient; electrodes.
    pub(super) components: Vec<Component>,
    /// Number of cells, and of electrodes.
    pub(super) cells: usize,
    pub(super) electrodes: usize,
}

impl Prior {
    /// The prior of a pad with cells at these sites.
    pub(super) fn new(pad: &Pad, sites: &[PointMm]) -> Self {
        let covariance = |of: &dyn Fn(usize, usize) -> f64| {
            Component::Cells(Mat::from_fn(sites.len(), sites.len(), of))
        };
        let size = pad.outline.size_mm();
        let longer = size[0].max(size[1]);
        let smooth_mm = SMOOTH_SHARE * longer;
        let smooth = |i: usize, j: usize| {
            let [dx, dy] = [0, 1].map(|k| sites[i][k] - sites[j][k]);
            let distance2 = (dx * dx + dy * dy) / (smooth_mm * smooth_mm);
            SMOOTH_SD * SMOOTH_SD * libm::exp(-0.5 * distance2)
        };
        let from_middle = |i: usize| [0, 1].map(|k| 2.0 * sites[i][k] / longer - size[k] / longer);
        let gradient = |i: usize, j: usize| {
            let (u, v) = (from_middle(i), from_middle(j));
            GRADIENT_SD * GRADIENT_SD * (u[0] * v[0] + u[1] * v[1])
        };
        let channel = |i: usize, j: usize| match is_one_channel(pad, sites[i], sites[j]) {
            true => CHANNEL_SD * CHANNEL_SD,
            false => 0.0,
        };
        let own = |i: usize, j: usize| if i == j { CELL_SD * CELL_SD } else { 0.0 };
        let shifts = vec![SHIFT_SD_MM * SHIFT_SD_MM; pad.electrodes.len()];
        let stretches = pad.electrodes.iter().map(|electrode| {
            let sd = STRETCH_SD * electrode.width_mm;
            sd * sd
        });
        Self {
            components: vec![
                covariance(&own),
                covariance(&channel),
                covariance(&smooth),
                covariance(&gradient),
                Component::Shifts(shifts),
                Component::Stretches(stretches.collect()),
            ],
            cells: sites.len(),
            electrodes: pad.electrodes.len(),
        }
    }

    /// The covariance of all unknowns, with each component's deviations multiplied by its spread.
    pub(super) fn covariance(&self, spreads: &[f64]) -> Mat<f64> {
        let mut covariance = Mat::zeros(self.len(), self.len());
        for (component, spread) in self.components.iter().zip(spreads) {
            let times = spread * spread;
            let (first, variances) = match component {
                Component::Cells(own) => {
                    for j in 0..self.cells {
                        for i in 0..self.cells {
                            covariance[(i, j)] += times * own[(i, j)];
                        }
                    }
                    continue;
                }
                Component::Shifts(variances) => (self.cells, variances),
                Component::Stretches(variances) => (self.cells + self.electrodes, variances),
            };
            for (index, variance) in variances.iter().enumerate() {
                covariance[(first + index, first + index)] += times * variance;
            }
        }
        covariance
    }

    /// Number of unknowns.
    pub(super) fn len(&self) -> usize {
        self.cells + 2 * self.electrodes
    }
}

/// Whether two sites lie on the same channel of a lattice.
fn is_one_channel(pad: &Pad, a: PointMm, b: PointMm) -> bool {
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
}
