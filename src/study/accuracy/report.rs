//! What the study tells people: tables, and what they mean.

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

pub(super) fn head(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

impl Findings {
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
                 30 % either way, a background that is uneven by a few percent. Two seconds of noisy frames of the untouched pad come first, one \
                 noisy frame is judged. Touches multiply the conductivity by 1 + rise (1 - (d / r)^2), r 5 to 9 mm, rise 0.5 to 2, middles at \
                 least 30 mm apart and 10 mm from the edge.{scaled}",
                self.pad
            ),
            "Contacts and touches are paired by the best assignment within 10 mm. What is left over is missed or false, and enters no error of \
             place. Noise is in proportion to each reading, or the same on all channels and in proportion to the largest reading of the \
             untouched pad (full-scale). Intervals are Wilson's, 95 %."
                .to_owned(),
            "The bound is Cramer and Rao's, with place, size and strength of every touch unknown, on the true pad and with a perfect reference: \
             the mean error of the best unbiased method, cut at 10 mm (at 100 % for force); a method that leans on what touches usually are \
             can lie below it. Force is compared as a share of the true one, after \
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
