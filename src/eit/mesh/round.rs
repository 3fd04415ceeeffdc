//! Circles: a graded grid of points inside and graded points on the edge, triangulated by Delaunay.

use spade::{DelaunayTriangulation, Point2, Triangulation};

use super::size::MeshSize;
use super::spacing::{distinct, graded};
use super::triangles::Mesh;
use crate::pad::{Conductor, Lattice, Outline, Pad};
use crate::types::PointMm;

/// Meshes a round pad.
pub(super) fn mesh(pad: &Pad, size: MeshSize) -> Mesh {
    let mut points = rim(pad, size);
    points.extend(inside(pad, size));
    let delaunay = DelaunayTriangulation::<Point2<f64>>::bulk_load_stable(
        points.iter().map(|[x, y]| Point2::new(*x, *y)).collect(),
    )
    .expect("the points are finite");
    let nodes: Vec<PointMm> = delaunay
        .vertices()
        .map(|vertex| [vertex.position().x, vertex.position().y])
        .collect();
    let triangles: Vec<[usize; 3]> = delaunay
        .inner_faces()
        .filter_map(|face| {
            let corners = face.vertices().map(|vertex| vertex.fix().index());
            let [a, b, c] = corners.map(|node| nodes[node]);
            let centre = [(a[0] + b[0] + c[0]) / 3.0, (a[1] + b[1] + c[1]) / 3.0];
            pad.conductor.contains(centre).then_some(corners)
        })
        .collect();
    Mesh::assemble(pad, &nodes, &triangles)
}

/// Points on the circle: ends of electrodes and channels, graded between them.
fn rim(pad: &Pad, size: MeshSize) -> Vec<PointMm> {
    let perimeter = pad.outline.perimeter_mm();
    let mut ends: Vec<f64> = pad
        .electrodes
        .iter()
        .flat_map(|electrode| [electrode.start_mm, electrode.end_mm()])
        .map(|along| along.rem_euclid(perimeter))
        .collect();
    if let Conductor::Lattice(lattice) = &pad.conductor {
        ends.extend(channel_ends(lattice, &pad.outline));
    }
    let ends = distinct(ends);
    let mut breaks = ends.clone();
    breaks.push(ends[0] + perimeter);
    let mut along = graded(&breaks, &breaks, size);
    along.pop();
    along.into_iter().map(|s| pad.outline.point_at(s)).collect()
}

/// Where the edges of the channels meet the circle, as distances along it.
fn channel_ends(lattice: &Lattice, outline: &Outline) -> Vec<f64> {
    let r = outline.size_mm()[0] / 2.0;
    let chord = |at: f64| libm::sqrt((r * r - (at - r) * (at - r)).max(0.0));
    let inside = |at: &f64| (at - r).abs() < r;
    let vertical = lattice
        .edges_mm(&lattice.x_lines_mm)
        .filter(inside)
        .flat_map(|x| [[x, r - chord(x)], [x, r + chord(x)]]);
    let horizontal = lattice
        .edges_mm(&lattice.y_lines_mm)
        .filter(inside)
        .flat_map(|y| [[r - chord(y), y], [r + chord(y), y]]);
    vertical
        .chain(horizontal)
        .filter_map(|point| outline.distance_along(point))
        .collect()
}

/// Points of a graded grid that lie on conductor, away from the rim.
fn inside(pad: &Pad, size: MeshSize) -> Vec<PointMm> {
    let diameter = pad.outline.size_mm()[0];
    let r = diameter / 2.0;
    let (xs, ys) = match &pad.conductor {
        Conductor::Lattice(lattice) => {
            let lines = |centres: &[f64]| {
                let edges: Vec<f64> = lattice.edges_mm(centres).collect();
                let edges = distinct(edges);
                graded(&edges, &edges, size)
            };
            (lines(&lattice.x_lines_mm), lines(&lattice.y_lines_mm))
        }
        Conductor::Solid => {
            let even = graded(&[0.0, diameter], &[], size);
            (even.clone(), even)
        }
    };
    // The mirrored mesh is shifted, so that the two share no node.
    let shift = match (&pad.conductor, size.mirrored) {
        (Conductor::Solid, true) => size.coarse_mm / 3.0,
        _ => 0.0,
    };
    let mut points = Vec::new();
    for y in &ys {
        for x in &xs {
            let point = [x + shift, y + shift];
            let depth = r - libm::hypot(point[0] - r, point[1] - r);
            if depth > 0.6 * size.coarse_mm && pad.conductor.contains(point) {
                points.push(point);
            }
        }
    }
    points
}
