//! The width study: how the signal of a touch depends on the width of a lattice's channels.
//!
//! Reproduces the paper's figure (section "width study") and adds what a designer needs: the change at constant current, the
//! relative change, both in units of noise, their spread over random places (phantoms at crossings favour narrow channels),
//! and the Cramer-Rao bound of a touch's place.

mod figures;
mod report;
mod tables;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

use super::job::Study;
use super::report::Report;
use super::{ParameterSweep, Phantom, Press, StudyError, place_bound_mm};
use crate::eit::{ContactModel, ForwardModel, Mesh, MeshSize};
use crate::pad::{Conductor, Lattice, Pad};
use crate::stats::{mean, quantile, range, rms};
use crate::types::PointMm;

/// Radius of a touch, mm: our choice; the paper gives none.
const TOUCH_MM: f64 = 5.0;
/// Conductivity of the touched area, S/m: our choice; the paper says four levels.
const LEVELS: [f64; 4] = [2.0, 3.0, 4.0, 5.0];
/// Channel widths, mm, widest first: our choice; the paper says five.
const WIDTHS_MM: [f64; 5] = [5.0, 4.0, 3.0, 2.0, 1.0];
/// SNR for changes in units of noise, and for bounds, dB.
const SNR_DB: f64 = 60.0;
/// Random places of one touch, in full and in quick studies.
const PLACES: (usize, usize) = (50, 12);
/// Radius (mm) and rise of the press whose place is bounded: a fingertip.
const PRESS: (f64, f64) = (7.0, 1.2);
/// Places along each side of the grid for the bound, in full and in quick studies.
const BOUND_GRID: (usize, usize) = (4, 3);
/// Least distance of places from the edge, mm.
const MARGIN_MM: f64 = 10.0;
/// Longest edge of the study's mesh, mm.
const LONGEST_EDGE_MM: f64 = 0.5;

/// Settings of the study, stored in `study.json`. The same settings give the same files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WidthSettings {
    /// Version of gelpad.
    pub version: String,
    /// The base pad as named on the command line.
    pub pad: String,
    /// Its TOML text.
    pub pad_toml: String,
    /// A parameter to sweep instead of the channel width.
    pub vary: Option<ParameterSweep>,
    /// Criterion of the ranking.
    pub rank: RankCriterion,
    /// Fewer places.
    pub quick: bool,
    /// Seed of the random places.
    pub seed: u64,
}

/// Criterion by which variants are ranked, best first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RankCriterion {
    /// Greatest mean |dV| at constant current over random places.
    Change,
    /// Greatest mean |dV/V| over random places.
    Relative,
    /// Least Cramer-Rao bound of a touch's place, median over the pad.
    #[default]
    Bound,
}

/// One of the compared pads.
#[derive(Clone, Debug)]
pub struct Variant {
    /// Its name along the x axis.
    pub label: String,
    /// The pad.
    pub pad: Pad,
}

/// The results of one variant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WidthOutcome {
    /// The phantoms; for each, the levels.
    phantoms: Vec<Change>,
    /// One touch at each random place, at the highest level.
    places: Vec<Change>,
    /// Places, and the bound at each, mm.
    bounds: Vec<([f64; 2], f64)>,
}

/// The change of the voltages by a touch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Mean |dV| in 2-D units (a layer 1 m thick), V/A.
    pub absolute: f64,
    /// Mean |dV/V|.
    pub relative: f64,
    /// Root mean square of dV over noise proportional to each reading.
    pub over_proportional_noise: f64,
    /// Root mean square of dV over noise proportional to the largest reading.
    pub over_full_scale_noise: f64,
}

/// The study with valid settings: every pad can be built, and every touch lies on it.
#[derive(Clone, Debug)]
pub struct Width {
    settings: WidthSettings,
    variants: Vec<Variant>,
    places: Vec<PointMm>,
    bound_places: Vec<PointMm>,
}

