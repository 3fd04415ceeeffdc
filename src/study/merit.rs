//! Figures of merit of an image: GREIT's five (Adler et al. 2009), overlap, and topology.
//!
//! Images are judged on a fine grid that covers the whole pad, including the holes between channels. Each value is a mean
//! over the conductor around it with Gaussian weights, since a finger bridges holes.

use crate::types::{Image, PixelGrid, PointMm};

/// A value for every cell of a grid over the pad.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// The grid.
    pub grid: PixelGrid,
    /// One value for each cell, rows from the bottom.
    pub values: Vec<f64>,
}

/// Edge of a raster's cell, mm.
const CELL_MM: f64 = 2.0;
/// Share of the peak from which a cell belongs to GREIT's set q.
const QUARTER: f64 = 0.25;
/// Share of the peak at which shapes are cut.
const HALF: f64 = 0.5;

/// GREIT's figures of merit for one target.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Merit {
    /// Amplitude response: sum of the image over sum of the truth.
    pub amplitude_response: f64,
    /// Distance of the centre of set q from the target's centre, mm.
    pub place_error_mm: f64,
    /// Resolution: root of the share of the pad that set q covers.
    pub resolution: f64,
    /// Share of set q outside a circle of its area about its centre.
    pub shape_deformation: f64,
    /// Ringing: sum of the negative values outside that circle over the sum inside.
    pub ringing: f64,
}

impl Merit {
    /// Each figure computed by `summary`, as a mean or median over many targets.
    pub(super) fn summarised(summary: impl Fn(fn(&Self) -> f64) -> f64) -> Self {
        Self {
            amplitude_response: summary(|merit| merit.amplitude_response),
            place_error_mm: summary(|merit| merit.place_error_mm),
            resolution: summary(|merit| merit.resolution),
            shape_deformation: summary(|merit| merit.shape_deformation),
            ringing: summary(|merit| merit.ringing),
        }
    }
}

impl Raster {
    /// An image of conductor pixels, weighted by their coverage (0 to 1) and smoothed with a deviation in mm.
    #[must_use]
    pub fn smoothed(image: &Image, coverage: &[f32], size_mm: [f64; 2], deviation_mm: f64) -> Self {
        let grid = Self::grid(size_mm);
        let reach = 3.0 * deviation_mm;
        let conductor: Vec<(PointMm, f64, f64)> = (0..image.grid.len())
            .filter(|pixel| coverage[*pixel] > 0.0)
            .map(|pixel| {
                let share = f64::from(coverage[pixel]);
                (
                    image.grid.centre_mm(pixel),
                    share,
                    f64::from(image.values[pixel]),
                )
            })
            .collect();
        let values = (0..grid.len())
            .map(|cell| {
                let [x, y] = grid.centre_mm(cell);
                let (mut sum, mut weights) = (0.0, 0.0);
                for ([px, py], share, value) in &conductor {
                    let (dx, dy) = (px - x, py - y);
                    if dx.abs() > reach || dy.abs() > reach {
                        continue;
                    }
                    let z2 = (dx * dx + dy * dy) / (deviation_mm * deviation_mm);
                    let weight = share * (-0.5 * z2).exp();
                    sum += weight * value;
                    weights += weight;
                }
                if weights > 0.0 { sum / weights } else { 0.0 }
            })
            .collect();
        Self { grid, values }
    }

    /// 1 where `holds`, 0 elsewhere, on a pad of this size.
    #[must_use]
    pub fn from_mask(size_mm: [f64; 2], holds: impl Fn(PointMm) -> bool) -> Self {
        let (grid, values) = (Self::grid(size_mm), Vec::new());
        Self { grid, values }.mask(holds)
    }

    /// 1 where `holds`, 0 elsewhere, on the same grid.
    #[must_use]
    pub fn mask(&self, holds: impl Fn(PointMm) -> bool) -> Self {
        let cells = (0..self.grid.len()).map(|cell| self.grid.centre_mm(cell));
        Self {
            grid: self.grid,
            values: cells
                .map(|point| f64::from(u8::from(holds(point))))
                .collect(),
        }
    }

    fn grid(size_mm: [f64; 2]) -> PixelGrid {
        let cells = |length: f64| (length / CELL_MM).ceil() as usize;
        PixelGrid {
            origin_mm: [0.0, 0.0],
            pixel_mm: CELL_MM,
            columns: cells(size_mm[0]),
            rows: cells(size_mm[1]),
        }
    }

    /// The largest value, at least zero.
    #[must_use]
    pub fn peak(&self) -> f64 {
        self.values.iter().copied().fold(0.0, f64::max)
    }

    /// A copy with negative values set to zero.
    #[must_use]
    pub fn cut(&self) -> Self {
        Self {
            grid: self.grid,
            values: self.values.iter().map(|value| value.max(0.0)).collect(),
        }
    }

    /// The cells that reach a share of the peak.
    fn reaching(&self, share: f64) -> Vec<bool> {
        let edge = share * self.peak();
        self.values
            .iter()
            .map(|value| *value >= edge && *value > 0.0)
            .collect()
    }

