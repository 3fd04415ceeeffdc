//! Triangle meshes that follow outline, lattice and electrodes.
//!
//! Rectangles get a graded tensor grid (exact channels, no triangulation to run); circles a Delaunay
//! triangulation of the same kind of points. Every edge of a channel and of an electrode is an edge of
//! the mesh.

mod grid;
mod round;
mod spacing;

use crate::pad::{Outline, Pad};
use crate::types::PointMm;

/// Linear triangles over the conductor, and the electrodes as edges of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Corners, mm.
    pub nodes_mm: Vec<PointMm>,
    /// Three nodes each, counter-clockwise.
    pub triangles: Vec<[usize; 3]>,
    /// For each electrode, the edges of the mesh that it touches.
    pub electrodes: Vec<Vec<[usize; 2]>>,
}

/// How fine a mesh is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshSize {
    /// Longest edge along x and y away from electrodes and channel edges, mm.
    pub coarse_mm: f64,
    /// Edge at the ends of electrodes and channels, where the field is singular, mm.
    pub fine_mm: f64,
    /// Growth from fine to coarse: mm of edge a mm of distance.
    pub growth: f64,
    /// Turns every diagonal the other way: another mesh on the same grid.
    pub mirrored: bool,
}

impl MeshSize {
    /// The mesh that images are made with.
    #[must_use]
    pub fn reconstruction(pad: &Pad) -> Self {
        Self::relative(pad, 1.0, false)
    }

    /// The mesh of the simulated pad: finer, with other nodes and diagonals than the reconstruction's.
    #[must_use]
    pub fn simulation(pad: &Pad) -> Self {
        Self::relative(pad, 0.85, true)
    }

    /// A mesh whose edges are `scale` times as long as the reconstruction's.
    #[must_use]
    pub fn relative(pad: &Pad, scale: f64, mirrored: bool) -> Self {
        let feature_mm = pad
            .electrodes
            .iter()
            .map(|electrode| electrode.width_mm)
            .fold(f64::INFINITY, f64::min);
        let span_mm = pad.outline.size_mm().into_iter().fold(0.0, f64::max);
        let (coarse_mm, fine_mm) = match &pad.conductor {
            crate::pad::Conductor::Solid => (span_mm / 130.0, feature_mm / 6.0),
            crate::pad::Conductor::Lattice(lattice) => (
                lattice.width_mm / 3.0,
                lattice.width_mm.min(feature_mm) / 6.0,
            ),
        };
        Self {
            coarse_mm: coarse_mm * scale,
            fine_mm: (fine_mm * scale).min(coarse_mm * scale),
            growth: 0.4,
            mirrored,
        }
    }
}

impl Mesh {
    /// Meshes the conductor of a pad.
    #[must_use]
    pub fn of_pad(pad: &Pad, size: MeshSize) -> Self {
        match pad.outline {
            Outline::Rectangle { .. } => grid::mesh(pad, size),
            Outline::Circle { .. } => round::mesh(pad, size),
        }
    }

    /// Lines along x and y of the grid that a rectangular pad's mesh is made of, mm, with further lines that it must hold;
    /// nothing for round pads.
    #[must_use]
    pub fn grid_lines_mm(pad: &Pad, size: MeshSize, also: [&[f64]; 2]) -> Option<[Vec<f64>; 2]> {
        match pad.outline {
            Outline::Rectangle { .. } => Some(grid::lines_mm(pad, size, also)),
            Outline::Circle { .. } => None,
        }
    }

    /// Centre of gravity of a triangle, mm.
    #[must_use]
    pub fn centroid_mm(&self, triangle: usize) -> PointMm {
        let [a, b, c] = self.corners_mm(triangle);
        [(a[0] + b[0] + c[0]) / 3.0, (a[1] + b[1] + c[1]) / 3.0]
    }

    /// Corners of a triangle, mm.
    #[must_use]
    pub fn corners_mm(&self, triangle: usize) -> [PointMm; 3] {
        self.triangles[triangle].map(|node| self.nodes_mm[node])
    }

