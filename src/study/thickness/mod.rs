//! The thickness study: whether the thickness of the conducting layer matters, for touches that deform it and for one that only
//! makes it conduct better.
//!
//! The paper (its thickness study, in three dimensions) says that thickness has little influence. Here a press deforms the whole
//! sensor (large deformation of nearly incompressible rubber), the deformed layer carries the currents, and the readings are
//! set against those at rest.

mod body;
mod foretell;
mod parameters;
mod press;
mod report;
mod sensor;

pub use foretell::Foretold;
pub use parameters::Parameters;
pub use press::under_indenter;
pub use sensor::{Placement, conductor};

use parameters::MOST_ON_TABLE;
use serde::{Deserialize, Serialize};

use super::StudyError;
use super::job::Study;
use super::report::Report;
use super::solid::{CurrentModel, ElasticError};
use crate::eit::MeshSize;
use crate::pad::{Outline, Pad};
use crate::types::PointMm;

/// Where the sensor is touched, as shares of its width and height: a crossing in the middle, a channel between crossings, a hole,
/// halfway to a corner, and near an edge. Our choice; the paper says five places.
const PLACES: [(&str, PointMm); 5] = [
    ("crossing in the middle", [0.5, 0.5]),
    ("channel", [0.451, 0.5]),
    ("hole", [0.549, 0.549]),
    ("halfway to a corner", [0.25, 0.25]),
    ("near an edge", [0.5, 0.1]),
];
/// Edges of the current's mesh as multiples of the images', in full and in quick studies.
const CURRENT_SCALE: (f64, f64) = (1.15, 3.0);
/// Bricks over the height of the conducting layer, for the current.
const CURRENT_LAYERS: (usize, usize) = (9, 3);
/// The meshes of the two extra cases that show what refinement does are so much finer.
const FINER: [f64; 2] = [0.7, 1.4];
/// What these press.
const REFINED: Touch = Touch::Foundation;
/// What is studied. Its text is the study's identity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Version of gelpad.
    pub version: String,
    /// The pad's name.
    pub pad: String,
    /// Its text.
    pub pad_toml: String,
    /// One coarse case of each kind.
    pub quick: bool,
    /// What is not in the paper.
    pub parameters: Parameters,
}

/// A kind of touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Touch {
    /// A local rise of conductivity, without deformation.
    Rise,
    /// Pressed, held at its edge.
    Edge,
    /// Pressed, on a soft foundation.
    Foundation,
    /// Pressed, on a rigid table.
    Table,
}

impl Touch {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Rise, Self::Edge, Self::Foundation, Self::Table];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Rise => "local rise",
            Self::Edge => "held at its edge",
            Self::Foundation => "on a soft foundation",
            Self::Table => "on a rigid table",
        }
    }
}

/// One job: a thickness, a place, a kind of touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// The conducting layer, mm.
    pub layer_mm: f64,
    /// Which of the five places.
    pub place: usize,
    /// What is done there.
    pub touch: Touch,
    /// How much finer than usual the meshes are: 1 but for the cases that show what refinement does.
    pub finer: f64,
}

/// What a touch did to the readings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pressed {
    /// How deep, mm; 0 for a local rise.
    pub depth_mm: f64,
    /// The same as a share of the sensor's thickness, if it was asked for so.
    pub share: Option<f64>,
    /// Force on the indenter, N.
    pub force_n: f64,
    /// Height of the layer under the middle of the touch, as a share of its height at rest.
    pub height_share: f64,
    /// Mean |dV|, V/A.
    pub change: f64,
    /// Mean |dV/V|.
    pub relative: f64,
    /// Mean dV/V: above zero where the layer conducts worse.
    pub signed: f64,
    /// Readings that rose and fell.
    pub rose_fell: [usize; 2],
}

/// What a case gave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Every touch, by depth.
    pub pressed: Vec<Pressed>,
    /// What was not done, and why.
    pub refused: Vec<String>,
    /// Nodes for mechanics (none for a rise) and for the current.
    pub nodes: [usize; 2],
    /// Mean |V| at rest, V/A.
    pub at_rest: f64,
}

/// A depth to press to.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Depth {
    mm: f64,
    share: Option<f64>,
}

/// A study that is checked.
#[derive(Clone, Debug)]
pub struct Thickness {
    settings: Settings,
    pad: Pad,
    cases: Vec<Case>,
}

