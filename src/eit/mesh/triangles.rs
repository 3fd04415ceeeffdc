//! Linear triangles and their geometry.

use crate::pad::{Outline, Pad};
use crate::types::PointMm;

/// Linear triangles over the conductor, and the edges under each electrode.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Corners, mm.
    pub nodes_mm: Vec<PointMm>,
    /// Three nodes each, counter-clockwise.
    pub triangles: Vec<[usize; 3]>,
    /// For each electrode, the edges of the mesh under it.
    pub electrodes: Vec<Vec<[usize; 2]>>,
}

impl Mesh {
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

    /// Centroids of the four triangles into which the midpoints of the edges divide a triangle.
    #[must_use]
    pub fn quarter_points_mm(&self, triangle: usize) -> [PointMm; 4] {
        quarter_points(self.corners_mm(triangle))
    }

    /// The quarter points of the four quarters: one point per sixteenth of the area.
    #[must_use]
    pub fn sixteenth_points_mm(&self, triangle: usize) -> [PointMm; 16] {
        let [a, b, c] = self.corners_mm(triangle);
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        let quarters = [[ab, bc, ca], [a, ab, ca], [ab, b, bc], [ca, bc, c]].map(quarter_points);
        std::array::from_fn(|index| quarters[index / 4][index % 4])
    }

    /// The mean of a function over each triangle, sampled at its quarter points; where these differ, quarters are divided
    /// again.
    #[must_use]
    pub fn mean_over_triangles(&self, f: impl Fn(PointMm) -> f64) -> Vec<f64> {
        const DEPTH: usize = 3;
        (0..self.triangles.len())
            .map(|triangle| mean_over(self.corners_mm(triangle), &f, DEPTH))
            .collect()
    }

    /// Builds a mesh of the listed triangles and the nodes that they use; the edges of electrodes are those that belong to
    /// one triangle only.
    pub(super) fn assemble(pad: &Pad, nodes_mm: &[PointMm], triangles: &[[usize; 3]]) -> Self {
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
    // The quarter at a corner has its centroid half-way between the corner and the centroid.
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

/// The distance along the outline of the middle of an edge, if the edge lies on the outline.
fn along_outline(outline: &Outline, [a, b]: [PointMm; 2]) -> Option<f64> {
    let [x, y] = middle(a, b);
    match *outline {
        Outline::Rectangle { .. } => outline.distance_along([x, y]),
        Outline::Circle { radius_mm } => {
            // Both ends lie on the circle; the middle lies inside by the sagitta of the chord and is moved out.
            outline.distance_along(a)?;
            outline.distance_along(b)?;
            let (dx, dy) = (x - radius_mm, y - radius_mm);
            let stretch = radius_mm / libm::hypot(dx, dy);
            outline.distance_along([radius_mm + dx * stretch, radius_mm + dy * stretch])
        }
    }
}