    /// Intersection over union of the image, cut at half its peak, with the true mask on the same grid.
    #[must_use]
    pub fn overlap(&self, truth: &Raster) -> f64 {
        let (mut both, mut either) = (0usize, 0usize);
        for (seen, held) in self.reaching(HALF).into_iter().zip(&truth.values) {
            let held = *held > 0.5;
            both += usize::from(seen && held);
            either += usize::from(seen || held);
        }
        both as f64 / either.max(1) as f64
    }

    /// Euler number of the image cut at half its peak: parts minus holes. Cells join at edges and corners, holes
    /// at edges only. Counted by 2 x 2 patterns (Gray 1971).
    #[must_use]
    pub fn euler_number(&self) -> i64 {
        let mask = self.reaching(HALF);
        let (columns, rows) = (self.grid.columns as i64, self.grid.rows as i64);
        let at = |row: i64, column: i64| {
            (0..rows).contains(&row)
                && (0..columns).contains(&column)
                && mask[(row * columns + column) as usize]
        };
        let (mut single, mut triple, mut diagonal) = (0i64, 0i64, 0i64);
        for row in -1..rows {
            for column in -1..columns {
                let [a, b, c, d] = [
                    at(row, column),
                    at(row, column + 1),
                    at(row + 1, column),
                    at(row + 1, column + 1),
                ];
                match u8::from(a) + u8::from(b) + u8::from(c) + u8::from(d) {
                    1 => single += 1,
                    3 => triple += 1,
                    2 if a == d => diagonal += 1,
                    _ => {}
                }
            }
        }
        (single - triple - 2 * diagonal) / 4
    }

    /// GREIT's figures for one target with a given amplitude, from its `own` cells (nearer to it than to another target).
    #[must_use]
    pub fn merit(
        &self,
        truth: &Raster,
        amplitude: f64,
        centre_mm: PointMm,
        own: impl Fn(PointMm) -> bool,
    ) -> Merit {
        let at = |cell: &usize| self.grid.centre_mm(*cell);
        let value = |cell: &usize| self.values[*cell];
        let cells: Vec<usize> = (0..self.grid.len()).filter(|cell| own(at(cell))).collect();
        let peak = cells.iter().map(value).fold(0.0, f64::max);
        let in_q = |cell: &usize| peak > 0.0 && value(cell) >= QUARTER * peak;
        let q: Vec<usize> = cells.iter().copied().filter(in_q).collect();
        let sum: f64 = q.iter().map(value).sum();
        let centre = [0, 1].map(|axis| q.iter().map(|c| value(c) * at(c)[axis]).sum::<f64>() / sum);
        let cell_mm2 = CELL_MM * CELL_MM;
        let area_mm2 = q.len() as f64 * cell_mm2;
        let radius_mm = (area_mm2 / std::f64::consts::PI).sqrt();
        let distance_mm = |[x, y]: PointMm, [a, b]: PointMm| (x - a).hypot(y - b);
        let within = |cell: &&usize| distance_mm(at(cell), centre) <= radius_mm;
        let inside: f64 = cells.iter().filter(within).map(value).sum();
        let outside = cells.iter().filter(|cell| !within(cell));
        let against: f64 = outside.map(|cell| (-value(cell)).max(0.0)).sum();
        let total: f64 = cells.iter().map(value).sum();
        let held: f64 = cells.iter().map(|cell| truth.values[*cell]).sum();
        let stray = q.iter().filter(|cell| !within(cell)).count();
        Merit {
            amplitude_response: total / (amplitude * held),
            place_error_mm: distance_mm(centre, centre_mm),
            resolution: (area_mm2 / (self.grid.len() as f64 * cell_mm2)).sqrt(),
            shape_deformation: stray as f64 / q.len().max(1) as f64,
            ringing: against / inside,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [f64; 2] = [100.0, 100.0];

    fn ring(inner: f64, outer: f64) -> Raster {
        Raster::from_mask(SIZE, |[x, y]| {
            (inner..=outer).contains(&(x - 50.0).hypot(y - 50.0))
        })
    }

    #[test]
    fn euler_numbers_count_parts_and_holes() {
        assert_eq!(ring(0.0, 20.0).euler_number(), 1);
        assert_eq!(ring(10.0, 20.0).euler_number(), 0);
        let two = Raster::from_mask(SIZE, |[x, y]| {
            [30.0, 70.0].iter().any(|c| (x - c).hypot(y - 50.0) < 8.0)
        });
        assert_eq!(two.euler_number(), 2);
    }

    #[test]
    fn overlap_is_one_for_the_truth_and_known_for_a_larger_disc() {
        let (small, large) = (ring(0.0, 10.0), ring(0.0, 20.0));
        assert!((small.overlap(&small) - 1.0).abs() < 1e-12);
        assert!((large.overlap(&small) - 0.25).abs() < 0.02);
    }

    #[test]
    fn a_perfect_disc_has_perfect_figures() {
        let disc = ring(0.0, 15.0);
        let merit = disc.merit(&disc, 1.0, [50.0, 50.0], |_| true);
        assert!((merit.amplitude_response - 1.0).abs() < 1e-12);
        assert!(
            merit.place_error_mm < 1e-9 && merit.shape_deformation < 0.02 && merit.ringing == 0.0
        );
        let expected = (std::f64::consts::PI * 225.0 / 1e4).sqrt();
        assert!((merit.resolution - expected).abs() < 0.01);
    }
}
