//! Triangle meshes that follow outline, lattice and electrodes.
//!
//! Rectangles get a graded tensor grid (exact channels, no triangulation), circles a Delaunay triangulation of similarly
//! graded points. Every edge of a channel and of an electrode is an edge of the mesh.

mod grid;
mod round;
mod size;
mod spacing;
mod triangles;

use crate::pad::{Outline, Pad};
pub use size::MeshSize;
pub use triangles::Mesh;

impl Mesh {
    /// Meshes the conductor of a pad.
    #[must_use]
    pub fn from_pad(pad: &Pad, size: MeshSize) -> Self {
        match pad.outline {
            Outline::Rectangle { .. } => grid::mesh(pad, size),
            Outline::Circle { .. } => round::mesh(pad, size),
        }
    }

    /// The conductivity of each triangle of an untouched pad, S/m.
    #[must_use]
    pub fn background_s_per_m(&self, pad: &Pad) -> Vec<f64> {
        (0..self.triangles.len())
            .map(|triangle| pad.conductivity_at(self.centroid_mm(triangle)))
            .collect()
    }

    /// Lines along x and y of a rectangular pad's grid, mm, including the lines in `also`; `None` for round pads.
    #[must_use]
    pub fn grid_lines_mm(pad: &Pad, size: MeshSize, also: [&[f64]; 2]) -> Option<[Vec<f64>; 2]> {
        match pad.outline {
            Outline::Rectangle { .. } => Some(grid::lines_mm(pad, size, also)),
            Outline::Circle { .. } => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{SHIPPED_PADS, shipped_pad};

    fn pad(name: &str) -> Pad {
        Pad::from_toml(name, shipped_pad(name).expect("shipped").toml).expect("sound")
    }

    #[test]
    fn meshes_cover_exactly_the_conductor() {
        let areas = [
            ("edinburgh-lattice", 100.0 * 100.0 - 100.0 * 7.8 * 7.8),
            ("edinburgh-solid", 100.0 * 100.0),
            ("round-tank", std::f64::consts::PI * 1e4),
        ];
        for (name, area_mm2) in areas {
            let pad = pad(name);
            for size in [MeshSize::reconstruction(&pad), MeshSize::simulation(&pad)] {
                let mesh = Mesh::from_pad(&pad, size);
                let total: f64 = (0..mesh.triangles.len()).map(|t| mesh.area_mm2(t)).sum();
                assert!((total / area_mm2 - 1.0).abs() < 2e-3, "{name}: {total} mm2");
            }
        }
    }

    #[test]
    fn electrodes_are_covered_end_to_end() {
        for shipped in SHIPPED_PADS {
            let pad = pad(shipped.name);
            let mesh = Mesh::from_pad(&pad, MeshSize::reconstruction(&pad));
            for (edges, electrode) in mesh.electrodes.iter().zip(&pad.electrodes) {
                let length: f64 = edges
                    .iter()
                    .map(|[a, b]| {
                        let (a, b) = (mesh.nodes_mm[*a], mesh.nodes_mm[*b]);
                        libm::hypot(a[0] - b[0], a[1] - b[1])
                    })
                    .sum();
                assert!(
                    (length / electrode.width_mm - 1.0).abs() < 1e-3,
                    "{}",
                    shipped.name
                );
            }
        }
    }

    #[test]
    fn triangles_turn_counter_clockwise() {
        for name in ["edinburgh-lattice", "round-tank"] {
            let pad = pad(name);
            let mesh = Mesh::from_pad(&pad, MeshSize::simulation(&pad));
            for t in 0..mesh.triangles.len() {
                let [a, b, c] = mesh.corners_mm(t);
                let twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
                assert!(twice > 0.0, "{name}: triangle {t}");
            }
        }
    }
}
