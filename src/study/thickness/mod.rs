//! The thickness study: whether the thickness of the conducting layer matters, for presses that deform the layer and for a
//! local rise of its conductivity.
//!
//! The paper (its thickness study, in three dimensions) says that thickness has little influence. Here a press deforms the
//! whole sensor (large deformation of nearly incompressible rubber), the current flows through the deformed layer, and the
//! readings are compared with those at rest.

mod body;
mod estimate;
mod group;
mod parameters;
mod press;
mod report;
mod sensor;
mod solve;
mod tables;

pub use estimate::ResourceEstimate;
pub use parameters::ThicknessParameters;
pub use press::under_indenter;
pub use sensor::{Placement, conductor};

use serde::{Deserialize, Serialize};

use super::StudyError;
use super::job::Study;
use super::report::Report;
use crate::pad::{Outline, Pad};
use crate::types::PointMm;

/// Places of the touches, as shares of the sensor's width and height. Our choice; the paper says five places.
const PLACES: [(&str, PointMm); 5] = [
    ("crossing in the middle", [0.5, 0.5]),
    ("channel", [0.451, 0.5]),
    ("hole", [0.549, 0.549]),
    ("halfway to a corner", [0.25, 0.25]),
    ("near an edge", [0.5, 0.1]),
];
/// Factors by which the meshes of the two extra cases are finer; they show the effect of refinement.
const FINER: [f64; 2] = [0.7, 1.4];
/// The touch of these cases.
const REFINED: Touch = Touch::Foundation;

/// Settings of the study; stored in `study.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ThicknessSettings {
    /// Version of gelpad.
    pub version: String,
    /// The pad as named on the command line.
    pub pad: String,
    /// Its TOML text.
    pub pad_toml: String,
    /// One coarse case of each kind.
    pub quick: bool,
    /// Sizes and materials that the paper does not give.
    pub parameters: ThicknessParameters,
}

/// A kind of touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Touch {
    /// A local rise of conductivity, without deformation.
    Rise,
    /// A press on a sensor held at its edge.
    Edge,
    /// A press on a sensor on a soft foundation.
    Foundation,
    /// A press on a sensor on a rigid table.
    Table,
}

impl Touch {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Rise, Self::Edge, Self::Foundation, Self::Table];

    /// Its name in reports.
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

/// One case: a thickness, a place and a kind of touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// Thickness of the conducting layer, mm.
    pub layer_mm: f64,
    /// Index of the place.
    pub place: usize,
    /// Kind of touch.
    pub touch: Touch,
    /// Factor by which the meshes are finer: 1 except for the cases that show the effect of refinement.
    pub finer: f64,
}

impl Case {
    /// Name of the place.
    fn place_name(&self) -> &'static str {
        PLACES[self.place].0
    }
}

/// The effect of a touch on the readings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TouchResult {
    /// Depth of the press, mm; 0 for a local rise.
    pub depth_mm: f64,
    /// Depth as a share of the sensor's thickness, if it was set as a share.
    pub share: Option<f64>,
    /// Force on the indenter, N.
    pub force_n: f64,
    /// Height of the layer under the centre of the touch, as a share of its height at rest.
    pub height_share: f64,
    /// Mean |dV|, V/A.
    pub change: f64,
    /// Mean |dV/V|.
    pub relative: f64,
    /// Mean dV/V: positive where the layer conducts worse.
    pub signed: f64,
    /// Number of readings that rose, and that fell.
    pub rose_fell: [usize; 2],
}

/// The results of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ThicknessOutcome {
    /// Every touch, by depth.
    pub pressed: Vec<TouchResult>,
    /// Presses that are impossible or found no equilibrium, with the reason.
    pub refused: Vec<String>,
    /// Nodes for mechanics (0 for a local rise) and for the current.
    pub nodes: [usize; 2],
    /// Mean |V| at rest, V/A.
    pub at_rest: f64,
}

/// The study with valid settings.
#[derive(Clone, Debug)]
pub struct Thickness {
    settings: ThicknessSettings,
    pad: Pad,
    cases: Vec<Case>,
}

impl Thickness {
    /// Validates the settings.
    ///
    /// # Errors
    /// A pad that is invalid or round, or sizes that make no sensor.
    pub fn new(settings: ThicknessSettings) -> Result<Self, StudyError> {
        let pad = super::parse_pad(&settings.pad, &settings.pad_toml)?;
        if !matches!(pad.outline, Outline::Rectangle { .. }) {
            return Err(StudyError::refused(format!(
                "the pad {} is round: the thickness study needs a rectangular pad",
                pad.name
            )));
        }
        settings.parameters.check().map_err(StudyError::refused)?;
        Ok(Self {
            cases: cases(&settings),
            settings,
            pad,
        })
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &ThicknessSettings {
        &self.settings
    }
}

fn cases(settings: &ThicknessSettings) -> Vec<Case> {
    let all = &settings.parameters.layers_mm;
    let middle_mm = all[all.len() / 2];
    let case = |layer_mm, place, touch, finer| Case {
        layer_mm,
        place,
        touch,
        finer,
    };
    let layer = |layer_mm: f64, places: usize| {
        (0..places).flat_map(move |place| Touch::ALL.map(|touch| case(layer_mm, place, touch, 1.0)))
    };
    if settings.quick {
        return layer(middle_mm, 1).collect();
    }
    let refined = FINER.map(|finer| case(middle_mm, 0, REFINED, finer));
    let layers = all
        .iter()
        .flat_map(|layer_mm| layer(*layer_mm, PLACES.len()));
    layers.chain(refined).collect()
}

impl Study for Thickness {
    type Case = Case;
    type Outcome = ThicknessOutcome;

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

    fn solve(&self, case: &Case) -> Result<ThicknessOutcome, StudyError> {
        self.solve_case(case)
    }

    fn report(&self, outcomes: &[ThicknessOutcome]) -> Result<Report, StudyError> {
        self.build_report(outcomes)
    }
}
