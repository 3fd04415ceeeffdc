//! Derivatives of the readings by the unknowns of a pad.

use std::sync::OnceLock;

use faer::Mat;

use super::{RunJobs, Solved};
use crate::eit::jacobian::cell_jacobian;
use crate::eit::{ContactModel, Fields, ForwardError, ForwardModel, Mesh, MeshSize};
use crate::pad::{Electrode, ElectrodeDeviation, Pad};

/// Electrodes are moved and stretched by this much, mm, on a mesh with edges this many times as long as the reconstruction's: the
/// derivatives need few digits.
const STEP_MM: f64 = 0.2;
const COARSER: f64 = 1.8;

/// Channels x cells: change of a reading per relative change of a cell's conductance, V/A.
pub(super) fn of_cells(solved: &Solved, pad: &Pad, cells: usize) -> Mat<f64> {
    let conductivity = solved.model.mesh().background_s_per_m(pad);
    of_cells_with(&solved.model, &solved.fields, pad, &conductivity, cells)
}

/// The same with any conductivity of the triangles, S/m, and its fields.
pub(super) fn of_cells_with(
    model: &ForwardModel,
    fields: &Fields,
    pad: &Pad,
    conductivity: &[f64],
    cells: usize,
) -> Mat<f64> {
    let of_triangle: Vec<(usize, f64)> = conductivity
        .iter()
        .enumerate()
        .map(|(triangle, siemens)| {
            let cell = pad.deviations.cell_at(model.mesh().centroid_mm(triangle));
            (cell.unwrap_or(0), *siemens)
        })
        .collect();
    cell_jacobian(model, fields, &pad.protocol, &of_triangle, cells)
}

/// Channels x (shifts, stretches) of a pad's electrodes: relative change of a reading per mm. Zero for an electrode that has no room to
/// move. Each electrode is moved, and each stretched, in a job of its own.
pub(super) fn of_electrodes(pad: &Pad, run: &RunJobs<'_>) -> Result<Mat<f64>, ForwardError> {
    let count = pad.electrodes.len();
    let moves: Vec<Move> = moves(pad);
    let as_they_are = moves.len();
    let solved: Vec<OnceLock<Result<Vec<f64>, ForwardError>>> =
        (0..=moves.len()).map(|_| OnceLock::new()).collect();
    run(moves.len() + 1, &|job| {
        let mut electrodes = pad.electrodes.clone();
        if let Some(Move { index, moved, .. }) = moves.get(job) {
            electrodes[*index] = *moved;
        }
        let _ = solved[job].set(volts_with(pad, electrodes));
    });
    let mut solved = solved
        .into_iter()
        .map(|volts| volts.into_inner().expect("every job was run"))
        .collect::<Result<Vec<_>, _>>()?;
    let rest = solved.remove(as_they_are);
    let mut slopes = Mat::zeros(pad.channels(), 2 * count);
    for (Move { column, .. }, volts) in moves.iter().zip(&solved) {
        let slopes = slopes.col_mut(*column);
        for (slope, (volt, rest)) in slopes.iter_mut().zip(volts.iter().zip(&rest)) {
            // A reading that is 0 by symmetry has no relative change.
            *slope = if *rest == 0.0 {
                0.0
            } else {
                (volt - rest) / (rest * STEP_MM)
            };
        }
    }
    Ok(slopes)
}

/// An electrode that is moved or stretched.
struct Move {
    /// Column of its slopes.
    column: usize,
    index: usize,
    moved: Electrode,
}

/// A shift and a stretch of each electrode that has room for it.
fn moves(pad: &Pad) -> Vec<Move> {
    let shift = ElectrodeDeviation {
        shift_mm: STEP_MM,
        stretch_mm: 0.0,
    };
    let stretch = ElectrodeDeviation {
        shift_mm: 0.0,
        stretch_mm: STEP_MM,
    };
    let count = pad.electrodes.len();
    let moved = |way: usize, deviation: ElectrodeDeviation| {
        let electrodes = pad.electrodes.iter().enumerate();
        electrodes.map(move |(index, electrode)| Move {
            column: way * count + index,
            index,
            moved: deviation.applied_to(electrode),
        })
    };
    moved(0, shift)
        .chain(moved(1, stretch))
        .filter(|each| !bends(pad, &each.moved))
        .collect()
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
