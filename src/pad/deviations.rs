//! How a pad differs from its drawing: gel that was cast uneven, dried or broke, and electrodes that were placed by hand.
//!
//! The layer is divided into cells, each with a site, and every point belongs to the nearest site. On a lattice the sites are the middles
//! of the pieces of channel between crossings, since only the conductance of a piece is seen from outside; elsewhere they form a grid.

use super::{Conductor, Electrode, Pad};
use crate::types::PointMm;

/// Distance of sites on a layer without channels, as a share of the longer side.
const GRID_SHARE: f64 = 0.08;

/// How a pad differs from its drawing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deviations {
    /// Sites (mm), and the conductivity of their cells over the layer's, above zero; none for an even layer.
    pub cells: Vec<(PointMm, f64)>,
    /// One for each electrode, or none.
    pub electrodes: Vec<ElectrodeDeviation>,
    /// The electrodes as drawn, where they differ: undoing deviations would round.
    drawn_electrodes: Vec<Electrode>,
}

/// How an electrode differs from its drawing, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ElectrodeDeviation {
    /// Along the edge, counter-clockwise.
    pub shift_mm: f64,
    /// Of its length.
    pub stretch_mm: f64,
}

impl Deviations {
    /// Cells with their sites (mm) and factors, and one deviation for each electrode or none.
    #[must_use]
    pub fn new(cells: Vec<(PointMm, f64)>, electrodes: Vec<ElectrodeDeviation>) -> Self {
        Self {
            cells,
            electrodes,
            drawn_electrodes: Vec::new(),
        }
    }

    /// Whether the pad is as drawn.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.cells.is_empty() && self.electrodes.is_empty()
    }

    /// The index of the cell that holds a point; `None` for an even layer.
    #[must_use]
    pub fn cell_at(&self, [x, y]: PointMm) -> Option<usize> {
        // Every triangle of every mesh asks: each distance is computed once.
        let (mut nearest, mut least) = (None, f64::INFINITY);
        for (index, ([sx, sy], _)) in self.cells.iter().enumerate() {
            let squared = (x - sx) * (x - sx) + (y - sy) * (y - sy);
            if squared < least {
                (nearest, least) = (Some(index), squared);
            }
        }
        nearest
    }

    /// The factor of the conductivity at a point, 1 for an even layer.
    #[must_use]
    pub fn factor_at(&self, point: PointMm) -> f64 {
        self.cell_at(point).map_or(1.0, |cell| self.cells[cell].1)
    }
}

impl ElectrodeDeviation {
    /// An electrode as found, from its drawing.
    #[must_use]
    pub fn applied_to(self, electrode: &Electrode) -> Electrode {
        Electrode {
            start_mm: electrode.start_mm + self.shift_mm - self.stretch_mm / 2.0,
            width_mm: electrode.width_mm + self.stretch_mm,
        }
    }
}

impl Pad {
    /// The pad without its deviations.
    #[must_use]
    pub fn drawing(&self) -> Self {
        let drawn = &self.deviations.drawn_electrodes;
        Self {
            electrodes: if drawn.is_empty() {
                &self.electrodes
            } else {
                drawn
            }
            .clone(),
            deviations: Deviations::default(),
            ..self.clone()
        }
    }

    /// The pad's drawing with other deviations.
    #[must_use]
    pub fn with_deviations(&self, deviations: Deviations) -> Self {
        let drawing = self.drawing();
        if deviations.electrodes.is_empty() {
            return Self {
                deviations,
                ..drawing
            };
        }
        let pairs = drawing.electrodes.iter().zip(&deviations.electrodes);
        Self {
            electrodes: pairs
                .map(|(electrode, deviation)| deviation.applied_to(electrode))
                .collect(),
            deviations: Deviations {
                drawn_electrodes: drawing.electrodes.clone(),
                ..deviations
            },
            ..drawing
        }
    }
}

/// The sites of a pad's cells, mm: the middles of the pieces of channel between crossings, or a grid.
#[must_use]
pub fn cell_sites_mm(pad: &Pad) -> Vec<PointMm> {
    match &pad.conductor {
        Conductor::Lattice(lattice) => {
            let middles = |lines: &[f64]| -> Vec<f64> {
                let pairs = lines.windows(2);
                pairs.map(|pair| 0.5 * (pair[0] + pair[1])).collect()
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
