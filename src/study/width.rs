//! The width study: how the change of the boundary voltages depends on the width of a lattice's channels.
//!
//! The paper's figure (section "width study") and what a designer needs beyond it: the absolute change at constant current,
//! the relative change, both in units of noise, their spread over random places (phantoms at crossings flatter narrow
//! channels), and the Cramer-Rao bound of a touch's place.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

use super::figure::{Chart, Series, short};
use super::report::{Report, Table};
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

    /// The pads to compare, in order: one job each.
    #[must_use]
    pub fn cases(&self) -> &[Variant] {
        &self.variants
    }

    /// The name under which a job's result is kept.
    #[must_use]
    pub fn id(variant: &Variant) -> String {
        variant.label.replace(' ', "-")
    }

    /// Solves one job.
    ///
    /// # Errors
    /// A pad that cannot be solved.
    pub fn solve(&self, variant: &Variant) -> Result<Outcome, StudyError> {
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

/// Mean, least and greatest.
fn spread(values: impl Iterator<Item = f64> + Clone) -> [f64; 3] {
    let count = values.clone().count() as f64;
    [
        values.clone().sum::<f64>() / count,
        values.clone().fold(f64::INFINITY, f64::min),
        values.fold(f64::NEG_INFINITY, f64::max),
    ]
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

impl Outcome {
    fn phantom(&self, touches: usize, level: usize) -> Change {
        self.phantoms[touches * LEVELS.len() + level]
    }

    /// Mean over the three phantoms at the highest level: REFERENCE section 1.
    fn at_the_top(&self, figure: impl Fn(&Change) -> f64) -> f64 {
        (0..3)
            .map(|touches| figure(&self.phantom(touches, LEVELS.len() - 1)))
            .sum::<f64>()
            / 3.0
    }

    fn bound_mm(&self) -> f64 {
        median(self.bounds.iter().map(|(_, bound)| *bound).collect())
    }
}

impl Width {
    /// The report of all jobs' results, in the order of [`Self::cases`].
    ///
    /// # Errors
    /// Figures that cannot be drawn.
    pub fn report(&self, found: &[Outcome]) -> Result<Report, StudyError> {
        let x_label = match &self.settings.vary {
            Some(vary) => vary.path.clone(),
            None => "width of the channels".to_owned(),
        };
        let places: Vec<String> = self
            .variants
            .iter()
            .map(|variant| variant.label.clone())
            .collect();
        let chart = |name: &str, title: &str, y_label: &str, series: Vec<Series>| {
            Chart {
                name: name.to_owned(),
                title: title.to_owned(),
                x_label: x_label.clone(),
                y_label: y_label.to_owned(),
                places: places.clone(),
                series,
            }
            .draw()
        };
        let by_touches = |figure: &dyn Fn(&Change) -> f64| -> Vec<Series> {
            phantoms()
                .iter()
                .enumerate()
                .map(|(touches, phantom)| Series {
                    name: phantom.name.to_owned(),
                    points: found
                        .iter()
                        .map(|one| [figure(&one.phantom(touches, LEVELS.len() - 1)); 3])
                        .collect(),
                })
                .collect()
        };
        let by_level = |figure: &dyn Fn(&Change) -> f64| -> Vec<Series> {
            LEVELS
                .iter()
                .enumerate()
                .map(|(level, s_per_m)| Series {
                    name: format!("{s_per_m} S/m"),
                    points: found
                        .iter()
                        .map(|one| {
                            [(0..3)
                                .map(|touches| figure(&one.phantom(touches, level)))
                                .sum::<f64>()
                                / 3.0; 3]
                        })
                        .collect(),
                })
                .collect()
        };
        let over_places = |figure: &dyn Fn(&Change) -> f64| {
            vec![Series {
                name: format!("{} places", self.places.len()),
                points: found
                    .iter()
                    .map(|one| spread(one.places.iter().map(figure)))
                    .collect(),
            }]
        };
        let percent = |change: &Change| 100.0 * change.relative;
        let milli = |change: &Change| 1e3 * change.absolute;
        let figures = vec![
            chart(
                "change",
                "Change at constant current, 5 S/m",
                "mean |dV|, mV/A (2-D)",
                by_touches(&milli),
            )?,
            chart(
                "relative",
                "Relative change, 5 S/m",
                "mean |dV/V|, %",
                by_touches(&percent),
            )?,
            chart(
                "levels",
                "Relative change by level, mean of the phantoms",
                "mean |dV/V|, %",
                by_level(&percent),
            )?,
            chart(
                "levels-change",
                "Change by level, mean of the phantoms",
                "mean |dV|, mV/A (2-D)",
                by_level(&milli),
            )?,
            chart(
                "places",
                "Relative change over random places: mean, least, greatest",
                "mean |dV/V|, %",
                over_places(&percent),
            )?,
            chart(
                "places-change",
                "Change over random places: mean, least, greatest",
                "mean |dV|, mV/A (2-D)",
                over_places(&milli),
            )?,
            chart(
                "noise",
                "The change in units of noise (60 dB), over random places",
                "root mean square of dV / noise",
                vec![
                    Series {
                        name: "noise of a reading".to_owned(),
                        points: found
                            .iter()
                            .map(|one| spread(one.places.iter().map(|c| c.over_proportional_noise)))
                            .collect(),
                    },
                    Series {
                        name: "of full scale".to_owned(),
                        points: found
                            .iter()
                            .map(|one| spread(one.places.iter().map(|c| c.over_full_scale_noise)))
                            .collect(),
                    },
                ],
            )?,
            chart(
                "bound",
                "Cramer-Rao bound of a touch's place (60 dB): median, least, greatest",
                "mm",
                vec![Series {
                    name: format!("{} places", self.bound_places.len()),
                    points: found
                        .iter()
                        .map(|one| {
                            let [_, least, most] =
                                spread(one.bounds.iter().map(|(_, bound)| *bound));
                            [one.bound_mm(), least, most]
                        })
                        .collect(),
                }],
            )?,
        ];
        Ok(Report {
            title: "Width study: which channels to build".to_owned(),
            command: self.command(),
            version: self.settings.version.clone(),
            seed: self.settings.seed,
            paragraphs: self.claims(found),
            tables: vec![self.summary(found, &x_label)],
            csvs: self.csvs(found),
            figures,
        })
    }

    /// The command that makes these files, wherever they are.
    fn command(&self) -> String {
        let settings = &self.settings;
        let mut command = format!(
            "gelpad study width --pad {} --seed {}",
            settings.pad, settings.seed
        );
        if let Some(vary) = &settings.vary {
            command.push_str(&format!(" --vary {vary}"));
        }
        if settings.rank != Rank::default() {
            command.push_str(match settings.rank {
                Rank::Change => " --rank change",
                Rank::Relative => " --rank relative",
                Rank::Bound => " --rank bound",
            });
        }
        if settings.quick {
            command.push_str(" --quick");
        }
        command
    }

    /// What the figures say of the paper's claims.
    fn claims(&self, found: &[Outcome]) -> Vec<String> {
        let mut said = vec![
            "Two-dimensional complete electrode model. The paper gives neither the number of lattice lines, nor the \
             conductivity levels, nor the size and places of its touches: 11 x 11 lines (the pad's text), levels of 2, 3, 4, 5 S/m \
             over 1 S/m, discs of 5 mm radius at (50, 50), (30, 50) + (70, 50) and (30, 30) + (70, 30) + (50, 70) mm are our choices. \
             |dV| is per ampere for a layer one metre thick: divide by the layer's thickness in metres for real volts."
                .to_owned(),
        ];
        let rises = found.iter().all(|one| {
            (0..3).all(|touches| {
                (1..LEVELS.len()).all(|level| {
                    one.phantom(touches, level).relative > one.phantom(touches, level - 1).relative
                })
            })
        });
        said.push(format!(
            "Paper's claim \"the change grows with the touched conductivity\": {} (figures levels, levels-change).",
            holds(rises)
        ));
        if self.settings.vary.is_some() {
            return said;
        }
        let absolute: Vec<f64> = found
            .iter()
            .map(|one| one.at_the_top(|change| change.absolute))
            .collect();
        let relative: Vec<f64> = found
            .iter()
            .map(|one| one.at_the_top(|change| change.relative))
            .collect();
        let grows = |values: &[f64]| values.windows(2).all(|pair| pair[1] > pair[0]);
        let list = |values: &[f64], unit: f64| {
            values
                .iter()
                .map(|v| short(v * unit))
                .collect::<Vec<_>>()
                .join(", ")
        };
        said.push(format!(
            "Paper's claims \"the lattice gives more voltage variation than the solid\" and \"narrower channels give more\": for |dV| at \
             constant current they {} ({} mV/A from solid to 1 mm, figure change); for the relative change |dV/V| they {} ({} %, figure relative).",
            hold(grows(&absolute)),
            list(&absolute, 1e3),
            hold(grows(&relative)),
            list(&relative, 100.0),
        ));
        let mean_places = |figure: &dyn Fn(&Change) -> f64| -> Vec<f64> {
            found
                .iter()
                .map(|one| spread(one.places.iter().map(figure))[0])
                .collect()
        };
        let placed = mean_places(&|change| change.absolute);
        let bounds: Vec<f64> = found.iter().map(Outcome::bound_mm).collect();
        said.push(format!(
            "Beyond the paper: phantoms at crossings of lines flatter narrow channels. Over {} random places the mean |dV| is {} mV/A \
             (figures places, places-change). What a touch's place can be known to at 60 dB (Cramer-Rao bound, a press of 7 mm radius \
             whose size and strength are unknown, median over the pad) is {} mm (figure bound): that, not |dV|, is what a player feels.",
            self.places.len(),
            list(&placed, 1e3),
            list(&bounds, 1.0),
        ));
        said
    }

    fn summary(&self, found: &[Outcome], x_label: &str) -> Table {
        let key = |index: &usize| -> f64 {
            let one = &found[*index];
            match self.settings.rank {
                Rank::Change => -spread(one.places.iter().map(|c| c.absolute))[0],
                Rank::Relative => -spread(one.places.iter().map(|c| c.relative))[0],
                Rank::Bound => one.bound_mm(),
            }
        };
        let mut order: Vec<usize> = (0..found.len()).collect();
        order.sort_by(|a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
        let by = match self.settings.rank {
            Rank::Change => "mean |dV| over random places",
            Rank::Relative => "mean |dV/V| over random places",
            Rank::Bound => "the bound of a touch's place",
        };
        Table {
            title: format!("Best first, by {by}"),
            head: [
                x_label,
                "mean |dV|, mV/A (phantoms)",
                "mean |dV/V|, % (phantoms)",
                "mean |dV|, mV/A (places)",
                "mean |dV/V|, % (places)",
                "dV / noise (places)",
                "bound of place, mm (median)",
            ]
            .map(str::to_owned)
            .to_vec(),
            rows: order
                .into_iter()
                .map(|index| {
                    let one = &found[index];
                    let mean =
                        |figure: &dyn Fn(&Change) -> f64| spread(one.places.iter().map(figure))[0];
                    vec![
                        self.variants[index].label.clone(),
                        short(1e3 * one.at_the_top(|c| c.absolute)),
                        short(100.0 * one.at_the_top(|c| c.relative)),
                        short(1e3 * mean(&|c| c.absolute)),
                        short(100.0 * mean(&|c| c.relative)),
                        short(mean(&|c| c.over_proportional_noise)),
                        short(one.bound_mm()),
                    ]
                })
                .collect(),
        }
    }

    fn csvs(&self, found: &[Outcome]) -> Vec<Table> {
        let figures = |change: &Change| {
            [
                change.absolute,
                change.relative,
                change.over_proportional_noise,
                change.over_full_scale_noise,
            ]
            .map(|value| value.to_string())
        };
        let columns = [
            "mean_abs_dv_v_per_a_2d",
            "mean_abs_dv_over_v",
            "rms_dv_over_noise_60db",
            "rms_dv_over_full_scale_noise_60db",
        ];
        let head = |first: &[&str]| -> Vec<String> {
            first
                .iter()
                .chain(&columns)
                .map(|name| (*name).to_owned())
                .collect()
        };
        let mut phantom_rows = Vec::new();
        let mut place_rows = Vec::new();
        let mut bound_rows = Vec::new();
        for (variant, one) in self.variants.iter().zip(found) {
            for (touches, phantom) in phantoms().iter().enumerate() {
                for (level, s_per_m) in LEVELS.iter().enumerate() {
                    let mut row = vec![
                        variant.label.clone(),
                        phantom.name.to_owned(),
                        s_per_m.to_string(),
                    ];
                    row.extend(figures(&one.phantom(touches, level)));
                    phantom_rows.push(row);
                }
            }
            for (place, change) in self.places.iter().zip(&one.places) {
                let mut row = vec![
                    variant.label.clone(),
                    place[0].to_string(),
                    place[1].to_string(),
                ];
                row.extend(figures(change));
                place_rows.push(row);
            }
            for (place, bound) in &one.bounds {
                bound_rows.push(vec![
                    variant.label.clone(),
                    place[0].to_string(),
                    place[1].to_string(),
                    bound.to_string(),
                ]);
            }
        }
        vec![
            Table {
                title: "phantoms".to_owned(),
                head: head(&["variant", "phantom", "level_s_per_m"]),
                rows: phantom_rows,
            },
            Table {
                title: "places".to_owned(),
                head: head(&["variant", "x_mm", "y_mm"]),
                rows: place_rows,
            },
            Table {
                title: "bound".to_owned(),
                head: ["variant", "x_mm", "y_mm", "bound_mm"]
                    .map(str::to_owned)
                    .to_vec(),
                rows: bound_rows,
            },
        ]
    }
}

fn holds(does: bool) -> &'static str {
    if does { "holds" } else { "does NOT hold" }
}

fn hold(do_they: bool) -> &'static str {
    if do_they { "hold" } else { "do NOT hold" }
}
