//! The width study: how the change of the boundary voltages depends on the width of a lattice's channels.
//!
//! The paper's figure (section "width study") and what a designer needs beyond it: the absolute change at constant current,
//! the relative change, both in units of noise, their spread over random places (phantoms at crossings flatter narrow
//! channels), and the Cramer-Rao bound of a touch's place.

mod report;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

use super::job::Study;
use super::report::Report;
use super::{Phantom, Press, StudyError, Vary, place_bound_mm};
use crate::eit::{ContactModel, ForwardModel, Mesh, MeshSize};
use crate::pad::{Conductor, Lattice, Pad};
use crate::types::PointMm;

/// Radius of a touch, mm: our choice; the paper gives none.
const TOUCH_MM: f64 = 5.0;
/// Conductivity of the touched area, S/m: our choice; the paper says four levels.
const LEVELS: [f64; 4] = [2.0, 3.0, 4.0, 5.0];
/// Channel widths, mm, widest first: our choice; the paper says five.
const WIDTHS_MM: [f64; 5] = [5.0, 4.0, 3.0, 2.0, 1.0];
/// Noise against which changes and bounds are measured, dB.
const SNR_DB: f64 = 60.0;
/// Random places of one touch, in full and in quick studies.
const PLACES: (usize, usize) = (50, 12);
/// The press whose place is bounded: a fingertip's.
const PRESS: (f64, f64) = (7.0, 1.2);
/// Places a side of the grid over which the bound is taken, in full and in quick studies.
const BOUND_GRID: (usize, usize) = (4, 3);
/// Places keep this distance from the edge, mm.
const MARGIN_MM: f64 = 10.0;
/// Longest edge of the study's mesh, mm.
const LONGEST_EDGE_MM: f64 = 0.5;

/// What is studied. Its text is the study's identity: the same settings give the same files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Version of gelpad.
    pub version: String,
    /// The base pad's name and text.
    pub pad: String,
    /// Its text.
    pub pad_toml: String,
    /// A parameter that is swept instead of the channel width.
    pub vary: Option<Vary>,
    /// What variants are ranked by.
    pub rank: Rank,
    /// Fewer places.
    pub quick: bool,
    /// Seed of the random places.
    pub seed: u64,
}

/// What variants are ranked by, best first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rank {
    /// Mean |dV| at constant current over random places.
    Change,
    /// Mean |dV/V| over random places.
    Relative,
    /// Cramer-Rao bound of a touch's place, median over the pad.
    #[default]
    Bound,
}

/// A pad of the comparison.
#[derive(Clone, Debug)]
pub struct Variant {
    /// Its name along the x axis.
    pub label: String,
    /// The pad.
    pub pad: Pad,
}

/// What one variant gave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Touches by levels, in that order.
    phantoms: Vec<Change>,
    /// One touch at each random place.
    places: Vec<Change>,
    /// Places and bounds, mm.
    bounds: Vec<([f64; 2], f64)>,
}

/// How the voltages change.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Mean |dV| per ampere in 2-D units (a layer 1 m thick), V/A.
    pub absolute: f64,
    /// Mean |dV/V|.
    pub relative: f64,
    /// Root mean square of dV over noise in proportion to each reading.
    pub over_proportional_noise: f64,
    /// Root mean square of dV over noise in proportion to the largest reading.
    pub over_full_scale_noise: f64,
}

/// The phantoms: one, two and three points, at REFERENCE's places.
fn phantoms() -> [Phantom; 3] {
    [
        Phantom::discs("one point", &[[50.0, 50.0]], TOUCH_MM),
        Phantom::discs("two points", &[[30.0, 50.0], [70.0, 50.0]], TOUCH_MM),
        Phantom::discs(
            "three points",
            &[[30.0, 30.0], [70.0, 30.0], [50.0, 70.0]],
            TOUCH_MM,
        ),
    ]
}

/// A study that is checked: every pad can be built and every touch lies on it.
#[derive(Clone, Debug)]
pub struct Width {
    settings: Settings,
    variants: Vec<Variant>,
    places: Vec<PointMm>,
    bound_places: Vec<PointMm>,
}

impl Width {
    /// Checks settings before anything is solved.
    ///
    /// # Errors
    /// A pad that cannot be built, or a touch off a pad, with the reason.
    pub fn new(settings: Settings) -> Result<Self, StudyError> {
        let variants = variants(&settings)?;
        for variant in &variants {
            if let Some(misfit) = phantoms()
                .iter()
                .find_map(|phantom| phantom.misfit(&variant.pad))
            {
                return Err(StudyError::Refused {
                    reason: format!("{}: {misfit}", variant.label),
                });
            }
        }
        // The places that all variants share lie on the smallest of them.
        let size = variants.iter().fold([f64::INFINITY; 2], |least, variant| {
            let size = variant.pad.outline.size_mm();
            [least[0].min(size[0]), least[1].min(size[1])]
        });
        let everywhere = |place: &PointMm| variants.iter().all(|v| v.pad.outline.contains(*place));
        let (places, grid) = if settings.quick {
            (PLACES.1, BOUND_GRID.1)
        } else {
            (PLACES.0, BOUND_GRID.0)
        };
        let mut random = ChaCha8Rng::seed_from_u64(settings.seed);
        let places = std::iter::repeat_with(|| {
            std::array::from_fn(|axis| {
                let share = (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
                MARGIN_MM + share * (size[axis] - 2.0 * MARGIN_MM)
            })
        })
        .filter(everywhere)
        .take(places)
        .collect();
        let step = |axis: usize, i: usize| {
            MARGIN_MM + (size[axis] - 2.0 * MARGIN_MM) * (i as f64 + 0.5) / grid as f64
        };
        let bound_places = (0..grid * grid)
            .map(|i| [step(0, i % grid), step(1, i / grid)])
            .filter(everywhere)
            .collect();
        Ok(Self {
            settings,
            variants,
            places,
            bound_places,
        })
    }

    /// What is studied.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }
}

impl Study for Width {
    type Case = Variant;
    type Outcome = Outcome;

