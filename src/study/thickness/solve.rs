//! Solves one case: the currents at rest, the touch, and the currents under it.

use super::parameters::MOST_ON_TABLE;
use super::{
    Case, PLACES, Placement, Thickness, ThicknessOutcome, Touch, TouchResult, body, conductor,
};
use crate::eit::MeshSize;
use crate::stats::mean;
use crate::study::StudyError;
use crate::study::solid::{CurrentModel, ElasticError};
use crate::types::PointMm;

/// Edges of the mesh of the current as multiples of those of images, in full and in quick studies.
const CURRENT_SCALE: (f64, f64) = (1.15, 3.0);
/// Bricks over the height of the conducting layer, for the current, in full and in quick studies.
const CURRENT_LAYERS: (usize, usize) = (9, 3);
/// Points along each side by which a brick's share of the local rise is counted.
const SHARE_POINTS: usize = 4;

/// Depth of a press.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Depth {
    mm: f64,
    /// As a share of the sensor's thickness, if it was set as a share.
    share: Option<f64>,
}

impl Thickness {
    pub(super) fn solve_case(&self, case: &Case) -> Result<ThicknessOutcome, StudyError> {
        let current = self.current(case.layer_mm, case.finer)?;
        let places = &current.bricks().nodes_mm;
        let even = vec![self.pad.background_s_per_m; current.bricks().corners.len()];
        let rest = current.solve(places, &even)?.voltages(&self.pad.protocol);
        let mut outcome = ThicknessOutcome {
            pressed: Vec::new(),
            refused: Vec::new(),
            nodes: [0, places.len()],
            at_rest: mean(rest.iter().map(|volt| volt.abs())),
        };
        if case.touch == Touch::Rise {
            let raised = self.raised(&current, self.centre_mm(case));
            let volts = current.solve(places, &raised)?.voltages(&self.pad.protocol);
            let depth = Depth {
                mm: 0.0,
                share: None,
            };
            let result = TouchResult::between(&rest, &volts, depth, 0.0, 1.0);
            outcome.pressed.push(result);
        } else {
            self.press(case, &current, &rest, &mut outcome)?;
        }
        Ok(outcome)
    }

    /// Presses to each depth in turn.
    fn press(
        &self,
        case: &Case,
        current: &CurrentModel,
        rest: &[f64],
        outcome: &mut ThicknessOutcome,
    ) -> Result<(), StudyError> {
        let (depths, refused) = self.depths(case);
        outcome.refused = refused;
        let Some(deepest) = depths.last() else {
            return Ok(());
        };
        let unsolvable = |error: ElasticError| unsolvable(case, &error);
        let mut pressing = body::Pressing::new(&self.body(case), deepest.mm).map_err(unsolvable)?;
        outcome.nodes[0] = pressing.nodes();
        let even = vec![self.pad.background_s_per_m; current.bricks().corners.len()];
        for depth in &depths {
            match pressing.press_to(depth.mm) {
                Ok(()) => {}
                // Rubber that folds beside the indenter may have no equilibrium: smaller depths stay valid.
                Err(ElasticError::Diverged { reached }) => {
                    outcome.refused.push(format!(
                        "{} mm, {} mm layer, {}, {}: no equilibrium was found beyond {:.2} mm",
                        depth.mm,
                        case.layer_mm,
                        case.place_name(),
                        case.touch.name(),
                        reached * deepest.mm
                    ));
                    break;
                }
                Err(error) => return Err(unsolvable(error)),
            }
            let moved = pressing.moved_layer(current.bricks());
            let volts = current
                .solve_stretched(&moved, |place| pressing.gradient_at(place), &even)?
                .voltages(&self.pad.protocol);
            let height = pressing.layer_height_mm() / case.layer_mm;
            let force_n = pressing.force_n();
            let result = TouchResult::between(rest, &volts, *depth, force_n, height);
            outcome.pressed.push(result);
        }
        Ok(())
    }

    fn centre_mm(&self, case: &Case) -> PointMm {
        let size = self.pad.outline.size_mm();
        [0, 1].map(|axis| PLACES[case.place].1[axis] * size[axis])
    }

