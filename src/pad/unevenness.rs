//! How the conductance of the layer differs from place to place: gel that was cast uneven, dried, or broke.
//!
//! The layer is divided into cells, each with a site, and every point belongs to the nearest site. On a lattice the sites are the middles of the pieces
//! of channel between crossings, since only the conductance of a piece is seen from outside; elsewhere they form a grid.

use super::{Conductor, Pad};
use crate::types::PointMm;

/// Distance of sites on a layer without channels, as a share of the longer side.
const GRID_SHARE: f64 = 0.08;

/// Relative conductance of the cells of a layer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unevenness {
    /// Sites, and the conductivity of their cells over the layer's; none for an even layer.
    cells: Vec<(PointMm, f64)>,
}

impl Unevenness {
    /// Cells with these sites (mm) and factors of the conductivity, which are above zero.
    #[must_use]
    pub fn new(cells: Vec<(PointMm, f64)>) -> Self {
        Self { cells }
    }

    /// Whether the conductivity is the same everywhere.
    #[must_use]
    pub fn is_even(&self) -> bool {
        self.cells.is_empty()
    }

    /// Sites and factors.
    #[must_use]
    pub fn cells(&self) -> &[(PointMm, f64)] {
        &self.cells
    }

    /// The index of the cell that holds a point; `None` for an even layer.
    #[must_use]
    pub fn cell_at(&self, [x, y]: PointMm) -> Option<usize> {
        let distance = |index: &usize| {
            let [sx, sy] = self.cells[*index].0;
            (x - sx) * (x - sx) + (y - sy) * (y - sy)
        };
        (0..self.cells.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    /// The factor of the conductivity at a point, 1 for an even layer.
    #[must_use]
    pub fn factor_at(&self, point: PointMm) -> f64 {
        self.cell_at(point).map_or(1.0, |cell| self.cells[cell].1)
    }
}

/// The sites of a pad's cells, mm: the middles of the pieces of channel between crossings, or a grid.
#[must_use]
pub fn cell_sites_mm(pad: &Pad) -> Vec<PointMm> {
    match &pad.conductor {
        Conductor::Lattice(lattice) => {
            let middles = |lines: &[f64]| -> Vec<f64> {
                lines
                    .windows(2)
                    .map(|pair| 0.5 * (pair[0] + pair[1]))
                    .collect()
            };
            let (xs, ys) = (&lattice.x_lines_mm, &lattice.y_lines_mm);
            let along_y = middles(ys)
                .into_iter()
                .flat_map(|y| xs.iter().map(move |x| [*x, y]));
            let along_x = middles(xs)
                .into_iter()
                .flat_map(|x| ys.iter().map(move |y| [x, *y]));
            along_y.chain(along_x).collect()
        }
        Conductor::Solid => {
            let size = pad.outline.size_mm();
            let step = GRID_SHARE * size[0].max(size[1]);
            let along = |length: f64| {
                let count = libm::ceil(length / step).max(1.0) as usize;
                (0..count).map(move |k| length * (k as f64 + 0.5) / count as f64)
            };
            let sites = along(size[1]).flat_map(|y| along(size[0]).map(move |x| [x, y]));
            sites.filter(|site| pad.outline.contains(*site)).collect()
        }
    }
}