    fn cases(&self) -> &[Variant] {
        &self.variants
    }

    fn id(variant: &Variant) -> String {
        variant.label.replace(' ', "-")
    }

    fn solve(&self, variant: &Variant) -> Result<Outcome, StudyError> {
        let pad = &variant.pad;
        let contacts = ContactModel {
            thickness_m: 1.0,
            ..ContactModel::of_pad(pad)
        };
        let model = ForwardModel::new(Mesh::of_pad(pad, mesh_size(pad)), &contacts)?;
        let rest = volts(pad, &model, |_| false, pad.background_s_per_m)?;
        let change = |touch: &Phantom, level: f64| -> Result<Change, StudyError> {
            let touched = volts(pad, &model, |point| touch.contains(point), level)?;
            Ok(Change::between(&rest, &touched))
        };
        let phantoms = phantoms();
        let by_level = phantoms
            .iter()
            .flat_map(|touch| LEVELS.map(|level| change(touch, level)));
        let by_place = self.places.iter().map(|place| {
            let touch = Phantom::discs("one point", &[*place], TOUCH_MM);
            change(&touch, LEVELS[LEVELS.len() - 1])
        });
        let bounds = self.bound_places.iter().map(|place| {
            let press = Press {
                centre_mm: *place,
                radius_mm: PRESS.0,
                rise: PRESS.1,
            };
            Ok((*place, place_bound_mm(pad, &model, &press, SNR_DB)?))
        });
        Ok(Outcome {
            phantoms: by_level.collect::<Result<_, StudyError>>()?,
            places: by_place.collect::<Result<_, StudyError>>()?,
            bounds: bounds.collect::<Result<_, StudyError>>()?,
        })
    }

    fn report(&self, outcomes: &[Outcome]) -> Result<Report, StudyError> {
        self.told(outcomes)
    }
}

/// A mesh on which touches of 5 mm are resolved: the figures of the phantoms change by less than 3 % when it is refined.
fn mesh_size(pad: &Pad) -> MeshSize {
    let size = MeshSize::relative(pad, 1.0, false);
    MeshSize {
        coarse_mm: size.coarse_mm.min(LONGEST_EDGE_MM),
        fine_mm: size.fine_mm.min(LONGEST_EDGE_MM),
        growth: 0.5,
        ..size
    }
}

fn variants(settings: &Settings) -> Result<Vec<Variant>, StudyError> {
    if let Some(vary) = &settings.vary {
        return vary
            .values()
            .into_iter()
            .map(|value| {
                Ok(Variant {
                    label: format!("{value}"),
                    pad: vary.pad(&settings.pad, &settings.pad_toml, value)?,
                })
            })
            .collect();
    }
    let base = Pad::from_toml(&settings.pad, &settings.pad_toml).map_err(|faulty| {
        StudyError::Refused {
            reason: faulty.to_string(),
        }
    })?;
    let Conductor::Lattice(lattice) = base.conductor.clone() else {
        return Err(StudyError::Refused {
            reason: format!(
                "the pad {} has no channels whose width could be studied: choose a lattice, or --vary another parameter",
                base.name
            ),
        });
    };
    let lines = [lattice.x_lines_mm.len(), lattice.y_lines_mm.len()];
    let solid = Variant {
        label: "solid".to_owned(),
        pad: Pad {
            conductor: Conductor::Solid,
            ..base.clone()
        },
    };
    let margin_mm = lattice.x_lines_mm[0] - lattice.width_mm / 2.0;
    let lattices = WIDTHS_MM.into_iter().map(|width_mm| Variant {
        label: format!("{width_mm} mm"),
        pad: Pad {
            conductor: Conductor::Lattice(Lattice::even(
                base.outline.size_mm(),
                width_mm,
                lines,
                margin_mm,
            )),
            ..base.clone()
        },
    });
    Ok(std::iter::once(solid).chain(lattices).collect())
}

/// The voltages, V/A in 2-D units, with a level of conductivity where a shape is.
fn volts(
    pad: &Pad,
    model: &ForwardModel,
    touched: impl Fn(PointMm) -> bool,
    level: f64,
) -> Result<Vec<f64>, StudyError> {
    let conductivity = model.mesh().mean_over_triangles(|point| {
        if touched(point) {
            level
        } else {
            pad.background_s_per_m
        }
    });
    Ok(model.solve(&conductivity)?.voltages(&pad.protocol))
}

impl Change {
    fn between(rest: &[f64], touched: &[f64]) -> Self {
        let noise = 10f64.powf(-SNR_DB / 20.0);
        let full_scale = rest.iter().fold(0.0_f64, |most, volt| most.max(volt.abs()));
        let count = rest.len() as f64;
        let over = |value: &dyn Fn(f64, f64) -> f64| {
            rest.iter()
                .zip(touched)
                .map(|(v, t)| value(*v, t - v))
                .sum::<f64>()
        };
        Self {
            absolute: over(&|_, dv| dv.abs()) / count,
            relative: over(&|v, dv| (dv / v).abs()) / count,
            over_proportional_noise: (over(&|v, dv| (dv / v / noise).powi(2)) / count).sqrt(),
            over_full_scale_noise: (over(&|_, dv| (dv / full_scale / noise).powi(2)) / count)
                .sqrt(),
        }
    }
}