impl Thickness {
    /// Checks settings before anything is solved.
    ///
    /// # Errors
    /// A pad that cannot be built or is round, or sizes that make no sensor.
    pub fn new(settings: Settings) -> Result<Self, StudyError> {
        let refuse = |reason: String| StudyError::Refused { reason };
        let pad = Pad::from_toml(&settings.pad, &settings.pad_toml)
            .map_err(|faulty| refuse(faulty.to_string()))?;
        if !matches!(pad.outline, Outline::Rectangle { .. }) {
            return Err(refuse(format!(
                "the pad {} is round: the thickness study takes rectangular pads",
                pad.name
            )));
        }
        settings.parameters.check().map_err(refuse)?;
        let all = &settings.parameters.layers_mm;
        let middle_mm = all[all.len() / 2];
        let case = |layer_mm, place, touch, finer| Case {
            layer_mm,
            place,
            touch,
            finer,
        };
        let (layers, places) = if settings.quick {
            (vec![middle_mm], 1)
        } else {
            (all.clone(), PLACES.len())
        };
        let mut cases: Vec<Case> = Vec::new();
        for layer_mm in layers {
            for place in 0..places {
                cases.extend(Touch::ALL.map(|touch| case(layer_mm, place, touch, 1.0)));
            }
        }
        if !settings.quick {
            cases.extend(FINER.map(|finer| case(middle_mm, 0, REFINED, finer)));
        }
        Ok(Self {
            settings,
            pad,
            cases,
        })
    }

    /// What is studied.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    fn centre_mm(&self, case: &Case) -> PointMm {
        let size = self.pad.outline.size_mm();
        [0, 1].map(|axis| PLACES[case.place].1[axis] * size[axis])
    }

    fn body(&self, case: &Case) -> body::Plan<'_> {
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

    fn current(&self, layer_mm: f64, finer: f64) -> Result<CurrentModel, StudyError> {
        let (scale, layers) = if self.settings.quick {
            (CURRENT_SCALE.1, CURRENT_LAYERS.1)
        } else {
            (CURRENT_SCALE.0, CURRENT_LAYERS.0)
        };
        let size = MeshSize::relative(&self.pad, scale / finer, false);
        let layers = (layers as f64 * finer).round() as usize;
        Ok(conductor(
            &self.pad,
            layer_mm,
            size,
            layers,
            Placement::Underside,
        )?)
    }

    /// Conductivities with the local rise, S/m.
    fn raised(&self, current: &CurrentModel, centre: PointMm) -> Vec<f64> {
        // A brick is raised by the share of it that lies within the radius, by 4 x 4 points of its plan.
        const SIDE: usize = 4;
        let parameters = &self.settings.parameters;
        let bricks = current.bricks();
        let inside = |cell: &[usize; 3]| {
            let at = |axis: usize, step: usize| {
                let lines = &bricks.lines().0[axis];
                let (low, high) = (lines[cell[axis]], lines[cell[axis] + 1]);
                low + (high - low) * (step as f64 + 0.5) / SIDE as f64
            };
            let points = (0..SIDE * SIDE).filter(|point| {
                let (x, y) = (at(0, point % SIDE), at(1, point / SIDE));
                libm::hypot(x - centre[0], y - centre[1]) < parameters.indenter_mm
            });
            points.count() as f64 / (SIDE * SIDE) as f64
        };
        let background = self.pad.background_s_per_m;
        bricks
            .cells
            .iter()
            .map(|cell| background + inside(cell) * (parameters.rise_s_per_m - background))
            .collect()
    }

    /// How deep a case presses, and what it refuses.
    fn depths(&self, case: &Case) -> (Vec<Depth>, Vec<String>) {
        let parameters = &self.settings.parameters;
        let total_mm = case.layer_mm + 2.0 * parameters.cover_mm;
        let mut depths: Vec<Depth> = parameters
            .depths_mm
            .iter()
            .map(|mm| Depth {
                mm: *mm,
                share: None,
            })
            .collect();
        let mut refused = Vec::new();
        if case.touch == Touch::Table {
            depths.retain(|depth| {
                let fits = depth.mm <= MOST_ON_TABLE * total_mm + 1e-9;
                if !fits {
                    refused.push(format!(
                        "{} mm into {total_mm} mm on a rigid table: it leaves room for {} mm ({} %)",
                        depth.mm,
                        MOST_ON_TABLE * total_mm,
                        100.0 * MOST_ON_TABLE
                    ));
                }
                fits
            });
            depths.extend(parameters.table_shares.iter().map(|share| Depth {
                mm: share * total_mm,
                share: Some(*share),
            }));
        }
        depths.sort_by(|a, b| a.mm.total_cmp(&b.mm));
        (depths, refused)
    }
}

