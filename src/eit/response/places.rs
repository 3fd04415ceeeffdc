//! Where a table is solved: a grid of places and a row of radii.

use crate::types::PointMm;

/// Grid steps along a pad's longer side: 2 mm on a 100 mm pad, fine enough for the channels of a lattice.
const PLACES_ALONG: f64 = 50.0;
/// Radii of a table, each [`RADIUS_STEP`] times the one before. Closely spaced, because a touch over a hole of a lattice
/// reaches conductor suddenly as it widens. The outermost two only support the cubic interpolation.
pub(super) const RADII: usize = 7;
/// The smallest solved radius as a share of the pad's longer side: 4.4 mm of 100 mm.
const LEAST_RADIUS_SHARE: f64 = 0.044;
pub(super) const RADIUS_STEP: f64 = 1.22;
/// Grid steps beyond the pad's box on each side: a finger at the edge may have its centre outside.
const MARGIN: usize = 3;
/// The same in tables of the first version: what the cubic interpolation needs.
const OLD_MARGIN: usize = 1;
/// What the grid of a table depends on beside the pad.
pub(super) const CONSTANTS: [f64; 5] = [
    PLACES_ALONG,
    RADII as f64,
    LEAST_RADIUS_SHARE,
    RADIUS_STEP,
    MARGIN as f64,
];

/// The grid of places. It extends beyond the pad's box on each side; the outermost places only support the cubic
/// interpolation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Places {
    pub(super) pitch_mm: f64,
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Steps beyond the box.
    pub(super) margin: usize,
}

impl Places {
    /// The grid of a pad of the given width and height, mm.
    pub(super) fn new(size_mm: [f64; 2]) -> Self {
        Self::with_margin(size_mm, MARGIN)
    }

    /// The grid of tables of the first version.
    pub(super) fn old(size_mm: [f64; 2]) -> Self {
        Self::with_margin(size_mm, OLD_MARGIN)
    }

    fn with_margin([width, height]: [f64; 2], margin: usize) -> Self {
        let pitch_mm = width.max(height) / PLACES_ALONG;
        let count = |side: f64| libm::ceil(side / pitch_mm - 1e-9) as usize + 1 + 2 * margin;
        Self {
            pitch_mm,
            columns: count(width),
            rows: count(height),
            margin,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.columns * self.rows
    }

    pub(super) fn at_mm(&self, index: usize) -> PointMm {
        let (row, column) = (index / self.columns, index % self.columns);
        [column, row].map(|step| (step as f64 - self.margin as f64) * self.pitch_mm)
    }

    /// The place at a point, if there is one.
    pub(super) fn index_at(&self, point: PointMm) -> Option<usize> {
        let [column, row] = point.map(|at| at / self.pitch_mm + self.margin as f64);
        let is_on_grid = [column, row]
            .iter()
            .all(|step| (step - libm::round(*step)).abs() < 1e-6);
        let [column, row] = [column, row].map(libm::round);
        let is_within =
            (0.0..self.columns as f64).contains(&column) && (0.0..self.rows as f64).contains(&row);
        (is_on_grid && is_within).then_some(row as usize * self.columns + column as usize)
    }

    /// How far outside the pad's box touches are covered, mm.
    pub(super) fn reach_mm(&self) -> f64 {
        (self.margin as f64 - 1.0) * self.pitch_mm
    }

    /// The first radius, mm.
    pub(super) fn least_radius_mm(&self) -> f64 {
        LEAST_RADIUS_SHARE * PLACES_ALONG * self.pitch_mm / RADIUS_STEP
    }

    /// All radii, mm.
    pub(super) fn radii_mm(&self) -> Vec<f64> {
        let first = Some(self.least_radius_mm());
        std::iter::successors(first, |radius_mm| Some(radius_mm * RADIUS_STEP))
            .take(RADII)
            .collect()
    }
}
