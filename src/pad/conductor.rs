//! The conductor inside the outline: the whole layer, or the channels of a lattice.

use crate::types::PointMm;

/// Straight channels of one width, parallel to x and to y.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// Width of every channel, mm.
    pub width_mm: f64,
    /// Centres of the channels that run along y, as x coordinates, mm, ascending.
    pub x_lines_mm: Vec<f64>,
    /// Centres of the channels that run along x, as y coordinates, mm, ascending.
    pub y_lines_mm: Vec<f64>,
}

/// The conductor's pattern.
#[derive(Clone, Debug, PartialEq)]
pub enum Conductor {
    /// The whole layer.
    Solid,
    /// Channels only.
    Lattice(Lattice),
}

impl Lattice {
    /// Evenly spaced lines, the outermost channels `margin_mm` inside the edges.
    #[must_use]
    pub fn even(
        [width, height]: [f64; 2],
        channel_mm: f64,
        [x_lines, y_lines]: [usize; 2],
        margin_mm: f64,
    ) -> Self {
        let spread = |length: f64, lines: usize| -> Vec<f64> {
            let first = margin_mm + channel_mm / 2.0;
            let step = (length - 2.0 * first) / (lines.max(2) - 1) as f64;
            (0..lines).map(|line| first + line as f64 * step).collect()
        };
        Self {
            width_mm: channel_mm,
            x_lines_mm: spread(width, x_lines),
            y_lines_mm: spread(height, y_lines),
        }
    }

    /// Both edges of every channel along one axis, ascending.
    pub fn edges_mm(&self, lines_mm: &[f64]) -> impl Iterator<Item = f64> {
        let half = self.width_mm / 2.0;
        lines_mm
            .iter()
            .flat_map(move |centre| [centre - half, centre + half])
    }

    /// Whether a point lies in a channel.
    #[must_use]
    pub fn contains(&self, [x, y]: PointMm) -> bool {
        // Tolerance for rounding: edges are computed by other sums than centres.
        let half = self.width_mm / 2.0 + 1e-9;
        let on = |lines: &[f64], at: f64| lines.iter().any(|centre| (at - centre).abs() <= half);
        on(&self.x_lines_mm, x) || on(&self.y_lines_mm, y)
    }
}

impl Conductor {
    /// Whether a point inside the outline holds conductor.
    #[must_use]
    pub fn contains(&self, point: PointMm) -> bool {
        match self {
            Self::Solid => true,
            Self::Lattice(lattice) => lattice.contains(point),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_lattice_is_flush_with_the_edge() {
        let lattice = Lattice::even([100.0, 100.0], 2.0, [11, 11], 0.0);
        assert_eq!(lattice.x_lines_mm.len(), 11);
        assert!((lattice.x_lines_mm[0] - 1.0).abs() < 1e-12);
        assert!((lattice.x_lines_mm[10] - 99.0).abs() < 1e-12);
        assert!(lattice.contains([0.0, 50.3]) && lattice.contains([37.0, 99.5]));
        assert!(!lattice.contains([6.0, 6.0]));
    }
}