impl Study for Thickness {
    type Case = Case;
    type Outcome = Outcome;

    fn cases(&self) -> &[Case] {
        &self.cases
    }

    fn id(case: &Case) -> String {
        let touch = case.touch.name().replace(' ', "-");
        let usual = format!("{}-mm-place-{}-{touch}", case.layer_mm, case.place + 1);
        if case.finer == 1.0 {
            usual
        } else {
            format!("{usual}-finer-{}", case.finer)
        }
    }

    fn solve(&self, case: &Case) -> Result<Outcome, StudyError> {
        let current = self.current(case.layer_mm, case.finer)?;
        let background = self.pad.background_s_per_m;
        let even = vec![background; current.bricks().corners.len()];
        let places = &current.bricks().nodes_mm;
        let rest = current.solve(places, &even)?.voltages(&self.pad.protocol);
        let mut outcome = Outcome {
            pressed: Vec::new(),
            refused: Vec::new(),
            nodes: [0, places.len()],
            at_rest: rest.iter().map(|volt| volt.abs()).sum::<f64>() / rest.len() as f64,
        };
        if case.touch == Touch::Rise {
            let touched = self.raised(&current, self.centre_mm(case));
            let volts = current
                .solve(places, &touched)?
                .voltages(&self.pad.protocol);
            let depth = Depth {
                mm: 0.0,
                share: None,
            };
            outcome
                .pressed
                .push(Pressed::between(&rest, &volts, depth, 0.0, 1.0));
            return Ok(outcome);
        }
        let plan = self.body(case);
        let (depths, refused) = self.depths(case);
        outcome.refused = refused;
        let Some(deepest) = depths.last() else {
            return Ok(outcome);
        };
        let mut pressing =
            body::Pressing::new(&plan, deepest.mm).map_err(|error| unsolvable(case, &error))?;
        outcome.nodes[0] = pressing.nodes();
        for depth in &depths {
            match pressing.press_to(depth.mm) {
                Ok(()) => {}
                // Rubber that folds beside the indenter has no one shape to converge to: what came before stands.
                Err(ElasticError::Diverged { reached }) => {
                    outcome.refused.push(format!(
                        "{} mm, {} mm layer, {}, {}: no equilibrium was found beyond {:.2} mm",
                        depth.mm,
                        case.layer_mm,
                        PLACES[case.place].0,
                        case.touch.name(),
                        reached * deepest.mm
                    ));
                    break;
                }
                Err(error) => return Err(unsolvable(case, &error)),
            }
            let moved = pressing.moved_layer(current.bricks());
            let volts = current
                .solve_stretched(&moved, |place| pressing.gradient_at(place), &even)?
                .voltages(&self.pad.protocol);
            let height = pressing.layer_height_mm() / case.layer_mm;
            let force_n = pressing.force_n();
            outcome
                .pressed
                .push(Pressed::between(&rest, &volts, *depth, force_n, height));
        }
        Ok(outcome)
    }

    fn report(&self, outcomes: &[Outcome]) -> Result<Report, StudyError> {
        self.told(outcomes)
    }
}

impl Pressed {
    fn between(
        rest: &[f64],
        touched: &[f64],
        depth: Depth,
        force_n: f64,
        height_share: f64,
    ) -> Self {
        let count = rest.len() as f64;
        let mean = |value: &dyn Fn(f64, f64) -> f64| {
            rest.iter()
                .zip(touched)
                .map(|(v, t)| value(*v, t - v))
                .sum::<f64>()
                / count
        };
        let rose = rest
            .iter()
            .zip(touched)
            .filter(|(v, t)| t.abs() > v.abs())
            .count();
        Self {
            depth_mm: depth.mm,
            share: depth.share,
            force_n,
            height_share,
            change: mean(&|_, dv| dv.abs()),
            relative: mean(&|v, dv| (dv / v).abs()),
            signed: mean(&|v, dv| dv / v),
            rose_fell: [rose, rest.len() - rose],
        }
    }
}

fn unsolvable(case: &Case, error: &ElasticError) -> StudyError {
    StudyError::Refused {
        reason: format!(
            "{} mm layer, {}, {}: {error}",
            case.layer_mm,
            PLACES[case.place].0,
            case.touch.name()
        ),
    }
}
