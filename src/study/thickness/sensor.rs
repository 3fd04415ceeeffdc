//! The conducting layer in three dimensions, extruded from the plane, with its electrodes.

use super::super::solid::{Bricks, Contact, CurrentModel, Lines};
use crate::eit::{ForwardError, Mesh, MeshSize};
use crate::pad::{Electrode, Pad};
use crate::types::PointMm;

/// Depth of an electrode on the underside, from the edge inwards, mm: each touches 3 x 3 mm of the layer (the paper).
const ELECTRODE_DEPTH_MM: f64 = 3.0;
/// Points closer than this coincide, mm.
const CLOSE_MM: f64 = 1e-6;

/// Position of the electrodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// On the underside of the layer, as in the paper.
    Underside,
    /// On the side faces of the layer over its whole height, as in two dimensions.
    Side,
}

/// The conducting layer with its electrodes, from z = 0 up, with `layers` bricks over its height.
///
/// # Errors
/// A pad that is not rectangular, an electrode that touches nothing, or more bricks than fit into memory.
pub fn conductor(
    pad: &Pad,
    layer_mm: f64,
    size: MeshSize,
    layers: usize,
    placement: Placement,
) -> Result<CurrentModel, ForwardError> {
    let pads_mm = pad.outline.size_mm();
    let inner = match placement {
        Placement::Underside => {
            pads_mm.map(|length| vec![ELECTRODE_DEPTH_MM, length - ELECTRODE_DEPTH_MM])
        }
        Placement::Side => [vec![], vec![]],
    };
    let [x, y] = Mesh::grid_lines_mm(pad, size, [&inner[0], &inner[1]])
        .ok_or(ForwardError::BareElectrode(0))?;
    let z = (0..=layers)
        .map(|line| layer_mm * line as f64 / layers as f64)
        .collect();
    let lines = Lines([x, y, z]);
    let bricks = Bricks::new(lines.clone(), |cell| {
        let [x, y, _] = lines.middle_mm(cell);
        pad.conductor.contains([x, y])
    });
    let contacts = pad
        .electrodes
        .iter()
        .map(|electrode| Contact {
            faces: match placement {
                Placement::Underside => underside(&bricks, pad, electrode),
                Placement::Side => side(&bricks, pad, electrode),
            },
            impedance_ohm_m2: pad.contact_impedance_ohm_m2,
        })
        .collect();
    CurrentModel::new(bricks, contacts)
}

/// Lower faces of the lowest bricks under an electrode.
fn underside(bricks: &Bricks, pad: &Pad, electrode: &Electrode) -> Vec<[usize; 4]> {
    let size = pad.outline.size_mm();
    let ends = [electrode.start_mm, electrode.end_mm()].map(|at| pad.outline.point_at(at));
    // Along its side of the pad between its ends, across it from the edge inwards.
    let bounds: [[f64; 2]; 2] = [0, 1].map(|axis| {
        let (a, b) = (ends[0][axis], ends[1][axis]);
        if (a - b).abs() > CLOSE_MM {
            [a.min(b), a.max(b)]
        } else if a < size[axis] / 2.0 {
            [0.0, ELECTRODE_DEPTH_MM]
        } else {
            [size[axis] - ELECTRODE_DEPTH_MM, size[axis]]
        }
    });
    let covers = |point: PointMm| {
        (0..2).all(|axis| point[axis] > bounds[axis][0] && point[axis] < bounds[axis][1])
    };
    bricks
        .cells
        .iter()
        .zip(&bricks.corners)
        .filter(|(cell, _)| {
            let [x, y, _] = bricks.lines().middle_mm(**cell);
            cell[2] == 0 && covers([x, y])
        })
        .map(|(_, corners)| [0, 1, 3, 2].map(|corner| corners[corner] as usize))
        .collect()
}

/// Outer faces of the bricks along an electrode.
fn side(bricks: &Bricks, pad: &Pad, electrode: &Electrode) -> Vec<[usize; 4]> {
    // Corners of a brick's four side faces.
    const FACES: [[usize; 4]; 4] = [[0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let mut found = Vec::new();
    for corners in &bricks.corners {
        for face in FACES {
            let nodes = face.map(|corner| corners[corner] as usize);
            let [a, b] = [nodes[0], nodes[1]].map(|node| bricks.nodes_mm[node]);
            let middle = [f64::midpoint(a[0], b[0]), f64::midpoint(a[1], b[1])];
            let on_edge = pad.outline.distance_along(middle);
            if on_edge.is_some_and(|along| electrode.covers(&pad.outline, along)) {
                found.push(nodes);
            }
        }
    }
    found
}
