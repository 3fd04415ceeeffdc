//! How a pad differs from its drawing, as written by `gelpad pad identify`.

use serde::Deserialize;
use toml::Spanned;

use crate::pad::{Deviations, ElectrodeDeviation, Pad};
use crate::types::Diagnostic;

/// Factors of the conductivity that a text may give: beyond, a channel is cut or bridged, which its drawing should show.
const FACTORS: std::ops::RangeInclusive<f64> = 0.001..=1000.0;
/// Most cells of a layer.
const MOST_CELLS: usize = 20_000;

/// The table `found`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FoundSpec {
    /// Sites (x, y, mm) and the factor of the conductivity around each.
    #[serde(default)]
    conductance: Vec<Spanned<[f64; 3]>>,
    /// How far each electrode is from its drawing, counter-clockwise along the edge, and how much longer it is, mm.
    shift_mm: Option<Spanned<Vec<f64>>>,
    stretch_mm: Option<Spanned<Vec<f64>>>,
}

/// The drawing with what was found.
pub(super) fn applied(spec: &FoundSpec, drawing: &Pad) -> Result<Pad, Diagnostic> {
    if let Some(beyond) = spec.conductance.get(MOST_CELLS) {
        let message = format!("`conductance` lists at most {MOST_CELLS} cells");
        return Err(Diagnostic::new(beyond.span(), message, "from here on"));
    }
    let cells = spec.conductance.iter().map(cell);
    let shifts = lengths(&spec.shift_mm, drawing)?;
    let stretches = lengths(&spec.stretch_mm, drawing)?;
    let deviations = shifts.into_iter().zip(stretches);
    let electrodes: Vec<ElectrodeDeviation> = deviations
        .map(|(shift_mm, stretch_mm)| ElectrodeDeviation {
            shift_mm,
            stretch_mm,
        })
        .collect();
    let has_moved = electrodes
        .iter()
        .any(|deviation| *deviation != ElectrodeDeviation::default());
    let pad = drawing.with_deviations(Deviations::new(
        cells.collect::<Result<_, _>>()?,
        if has_moved { electrodes } else { Vec::new() },
    ));
    match misplaced(&pad) {
        None => Ok(pad),
        Some(number) => {
            let span = spec
                .shift_mm
                .as_ref()
                .or(spec.stretch_mm.as_ref())
                .map_or(0..0, Spanned::span);
            let message =
                format!("electrode {number} would overlap its neighbour or bend round a corner");
            Err(Diagnostic::new(span, message, "here"))
        }
    }
}

fn cell(written: &Spanned<[f64; 3]>) -> Result<([f64; 2], f64), Diagnostic> {
    let [x, y, factor] = *written.get_ref();
    if x.is_finite() && y.is_finite() && FACTORS.contains(&factor) {
        return Ok(([x, y], factor));
    }
    let message =
        "`conductance` lists cells as [x mm, y mm, factor], with factors of 0.001 to 1000";
    Err(Diagnostic::new(written.span(), message, "here"))
}

/// A list with a length for each electrode, or zeros.
fn lengths(list: &Option<Spanned<Vec<f64>>>, pad: &Pad) -> Result<Vec<f64>, Diagnostic> {
    let count = pad.electrodes.len();
    match list {
        None => Ok(vec![0.0; count]),
        Some(list)
            if list.get_ref().len() == count && list.get_ref().iter().all(|l| l.is_finite()) =>
        {
            Ok(list.get_ref().clone())
        }
        Some(list) => Err(Diagnostic::new(
            list.span(),
            format!("one length for each of the {count} electrodes, in mm"),
            "here",
        )),
    }
}

/// The number, from 1, of an electrode that cannot be where it is said to be.
fn misplaced(pad: &Pad) -> Option<usize> {
    let perimeter = pad.outline.perimeter_mm();
    let corners = pad.outline.corners_mm();
    let is_misplaced = |index: &usize| {
        let own = pad.electrodes[*index];
        let bends = corners.iter().any(|corner| {
            let into = (corner - own.start_mm).rem_euclid(perimeter);
            into > 1e-9 && into < own.width_mm - 1e-9
        });
        let overlaps = pad.electrodes.iter().enumerate().any(|(other, electrode)| {
            other != *index
                && (electrode.start_mm - own.start_mm).rem_euclid(perimeter) < own.width_mm
        });
        own.width_mm <= 0.0 || bends || overlaps
    };
    (0..pad.electrodes.len())
        .find(is_misplaced)
        .map(|index| index + 1)
}