impl Width {
    /// Validates the settings.
    ///
    /// # Errors
    /// A pad that is invalid, or a touch that reaches off a pad.
    pub fn new(settings: WidthSettings) -> Result<Self, StudyError> {
        let variants = variants(&settings)?;
        for variant in &variants {
            let mut misfits = Phantom::points(TOUCH_MM)
                .into_iter()
                .filter_map(|phantom| phantom.misfit(&variant.pad));
            if let Some(misfit) = misfits.next() {
                return Err(StudyError::refused(format!("{}: {misfit}", variant.label)));
            }
        }
        // All variants share the places, which lie on the smallest of them.
        let size = [0, 1].map(|axis| {
            let sizes = variants
                .iter()
                .map(|variant| variant.pad.outline.size_mm()[axis]);
            range(sizes)[0]
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

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &WidthSettings {
        &self.settings
    }
}

impl Study for Width {
    type Case = Variant;
    type Outcome = WidthOutcome;

    fn cases(&self) -> &[Variant] {
        &self.variants
    }

    fn id(variant: &Variant) -> String {
        variant.label.replace(' ', "-")
    }

    fn solve(&self, variant: &Variant) -> Result<WidthOutcome, StudyError> {
        let pad = &variant.pad;
        let contacts = ContactModel {
            thickness_m: 1.0,
            ..ContactModel::from_pad(pad)
        };
        let model = ForwardModel::new(Mesh::from_pad(pad, mesh_size(pad)), &contacts)?;
        let rest = volts(pad, &model, |_| false, pad.background_s_per_m)?;
        let change = |touch: &Phantom, level: f64| -> Result<Change, StudyError> {
            let touched = volts(pad, &model, |point| touch.contains(point), level)?;
            Ok(Change::between(&rest, &touched))
        };
        let by_level = Phantom::points(TOUCH_MM)
            .into_iter()
            .flat_map(|touch| LEVELS.map(|level| change(&touch, level)));
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
        Ok(WidthOutcome {
            phantoms: by_level.collect::<Result<_, StudyError>>()?,
            places: by_place.collect::<Result<_, StudyError>>()?,
            bounds: bounds.collect::<Result<_, StudyError>>()?,
        })
    }

    fn report(&self, outcomes: &[WidthOutcome]) -> Result<Report, StudyError> {
        self.build_report(outcomes)
    }
}

/// A mesh that resolves touches of 5 mm: refining it changes the figures of the phantoms by less than 3 %.
fn mesh_size(pad: &Pad) -> MeshSize {
    let size = MeshSize::relative(pad, 1.0, false);
    MeshSize {
        coarse_mm: size.coarse_mm.min(LONGEST_EDGE_MM),
        fine_mm: size.fine_mm.min(LONGEST_EDGE_MM),
        growth: 0.5,
        ..size
    }
}

/// The pads to compare: the values of a sweep, or the solid layer and lattices.
fn variants(settings: &WidthSettings) -> Result<Vec<Variant>, StudyError> {
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
    let base = super::parse_pad(&settings.pad, &settings.pad_toml)?;
    let Conductor::Lattice(lattice) = base.conductor.clone() else {
        return Err(StudyError::refused(format!(
            "the pad {} has no channels: choose a lattice, or --vary another parameter",
            base.name
        )));
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

/// The readings with the conductivity at a level (S/m) where the pad is touched: volts per ampere, in 2-D units.
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
        let [_, full_scale] = range(rest.iter().map(|volt| volt.abs()));
        let pairs = || rest.iter().zip(touched).map(|(v, t)| (v, t - v));
        // A reading that is 0 by symmetry has no relative change.
        let relative = || {
            let readings = pairs().filter(|(v, _)| **v != 0.0);
            readings.map(|(v, dv)| dv / v)
        };
        Self {
            absolute: mean(pairs().map(|(_, dv)| dv.abs())),
            relative: mean(relative().map(f64::abs)),
            over_proportional_noise: rms(relative().map(|change| change / noise)),
            over_full_scale_noise: rms(pairs().map(|(_, dv)| dv / full_scale / noise)),
        }
    }
}

impl WidthOutcome {
    fn phantom(&self, phantom: usize, level: usize) -> Change {
        self.phantoms[phantom * LEVELS.len() + level]
    }

    /// Mean over the three phantoms at one level.
    fn mean_of_phantoms(&self, level: usize, figure: impl Fn(&Change) -> f64) -> f64 {
        mean((0..3).map(|phantom| figure(&self.phantom(phantom, level))))
    }

    /// Mean, least and greatest over the random places.
    fn over_places(&self, figure: impl Fn(&Change) -> f64) -> [f64; 3] {
        let values = || self.places.iter().map(&figure);
        let [least, most] = range(values());
        [mean(values()), least, most]
    }

    /// Median, least and greatest bound, mm.
    fn bound_mm(&self) -> [f64; 3] {
        let bounds = || self.bounds.iter().map(|(_, bound)| *bound);
        let [least, most] = range(bounds());
        [quantile(bounds(), 0.5).unwrap_or(f64::NAN), least, most]
    }
}