    pub(super) fn body(&self, case: &Case) -> body::Plan<'_> {
        body::Plan {
            pad: &self.pad,
            parameters: &self.settings.parameters,
            layer_mm: case.layer_mm,
            centre_mm: self.centre_mm(case),
            touch: case.touch,
            quick: self.settings.quick,
            finer: case.finer,
        }
    }

    pub(super) fn current(&self, layer_mm: f64, finer: f64) -> Result<CurrentModel, StudyError> {
        let (scale, layers) = if self.settings.quick {
            (CURRENT_SCALE.1, CURRENT_LAYERS.1)
        } else {
            (CURRENT_SCALE.0, CURRENT_LAYERS.0)
        };
        let size = MeshSize::relative(&self.pad, scale / finer, false);
        let layers = (layers as f64 * finer).round() as usize;
        let placement = Placement::Underside;
        Ok(conductor(&self.pad, layer_mm, size, layers, placement)?)
    }

    /// Conductivity of each brick with the local rise, S/m. A brick is raised by its share within the radius.
    fn raised(&self, current: &CurrentModel, [x, y]: PointMm) -> Vec<f64> {
        let parameters = &self.settings.parameters;
        let is_inside = |[a, b]: PointMm| libm::hypot(a - x, b - y) < parameters.indenter_mm;
        let background = self.pad.background_s_per_m;
        let bricks = current.bricks();
        let share =
            |cell: &[usize; 3]| bricks.lines().share_of_plan(*cell, SHARE_POINTS, is_inside);
        let cells = bricks.cells.iter();
        cells
            .map(|cell| background + share(cell) * (parameters.rise_s_per_m - background))
            .collect()
    }

    /// Depths of a case, ascending, and those that it refuses, with the reason.
    pub(super) fn depths(&self, case: &Case) -> (Vec<Depth>, Vec<String>) {
        let parameters = &self.settings.parameters;
        let total_mm = case.layer_mm + 2.0 * parameters.cover_mm;
        let most_mm = MOST_ON_TABLE * total_mm;
        let on_table = case.touch == Touch::Table;
        let (fitting, refused): (Vec<f64>, Vec<f64>) = parameters
            .depths_mm
            .iter()
            .partition(|mm| !on_table || **mm <= most_mm + 1e-9);
        let refused = refused.into_iter().map(|mm| {
            format!(
                "{mm} mm into {total_mm} mm on a rigid table: it leaves room for {most_mm} mm ({} %)",
                100.0 * MOST_ON_TABLE
            )
        });
        let absolute = fitting.into_iter().map(|mm| Depth { mm, share: None });
        let shares = parameters.table_shares.iter().filter(|_| on_table);
        let relative = shares.map(|share| Depth {
            mm: share * total_mm,
            share: Some(*share),
        });
        let mut depths: Vec<Depth> = absolute.chain(relative).collect();
        depths.sort_by(|a, b| a.mm.total_cmp(&b.mm));
        (depths, refused.collect())
    }
}

impl TouchResult {
    fn between(
        rest: &[f64],
        touched: &[f64],
        depth: Depth,
        force_n: f64,
        height_share: f64,
    ) -> Self {
        let pairs = || rest.iter().zip(touched);
        let rose = pairs().filter(|(v, t)| t.abs() > v.abs()).count();
        let fell = pairs().filter(|(v, t)| t.abs() < v.abs()).count();
        // A reading that is 0 by symmetry has no relative change.
        let relative = || {
            let readings = pairs().filter(|(v, _)| **v != 0.0);
            readings.map(|(v, t)| (t - v) / v)
        };
        Self {
            depth_mm: depth.mm,
            share: depth.share,
            force_n,
            height_share,
            change: mean(pairs().map(|(v, t)| (t - v).abs())),
            relative: mean(relative().map(f64::abs)),
            signed: mean(relative()),
            rose_fell: [rose, fell],
        }
    }
}

pub(super) fn unsolvable(case: &Case, error: &ElasticError) -> StudyError {
    StudyError::refused(format!(
        "{} mm layer, {}, {}: {error}",
        case.layer_mm,
        case.place_name(),
        case.touch.name()
    ))
}
