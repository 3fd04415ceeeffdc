//! Images: conductivity change on a regular grid of square pixels.

use super::PointMm;

/// The pixels of an image on the pad. Row 0 is the bottom row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelGrid {
    /// Bottom-left corner of pixel (0, 0), mm.
    pub origin_mm: PointMm,
    /// Edge of a pixel, mm.
    pub pixel_mm: f64,
    /// Pixels along x.
    pub columns: usize,
    /// Pixels along y.
    pub rows: usize,
}

impl PixelGrid {
    /// Number of pixels, with or without conductor.
    #[must_use]
    pub fn len(&self) -> usize {
        self.columns * self.rows
    }

    /// Whether the grid has no pixel.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The pixel that contains a point, if the point lies on the grid.
    #[must_use]
    pub fn index_at(&self, [x, y]: PointMm) -> Option<usize> {
        let column = libm::floor((x - self.origin_mm[0]) / self.pixel_mm);
        let row = libm::floor((y - self.origin_mm[1]) / self.pixel_mm);
        let inside =
            column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        inside.then(|| row as usize * self.columns + column as usize)
    }

    /// Centre of a pixel, mm.
    #[must_use]
    pub fn centre_mm(&self, index: usize) -> PointMm {
        let (row, column) = (index / self.columns, index % self.columns);
        [
            self.origin_mm[0] + (column as f64 + 0.5) * self.pixel_mm,
            self.origin_mm[1] + (row as f64 + 0.5) * self.pixel_mm,
        ]
    }
}

/// Relative conductivity change over the pad; negative values are cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// The pixels.
    pub grid: PixelGrid,
    /// One value per pixel, row by row from the bottom; zero without conductor.
    pub values: Vec<f32>,
}

impl Image {
    /// An image of zeros.
    #[must_use]
    pub fn blank(grid: PixelGrid) -> Self {
        Self {
            grid,
            values: vec![0.0; grid.len()],
        }
    }

    /// The largest value.
    #[must_use]
    pub fn peak(&self) -> f32 {
        self.values.iter().copied().fold(0.0, f32::max)
    }
}
