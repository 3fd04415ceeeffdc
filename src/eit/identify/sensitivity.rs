//! Derivatives of the readings by the unknowns of a pad.

use faer::Mat;

use super::Solved;
use crate::eit::jacobian::cell_jacobian;
use crate::eit::{ContactModel, ForwardError, ForwardModel, Mesh, MeshSize};
use crate::pad::{Electrode, ElectrodeDeviation, Pad};

/// Electrodes are moved and stretched by this much, mm, on a mesh with edges this many times as long as the reconstruction's: the
/// derivatives need few digits.
const STEP_MM: f64 = 0.2;
const COARSER: f64 = 1.8;

/// Channels x cells: change of a reading per relative change of a cell's conductance, V/A.
pub(super) fn of_cells(solved: &Solved, pad: &Pad, cells: usize) -> Mat<f64> {
    let mesh = solved.model.mesh();
    let of_triangle: Vec<(usize, f64)> = mesh
        .background_s_per_m(pad)
        .into_iter()
        .enumerate()
        .map(|(triangle, siemens)| {
            let cell = pad.deviations.cell_at(mesh.centroid_mm(triangle));
            (cell.unwrap_or(0), siemens)
        })
        .collect();
    cell_jacobian(
        &solved.model,
        &solved.fields,
        &pad.protocol,
        &of_triangle,
        cells,
    )
}

/// Channels x (shifts, stretches) of a pad's electrodes: relative change of a reading per mm. Zero for an electrode that has no room to
/// move.
pub(super) fn of_electrodes(pad: &Pad) -> Result<Mat<f64>, ForwardError> {
    let count = pad.electrodes.len();
    let rest = volts_with(pad, pad.electrodes.clone())?;
    let mut slopes = Mat::zeros(pad.channels(), 2 * count);
    for (index, electrode) in pad.electrodes.iter().enumerate() {
        let ways = [
            ElectrodeDeviation {
                shift_mm: STEP_MM,
                stretch_mm: 0.0,
            },
            ElectrodeDeviation {
                shift_mm: 0.0,
                stretch_mm: STEP_MM,
            },
        ];
        for (way, deviation) in ways.into_iter().enumerate() {
            let moved = deviation.applied_to(electrode);
            if bends(pad, &moved) {
                continue;
            }
            let mut electrodes = pad.electrodes.clone();
            electrodes[index] = moved;
            let volts = volts_with(pad, electrodes)?;
            let column = slopes.col_mut(way * count + index);
            for (slope, (volt, rest)) in column.iter_mut().zip(volts.iter().zip(&rest)) {
                // A reading that is 0 by symmetry has no relative change.
                *slope = if *rest == 0.0 {
                    0.0
                } else {
                    (volt - rest) / (rest * STEP_MM)
                };
            }
        }
    }
    Ok(slopes)
}

/// Whether an electrode would bend round a corner.
fn bends(pad: &Pad, electrode: &Electrode) -> bool {
    let perimeter = pad.outline.perimeter_mm();
    pad.outline.corners_mm().into_iter().any(|corner| {
        let into = (corner - electrode.start_mm).rem_euclid(perimeter);
        into > 0.0 && into < electrode.width_mm
    })
}

fn volts_with(pad: &Pad, electrodes: Vec<Electrode>) -> Result<Vec<f64>, ForwardError> {
    let pad = Pad {
        electrodes,
        ..pad.clone()
    };
    let mesh = Mesh::from_pad(&pad, MeshSize::relative(&pad, COARSER, false));
    let model = ForwardModel::new(mesh, &ContactModel::from_pad(&pad))?;
    let fields = model.solve(&model.mesh().background_s_per_m(&pad))?;
    Ok(fields.voltages(&pad.protocol))
}