    /// Area of a triangle, mm2.
    #[must_use]
    pub fn area_mm2(&self, triangle: usize) -> f64 {
        let [a, b, c] = self.corners_mm(triangle);
        0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])).abs()
    }

    /// Centroids of the four triangles into which the midpoints of its edges cut a triangle: points
    /// that stand for a quarter of its area each.
    #[must_use]
    pub fn quarter_points_mm(&self, triangle: usize) -> [PointMm; 4] {
        quarter_points(self.corners_mm(triangle))
    }

    /// The quarter points of its four quarters: points that stand for a sixteenth of its area each.
    #[must_use]
    pub fn sixteenth_points_mm(&self, triangle: usize) -> [PointMm; 16] {
        let [a, b, c] = self.corners_mm(triangle);
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        let quarters = [[ab, bc, ca], [a, ab, ca], [ab, b, bc], [ca, bc, c]].map(quarter_points);
        std::array::from_fn(|index| quarters[index / 4][index % 4])
    }

    /// The mean of a function over each triangle, by its quarter points; where these disagree (the edge of a shape runs
    /// through), by quarters of quarters.
    #[must_use]
    pub fn mean_over_triangles(&self, f: impl Fn(PointMm) -> f64) -> Vec<f64> {
        const DEPTH: usize = 3;
        (0..self.triangles.len())
            .map(|triangle| mean_over(self.corners_mm(triangle), &f, DEPTH))
            .collect()
    }

    /// Keeps the listed triangles and the nodes that they use, and finds the electrodes' edges among
    /// the edges that belong to one triangle only.
    fn assemble(pad: &Pad, nodes_mm: &[PointMm], triangles: &[[usize; 3]]) -> Self {
        const UNUSED: usize = usize::MAX;
        let mut place = vec![UNUSED; nodes_mm.len()];
        let mut kept = Vec::new();
        let triangles: Vec<[usize; 3]> = triangles
            .iter()
            .map(|triangle| {
                triangle.map(|node| {
                    if place[node] == UNUSED {
                        place[node] = kept.len();
                        kept.push(nodes_mm[node]);
                    }
                    place[node]
                })
            })
            .collect();
        let mut mesh = Self {
            nodes_mm: kept,
            triangles,
            electrodes: vec![Vec::new(); pad.electrodes.len()],
        };
        for edge in mesh.boundary_edges() {
            let [a, b] = edge.map(|node| mesh.nodes_mm[node]);
            let Some(along) = along_outline(&pad.outline, [a, b]) else {
                continue;
            };
            let owner = pad
                .electrodes
                .iter()
                .position(|electrode| electrode.covers(&pad.outline, along));
            if let Some(owner) = owner {
                mesh.electrodes[owner].push(edge);
            }
        }
        mesh
    }

    /// Edges that belong to one triangle only, ascending.
    fn boundary_edges(&self) -> Vec<[usize; 2]> {
        let mut edges: Vec<[usize; 2]> = self
            .triangles
            .iter()
            .flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        edges
            .chunk_by(|a, b| a == b)
            .filter(|run| run.len() == 1)
            .map(|run| run[0])
            .collect()
    }
}

fn quarter_points(corners: [PointMm; 3]) -> [PointMm; 4] {
    let [a, b, c] = corners;
    let centre = [(a[0] + b[0] + c[0]) / 3.0, (a[1] + b[1] + c[1]) / 3.0];
    // A corner's quarter has its centroid half-way between the corner and the centroid.
    let towards = |corner: PointMm| middle(corner, centre);
    [centre, towards(a), towards(b), towards(c)]
}

fn middle(a: PointMm, b: PointMm) -> PointMm {
    [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
}

fn mean_over(corners: [PointMm; 3], f: &impl Fn(PointMm) -> f64, depth: usize) -> f64 {
    let values = quarter_points(corners).map(f);
    if depth == 0 || values.iter().all(|value| *value == values[0]) {
        return values.iter().sum::<f64>() / 4.0;
    }
    let [a, b, c] = corners;
    let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
    [[ab, bc, ca], [a, ab, ca], [ab, b, bc], [ca, bc, c]]
        .into_iter()
        .map(|quarter| mean_over(quarter, f, depth - 1))
        .sum::<f64>()
        / 4.0
}

/// The distance along the outline of the middle of an edge of the mesh, if it is an edge of the outline.
fn along_outline(outline: &Outline, [a, b]: [PointMm; 2]) -> Option<f64> {
    let [x, y] = middle(a, b);
    match *outline {
        Outline::Rectangle { .. } => outline.along([x, y]),
        Outline::Circle { radius_mm } => {
            // Both ends lie on the circle; the middle lies inside it by the chord's sagitta and is pushed out.
            outline.along(a)?;
            outline.along(b)?;
            let (dx, dy) = (x - radius_mm, y - radius_mm);
            let stretch = radius_mm / libm::hypot(dx, dy);
            outline.along([radius_mm + dx * stretch, radius_mm + dy * stretch])
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
    fn meshes_hold_the_conductor_and_nothing_else() {
        let areas = [
            ("edinburgh-lattice", 100.0 * 100.0 - 100.0 * 7.8 * 7.8),
            ("edinburgh-solid", 100.0 * 100.0),
            ("round-tank", std::f64::consts::PI * 1e4),
        ];
        for (name, area_mm2) in areas {
            let pad = pad(name);
            for size in [MeshSize::reconstruction(&pad), MeshSize::simulation(&pad)] {
                let mesh = Mesh::of_pad(&pad, size);
                let total: f64 = (0..mesh.triangles.len()).map(|t| mesh.area_mm2(t)).sum();
                assert!((total / area_mm2 - 1.0).abs() < 2e-3, "{name}: {total} mm2");
            }
        }
    }

    #[test]
    fn electrodes_are_covered_end_to_end() {
        for shipped in SHIPPED_PADS {
            let pad = pad(shipped.name);
            let mesh = Mesh::of_pad(&pad, MeshSize::reconstruction(&pad));
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
            let mesh = Mesh::of_pad(&pad, MeshSize::simulation(&pad));
            for t in 0..mesh.triangles.len() {
                let [a, b, c] = mesh.corners_mm(t);
                let twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
                assert!(twice > 0.0, "{name}: triangle {t}");
            }
        }
    }
}
