//! What the study tells: tables for people, every number as CSV and JSON.

use std::fmt::Write as _;

use super::{Accuracy, Findings, Share, Spread};
use crate::study::StudyError;
use crate::study::figure::short;
use crate::study::report::{Report, Table};

/// A share for people: percent, and the ends of its interval.
fn percent(share: &Share) -> String {
    format!(
        "{} % ({}-{})",
        short(100.0 * share.share),
        (100.0 * share.low).round(),
        (100.0 * share.high).round()
    )
}

/// A share without a count, for people.
fn hundredths(share: f64) -> String {
    if share.is_finite() {
        format!("{} %", short(100.0 * share))
    } else {
        "-".to_owned()
    }
}

/// A number as CSV has it: empty where there is none.
fn cell(value: f64) -> String {
    if value.is_finite() {
        value.to_string()
    } else {
        String::new()
    }
}

fn head(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

fn share_cells(share: &Share) -> [String; 4] {
    [
        share.hits.to_string(),
        share.n.to_string(),
        cell(share.low),
        cell(share.high),
    ]
}

fn spread_cells(spread: &Spread) -> [String; 5] {
    [
        spread.n.to_string(),
        cell(spread.mean),
        cell(spread.median),
        cell(spread.p95),
        cell(spread.rms),
    ]
}

impl Findings {
    /// All of it as JSON.
    ///
    /// # Errors
    /// A defect of gelpad.
    pub fn json(&self) -> Result<String, StudyError> {
        let mut text = serde_json::to_string_pretty(self)
            .map_err(|error| StudyError::Internal(error.to_string()))?;
        text.push('\n');
        Ok(text)
    }

    /// The tables for a terminal.
    #[must_use]
    pub fn summary(&self) -> String {
        let mut text = String::new();
        for table in self.tables() {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{}", table.title);
            let width = |column: usize| {
                let cells = table.rows.iter().chain([&table.head]);
                cells
                    .map(|row| row[column].chars().count())
                    .max()
                    .unwrap_or(0)
            };
            let widths: Vec<usize> = (0..table.head.len()).map(width).collect();
            for row in [&table.head].into_iter().chain(&table.rows) {
                let cells: Vec<String> = row
                    .iter()
                    .zip(&widths)
                    .map(|(cell, width)| format!("{cell:>width$}"))
                    .collect();
                let _ = writeln!(text, "  {}", cells.join("  "));
            }
            text.push('\n');
        }
        text
    }

    fn tables(&self) -> Vec<Table> {
        vec![
            self.touch_table(),
            self.pair_table(),
            self.lone_table(),
            self.bound_table(),
            self.image_table(),
        ]
    }

    fn touch_table(&self) -> Table {
        let rows = self.touches.iter().map(|found| {
            let place = &found.place_error_mm;
            vec![
                found.touches.to_string(),
                found.noise.name().to_owned(),
                short(found.snr_db),
                found.counted_right.n.to_string(),
                percent(&found.counted_right),
                format!("{} of {}", found.missed, found.drawn),
                found.false_touches.to_string(),
                short(place.mean),
                short(found.place_bound_mm.mean),
                short(place.median),
                short(found.place_bound_mm.median),
                short(place.p95),
                hundredths(found.force_error.mean),
                hundredths(found.force_bound.mean),
            ]
        });
        Table {
            title: "Touches, by noise".to_owned(),
            head: head(&[
                "touches",
                "noise",
                "SNR, dB",
                "draws",
                "counted right",
                "missed",
                "false",
                "place, mm: mean",
                "bound",
                "median",
                "bound",
                "p95",
                "force: mean",
                "bound",
            ]),
            rows: rows.collect(),
        }
    }

    fn pair_table(&self) -> Table {
        let rows = self.discrimination.pairs.iter().map(|pair| {
            vec![
                short(pair.distance_mm),
                pair.told_apart.n.to_string(),
                percent(&pair.told_apart),
                percent(&pair.counted_two),
                percent(&pair.counted_one),
                short(pair.place_bound_mm.mean),
            ]
        });
        Table {
            title: format!(
                "Two touches told apart: {} dB, radius {} mm, rise {}",
                self.discrimination.snr_db,
                short(self.discrimination.radius_mm),
                self.discrimination.rise
            ),
            head: head(&[
                "distance, mm",
                "draws",
                "told apart",
                "seen as two",
                "seen as one",
                "place bound, mm",
            ]),
            rows: rows.collect(),
        }
    }

    fn lone_table(&self) -> Table {
        let rows = self.discrimination.lone.iter().map(|lone| {
            vec![
                lone.shape.name().to_owned(),
                lone.split.n.to_string(),
                percent(&lone.split),
                percent(&lone.missed),
            ]
        });
        Table {
            title: "One touch of another shape".to_owned(),
            head: head(&["shape", "draws", "split", "missed"]),
            rows: rows.collect(),
        }
    }

    fn bound_table(&self) -> Table {
        let places = &self.bound.places;
        let draws: usize = places.iter().map(|place| place.draws).sum();
        let missed: usize = places.iter().map(|place| place.missed).sum();
        let row = vec![
            places.len().to_string(),
            draws.to_string(),
            missed.to_string(),
            short(Spread::of(places.iter().map(|place| place.rmse_mm)).median),
            short(Spread::of(places.iter().map(|place| place.bound_mm)).median),
            short(self.bound.ratio.median),
            short(self.bound.ratio.p95),
        ];
        Table {
            title: format!(
                "Against the bound: the pad as the model takes it, {} dB",
                self.bound.snr_db
            ),
            head: head(&[
                "places",
                "draws",
                "missed",
                "RMSE, mm: median",
                "bound, mm: median",
                "RMSE / bound: median",
                "p95",
            ]),
            rows: vec![row],
        }
    }

    fn image_table(&self) -> Table {
        let rows = self.images.iter().map(|image| {
            let merit = &image.median;
            vec![
                image.noise.name().to_owned(),
                short(image.snr_db),
                image.n.to_string(),
                short(merit.amplitude_response),
                short(merit.place_error_mm),
                short(merit.resolution),
                short(merit.shape_deformation),
                short(merit.ringing),
            ]
        });
        Table {
            title: "Images of one touch: GREIT's figures, medians".to_owned(),
            head: head(&[
                "noise",
                "SNR, dB",
                "draws",
                "amplitude response",
                "place error, mm",
                "resolution",
                "shape deformation",
                "ringing",
            ]),
            rows: rows.collect(),
        }
    }

    fn csvs(&self) -> Vec<Table> {
        let touches = self.touches.iter().map(|found| {
            let mut row = vec![
                found.touches.to_string(),
                found.noise.name().to_owned(),
                cell(found.snr_db),
            ];
            row.extend(share_cells(&found.counted_right));
            row.extend([found.drawn, found.missed, found.false_touches].map(|n| n.to_string()));
            row.extend(spread_cells(&found.place_error_mm));
            row.extend(spread_cells(&found.place_bound_mm).into_iter().skip(1));
            row.extend(spread_cells(&found.force_error).into_iter().skip(1));
            row.extend(spread_cells(&found.force_bound).into_iter().skip(1));
            row
        });
        let pairs = self.discrimination.pairs.iter().map(|pair| {
            let mut row = vec![cell(pair.distance_mm)];
            row.extend(share_cells(&pair.told_apart));
            row.extend([pair.counted_two.hits, pair.counted_one.hits].map(|n| n.to_string()));
            row.extend(spread_cells(&pair.place_bound_mm).into_iter().skip(1));
            row
        });
        let lone = self.discrimination.lone.iter().map(|lone| {
            let mut row = vec![lone.shape.name().to_owned()];
            row.extend(share_cells(&lone.split));
            row.push(lone.missed.hits.to_string());
            row
        });
        let bound = self.bound.places.iter().map(|place| {
            let mut row: Vec<String> = place.place_mm.map(cell).to_vec();
            row.extend([place.draws, place.missed, place.false_touches].map(|n| n.to_string()));
            row.extend([place.rmse_mm, place.bound_mm, place.ratio].map(cell));
            row
        });
        let images = self.images.iter().map(|image| {
            let merit = &image.median;
            let mut row = vec![
                image.noise.name().to_owned(),
                cell(image.snr_db),
                image.n.to_string(),
            ];
            row.extend(
                [
                    merit.amplitude_response,
                    merit.place_error_mm,
                    merit.resolution,
                    merit.shape_deformation,
                    merit.ringing,
                ]
                .map(cell),
            );
            row
        });
        let table = |title: &str, names: &[&str], rows: Vec<Vec<String>>| Table {
            title: title.to_owned(),
            head: head(names),
            rows,
        };
        vec![
            table(
                "accuracy",
                &[
                    "touches",
                    "noise",
                    "snr_db",
                    "counted_right",
                    "draws",
                    "counted_right_low",
                    "counted_right_high",
                    "drawn",
                    "missed",
                    "false_touches",
                    "found",
                    "place_error_mean_mm",
                    "place_error_median_mm",
                    "place_error_p95_mm",
                    "place_error_rms_mm",
                    "place_bound_mean_mm",
                    "place_bound_median_mm",
                    "place_bound_p95_mm",
                    "place_bound_rms_mm",
                    "force_error_mean",
                    "force_error_median",
                    "force_error_p95",
                    "force_error_rms",
                    "force_bound_mean",
                    "force_bound_median",
                    "force_bound_p95",
                    "force_bound_rms",
                ],
                touches.collect(),
            ),
            table(
                "discrimination",
                &[
                    "distance_mm",
                    "told_apart",
                    "draws",
                    "told_apart_low",
                    "told_apart_high",
                    "counted_two",
                    "counted_one",
                    "place_bound_mean_mm",
                    "place_bound_median_mm",
                    "place_bound_p95_mm",
                    "place_bound_rms_mm",
                ],
                pairs.collect(),
            ),
            table(
                "shapes",
                &[
                    "shape",
                    "split",
                    "draws",
                    "split_low",
                    "split_high",
                    "missed",
                ],
                lone.collect(),
            ),
            table(
                "bound",
                &[
                    "x_mm",
                    "y_mm",
                    "draws",
                    "missed",
                    "false_touches",
                    "rmse_mm",
                    "bound_mm",
                    "ratio",
                ],
                bound.collect(),
            ),
            table(
                "images",
                &[
                    "noise",
                    "snr_db",
                    "draws",
                    "amplitude_response",
                    "place_error_mm",
                    "resolution",
                    "shape_deformation",
                    "ringing",
                ],
                images.collect(),
            ),
        ]
    }

    fn paragraphs(&self) -> Vec<String> {
        let scaled = if self.length_scale < 1.0 {
            format!(
                " The pad is smaller than 100 mm: all these lengths are multiplied by {}.",
                short(self.length_scale)
            )
        } else {
            String::new()
        };
        vec![
            format!(
                "Each draw presses a simulated {} that the model does not know: another mesh, contact impedances that differ by up to \
                 30 % either way, a background that is uneven by a few percent. Ten noisy frames of the untouched pad are the reference, one \
                 noisy frame is judged. Touches multiply the conductivity by 1 + rise (1 - (d / r)^2), r 5 to 9 mm, rise 0.5 to 2, middles at \
                 least 30 mm apart and 10 mm from the edge.{scaled}",
                self.pad
            ),
            "Contacts and touches are paired by the best assignment within 10 mm. What is left over is missed or false, and enters no error of \
             place. Noise is in proportion to each reading, or the same on all channels and in proportion to the largest reading of the \
             untouched pad (full-scale). Intervals are Wilson's, 95 %."
                .to_owned(),
            "The bound is Cramer and Rao's, with place, size and strength of every touch unknown, on the true pad and with a perfect reference: \
             the mean error of the best unbiased method, cut at 10 mm (at 100 % for force). Force is compared as a share of the true one, after \
             one scale for the whole pad from its single touches at the best SNR."
                .to_owned(),
            "Two touches are told apart if exactly two are seen, both near the truth. Against the bound, the pad is exactly as the model takes \
             it: what is left is noise, and ratios near 1 say that no method could do better."
                .to_owned(),
        ]
    }
}

impl Accuracy {
    /// The report.
    ///
    /// # Errors
    /// Figures that cannot be drawn.
    pub fn report(&self, findings: &Findings) -> Result<Report, StudyError> {
        Ok(Report {
            title: format!("Accuracy of {}", findings.pad),
            command: findings.command.clone(),
            version: findings.version.clone(),
            seed: findings.seed,
            paragraphs: findings.paragraphs(),
            tables: findings.tables(),
            csvs: findings.csvs(),
            figures: vec![self.picture(findings).draw()?],
        })
    }
}
