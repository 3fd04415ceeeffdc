//! What the width study tells: its figures, tables, and what they say of the paper's claims.

use super::{Change, LEVELS, Outcome, Rank, Width, phantoms};
use crate::study::StudyError;
use crate::study::figure::{Chart, Series, short};
use crate::study::report::{Report, Table};

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
    /// The report of all jobs' results, in the order of the cases.
    pub(super) fn told(&self, found: &[Outcome]) -> Result<Report, StudyError> {
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
                ..Chart::default()
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
                    ..Series::default()
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
                    ..Series::default()
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
                ..Series::default()
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
                        ..Series::default()
                    },
                    Series {
                        name: "of full scale".to_owned(),
                        points: found
                            .iter()
                            .map(|one| spread(one.places.iter().map(|c| c.over_full_scale_noise)))
                            .collect(),
                        ..Series::default()
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
                    ..Series::default()
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
