//! Rectangles: a graded tensor grid whose conducting cells are divided into two triangles each.

use super::size::MeshSize;
use super::spacing::{distinct, graded};
use super::triangles::Mesh;
use crate::pad::{Conductor, Pad};
use crate::types::PointMm;

/// Meshes a rectangular pad.
pub(super) fn mesh(pad: &Pad, size: MeshSize) -> Mesh {
    let [xs, ys] = lines_mm(pad, size, [&[], &[]]);
    let node = |i: usize, j: usize| j * xs.len() + i;
    let nodes: Vec<PointMm> = ys
        .iter()
        .flat_map(|y| xs.iter().map(move |x| [*x, *y]))
        .collect();
    let mut triangles = Vec::new();
    for j in 0..ys.len() - 1 {
        for i in 0..xs.len() - 1 {
            let centre = [0.5 * (xs[i] + xs[i + 1]), 0.5 * (ys[j] + ys[j + 1])];
            if !pad.conductor.contains(centre) {
                continue;
            }
            let [a, b, c, d] = [
                node(i, j),
                node(i + 1, j),
                node(i + 1, j + 1),
                node(i, j + 1),
            ];
            if ((i + j) % 2 == 0) != size.mirrored {
                triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    Mesh::assemble(pad, &nodes, &triangles)
}

/// Lines of the grid along x and y, mm, including the lines in `also`.
pub(super) fn lines_mm(pad: &Pad, size: MeshSize, also: [&[f64]; 2]) -> [Vec<f64>; 2] {
    [0, 1].map(|axis| coordinates(pad, size, axis, also[axis]))
}

fn coordinates(pad: &Pad, size: MeshSize, axis: usize, also: &[f64]) -> Vec<f64> {
    let length = pad.outline.size_mm()[axis];
    let mut electrode_ends = Vec::new();
    for electrode in &pad.electrodes {
        let ends = [electrode.start_mm, electrode.end_mm()].map(|s| pad.outline.point_at(s));
        // On a side along the other axis, both ends have the coordinate of the side.
        if (ends[0][axis] - ends[1][axis]).abs() > 1e-6 {
            electrode_ends.extend(ends.map(|point| point[axis]));
        }
    }
    let mut singular = electrode_ends;
    singular.extend(also);
    if let Conductor::Lattice(lattice) = &pad.conductor {
        let lines = [&lattice.x_lines_mm, &lattice.y_lines_mm][axis];
        singular.extend(lattice.edges_mm(lines).map(|edge| edge.clamp(0.0, length)));
    }
    let mut breaks = singular.clone();
    breaks.extend([0.0, length]);
    // The sides carry electrodes, so they are singular too.
    singular.extend([0.0, length]);
    graded(&distinct(breaks), &singular, size)
}
