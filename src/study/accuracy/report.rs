//! The report: advice, tables and method.

use std::fmt::Write as _;

use super::{Accuracy, Findings, NoiseKind, PlaceFindings, Share, Spread};
use crate::study::StudyError;
use crate::study::figure::short;
use crate::study::report::{Report, Table};

/// Error over bound below which no method could do much better.
const NEAR_BOUND: f64 = 1.25;

/// A share in percent, with its interval.
fn percent(share: &Share) -> String {
    format!(
        "{} % ({}-{})",
        short(100.0 * share.share),
        (100.0 * share.low).round(),
        (100.0 * share.high).round()
    )
}

/// A share in percent, without an interval.
fn hundredths(share: f64) -> String {
    if share.is_finite() {
        format!("{} %", short(100.0 * share))
    } else {
        "-".to_owned()
    }
}

impl Findings {
    /// The tables as text for a terminal.
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
            self.count_table(),
            self.error_table(),
            self.pair_table(),
            self.shape_table(),
            self.bound_table(),
            self.image_table(),
        ]
    }

    fn count_table(&self) -> Table {
        let rows = self.touches.iter().map(|found| {
            vec![
                found.touches.to_string(),
                found.noise.name().to_owned(),
                short(found.snr_db),
                found.counted_right.n.to_string(),
                percent(&found.counted_right),
                format!("{} of {}", found.missed, found.drawn),
                found.false_touches.to_string(),
            ]
        });
        let head = [
            "touches",
            "noise",
            "SNR, dB",
            "draws",
            "counted right",
            "missed",
            "false",
        ];
        Table::new("Count of touches, by noise", &head, rows)
    }

    fn error_table(&self) -> Table {
        let touched = self.touches.iter().filter(|found| found.touches > 0);
        let rows = touched.map(|found| {
            let (error, bound) = (&found.place_error_mm, &found.place_bound_mm);
            vec![
                found.touches.to_string(),
                found.noise.name().to_owned(),
                short(found.snr_db),
                format!("{} ({})", short(error.mean), short(bound.mean)),
                format!("{} ({})", short(error.median), short(bound.median)),
                short(error.p95),
                format!(
                    "{} ({})",
                    hundredths(found.force_error.mean),
                    hundredths(found.force_bound.mean)
                ),
            ]
        });
        Table::new(
            "Errors (bound in brackets), by noise",
            &[
                "touches",
                "noise",
                "SNR, dB",
                "place, mm: mean",
                "median",
                "p95",
                "force: mean",
            ],
            rows,
        )
    }

    fn pair_table(&self) -> Table {
        let found = &self.discrimination;
        let rows = found.pairs.iter().map(|pair| {
            vec![
                short(pair.distance_mm),
                pair.told_apart.n.to_string(),
                percent(&pair.told_apart),
                percent(&pair.counted_two),
                percent(&pair.counted_one),
                short(pair.place_bound_mm.mean),
            ]
        });
        Table::new(
            format!(
                "Two touches told apart: {} dB, radius {} mm, rise {}",
                found.snr_db,
                short(found.radius_mm),
                found.rise
            ),
            &[
                "distance, mm",
                "draws",
                "told apart",
                "detected as two",
                "as one",
                "place bound, mm",
            ],
            rows,
        )
    }

    fn shape_table(&self) -> Table {
        let rows = self.discrimination.single_shapes.iter().map(|single| {
            vec![
                single.shape.name().to_owned(),
                single.split.n.to_string(),
                percent(&single.split),
                percent(&single.missed),
            ]
        });
        let head = ["shape", "draws", "split", "missed"];
        Table::new("One touch of another shape", &head, rows)
    }

    fn bound_table(&self) -> Table {
        let places = &self.bound.places;
        let median = |figure: fn(&PlaceFindings) -> f64| {
            short(Spread::new(places.iter().map(figure)).median)
        };
        let row = vec![
            places.len().to_string(),
            places
                .iter()
                .map(|place| place.draws)
                .sum::<usize>()
                .to_string(),
            places
                .iter()
                .map(|place| place.missed)
                .sum::<usize>()
                .to_string(),
            median(|place| place.rmse_mm),
            median(|place| place.bound_mm),
            short(self.bound.ratio.median),
            short(self.bound.ratio.p95),
        ];
        Table::new(
            format!(
                "Error over bound on a pad that equals its model, {} dB",
                self.bound.snr_db
            ),
            &[
                "places",
                "draws",
                "missed",
                "median RMSE, mm",
                "median bound, mm",
                "RMSE / bound: median",
                "p95",
            ],
            [row],
        )
    }

    fn image_table(&self) -> Table {
        let rows = self.images.iter().map(|image| {
            let merit = &image.median;
            let figures = [
                merit.amplitude_response,
                merit.place_error_mm,
                merit.resolution,
                merit.shape_deformation,
                merit.ringing,
            ];
            let names = [
                image.noise.name().to_owned(),
                short(image.snr_db),
                image.n.to_string(),
            ];
            names.into_iter().chain(figures.map(short)).collect()
        });
        Table::new(
            "Images of one touch: GREIT's figures, medians",
            &[
                "noise",
                "SNR, dB",
                "draws",
                "AR",
                "place error, mm",
                "RES",
                "SD",
                "RNG",
            ],
            rows,
        )
    }

    /// What to expect of the pad, and what to do about it.
    fn advice(&self) -> Vec<String> {
        let distance = match self.discrimination.reliable_from_mm {
            Some(mm) => format!(
                "Keep the regions of a profile that are pressed together at least {} mm apart: from there on 95 % of the pairs of touches \
                 are told apart ({} dB).",
                short(mm),
                self.discrimination.snr_db
            ),
            None => "Do not use regions that are pressed together: at no distance are 95 % of the pairs of touches told apart."
                .to_owned(),
        };
        let singles = self
            .touches
            .iter()
            .filter(|found| found.touches == 1 && found.noise == NoiseKind::Proportional);
        let places = singles.map(|found| {
            format!(
                "{} mm at {} dB",
                short(found.place_error_mm.p95),
                found.snr_db
            )
        });
        vec![
            distance,
            format!(
                "Make regions larger than the error of place: 95 % of single touches are detected within {}.",
                places.collect::<Vec<_>>().join(", ")
            ),
            format!(
                "On a pad that equals its model the error is {} times the least possible one (median over the places): {}.",
                short(self.bound.ratio.median),
                if self.bound.ratio.median < NEAR_BOUND {
                    "no other method could place touches much better, only a better pad or less noise"
                } else {
                    "a better method could place touches more exactly"
                }
            ),
        ]
    }

    fn method_notes(&self) -> Vec<String> {
        let scaled = if self.length_scale < 1.0 {
            format!(
                " The pad is smaller than 100 mm: all these lengths are multiplied by {}.",
                short(self.length_scale)
            )
        } else {
            String::new()
        };
        let model = if self.as_drawn {
            "touches are located with the pad as drawn"
        } else {
            "from the last of which the pad is identified as in play"
        };
        vec![
            format!(
                "Each draw presses a simulated {} that differs from the model: another mesh, contact impedances that differ by up to \
                 30 % either way, a background that is uneven by a few percent. After two seconds of noisy frames of the untouched pad, \
                 {model}, one noisy frame is judged. Touches multiply the conductivity by 1 + rise (1 - (d / r)^2), r 5 to 9 mm, rise 0.5 to 2, \
                 centres at least 30 mm apart and 10 mm from the edge.{scaled}",
                self.pad
            ),
            "Contacts and touches are paired by the best assignment within 10 mm. Touches without a contact are missed, contacts \
             without a touch are false; neither enters an error of place. Noise is proportional to each reading, or to the largest \
             reading of the untouched pad and the same on all channels (full-scale). Intervals are Wilson's, 95 %."
                .to_owned(),
            "The bound is the Cramer-Rao bound with place, size and strength of every touch unknown, on the true pad and with a \
             perfect reference: the mean error of the best unbiased method, cut at 10 mm (at 100 % for force). A method that uses \
             prior knowledge of typical touches can have a smaller error. Force is compared as a share of the true one, after one \
             scale for the whole pad from its single touches at the highest SNR."
                .to_owned(),
            "Two touches are told apart if exactly two are detected, both near the truth. For the comparison with the bound the pad \
             equals its model: a ratio near 1 shows that no method could do better."
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
            seed: Some(findings.seed),
            advice: findings.advice(),
            method: findings.method_notes(),
            tables: findings.tables(),
            csvs: findings.csvs(),
            figures: vec![self.figure(findings).draw()?],
            files: Vec::new(),
        })
    }
}
