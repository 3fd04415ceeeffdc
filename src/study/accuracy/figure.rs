//! The figure: errors and counts by noise, two-point discrimination, and a map of the pad.

use super::{
    Accuracy, Discrimination, Findings, NoiseKind, PairFindings, Share, Spread, TouchFindings,
};
use crate::study::figure::{Axis, Chart, Look, PadMap, Panel, Panels, Ring, Series, short};

/// Names of the lines.
const TOUCHES: [&str; 3] = ["one touch", "two touches", "three touches"];
/// Errors are shown if at least this share of the touches was detected: otherwise only the easy touches would count.
const FOUND_SHARE: f64 = 0.5;
/// Index of the first colour of the lines, after black.
const FIRST_COLOUR: usize = 1;

impl Accuracy {
    pub(super) fn figure(&self, findings: &Findings) -> Panels {
        let panels = vec![
            Panel::Chart(findings.place_chart(NoiseKind::Proportional)),
            Panel::Chart(findings.place_chart(NoiseKind::FullScale)),
            Panel::Chart(findings.count_chart()),
            Panel::Chart(findings.force_chart()),
            Panel::Chart(findings.pair_chart()),
            Panel::Map(Box::new(self.error_map(findings))),
        ];
        let draws = findings
            .touches
            .first()
            .map_or(0, |found| found.counted_right.n);
        Panels {
            name: "accuracy".to_owned(),
            title: format!(
                "Accuracy of {} ({}): {draws} draws per point, on pads unknown to the model",
                findings.pad, findings.method
            ),
            panels,
        }
    }

    fn error_map(&self, findings: &Findings) -> PadMap {
        let bound = &findings.bound;
        let rings: Vec<Ring> = bound
            .places
            .iter()
            .map(|place| Ring {
                place_mm: place.place_mm,
                outer_mm: place.rmse_mm,
                inner_mm: place.bound_mm,
            })
            .collect();
        // Neighbours follow each other along x.
        let pitch_mm = rings
            .windows(2)
            .map(|pair| (pair[1].place_mm[0] - pair[0].place_mm[0]).abs())
            .filter(|step| *step > 1e-6)
            .fold(self.bench.pad.outline.size_mm()[0] / 4.0, f64::min);
        let draws = bound.places.first().map_or(0, |place| place.draws);
        PadMap {
            title: format!("Error and bound at each place, {} dB", bound.snr_db),
            pad: self.bench.pad.clone(),
            rings,
            pitch_mm,
            names: ["error (RMSE)".to_owned(), "Cramer-Rao bound".to_owned()],
            notes: vec![
                format!("RMSE / bound: median {},", short(bound.ratio.median)),
                format!("95th percentile {}", short(bound.ratio.p95)),
                format!("{draws} draws per place, on a"),
                "pad that equals its model".to_owned(),
            ],
        }
    }
}

impl Findings {
    /// Results of a number of touches with one kind of noise, lowest SNR first.
    fn by_snr(&self, touches: usize, noise: NoiseKind) -> Vec<&TouchFindings> {
        let mut found: Vec<&TouchFindings> = self
            .touches
            .iter()
            .filter(|found| found.touches == touches && found.noise == noise)
            .collect();
        found.sort_by(|a, b| a.snr_db.total_cmp(&b.snr_db));
        found
    }

    /// An empty chart over the SNRs.
    fn over_snr(&self, title: &str, y_label: &str, axis: Axis) -> Chart {
        let snr_db: Vec<f64> = self
            .by_snr(1, NoiseKind::Proportional)
            .iter()
            .map(|found| found.snr_db)
            .collect();
        Chart {
            title: title.to_owned(),
            x_label: "SNR, dB".to_owned(),
            y_label: y_label.to_owned(),
            places: snr_db.iter().map(|db| short(*db)).collect(),
            positions: snr_db,
            axis,
            ..Chart::default()
        }
    }

    /// A line for each number of touches.
    fn lines(
        &self,
        noise: NoiseKind,
        suffix: &str,
        dashed: bool,
        point: impl Fn(&TouchFindings) -> [f64; 3],
    ) -> Vec<Series> {
        TOUCHES
            .iter()
            .enumerate()
            .map(|(index, name)| Series {
                name: format!("{name}{suffix}"),
                points: self
                    .by_snr(index + 1, noise)
                    .into_iter()
                    .map(&point)
                    .collect(),
                look: Look {
                    colour: Some(FIRST_COLOUR + index),
                    dashed,
                },
            })
            .collect()
    }

    fn place_chart(&self, noise: NoiseKind) -> Chart {
        let what = match noise {
            NoiseKind::Proportional => "proportional to each reading",
            NoiseKind::FullScale => "of full scale",
        };
        let mut series = self.lines(noise, "", false, |found| found.shown(&found.place_error_mm));
        series.extend(self.lines(noise, ", bound", true, |found| {
            [found.place_bound_mm.mean; 3]
        }));
        Chart {
            series,
            notes: ["dots: mean", "bars: median to p95", "if half are detected"]
                .map(str::to_owned)
                .to_vec(),
            ..self.over_snr(&format!("Error of place, noise {what}"), "mm", Axis::Log)
        }
    }

    fn count_chart(&self) -> Chart {
        let point = |found: &TouchFindings| interval(&found.counted_right);
        let mut series = self.lines(NoiseKind::Proportional, "", false, point);
        series.extend(self.lines(NoiseKind::FullScale, ", full scale", true, point));
        Chart {
            series,
            notes: vec!["bars: 95 % interval".to_owned()],
            ..self.over_snr(
                "As many detected as there are",
                "share of the draws",
                Axis::Percent,
            )
        }
    }

    fn force_chart(&self) -> Chart {
        let noise = NoiseKind::Proportional;
        let mut series = self.lines(noise, "", false, |found| {
            found.shown(&found.force_error).map(|share| 100.0 * share)
        });
        series.extend(self.lines(noise, ", bound", true, |found| {
            [100.0 * found.force_bound.mean; 3]
        }));
        Chart {
            series,
            notes: ["dots: mean", "bars: median to p95", "if half are detected"]
                .map(str::to_owned)
                .to_vec(),
            ..self.over_snr(
                "Error of force, noise proportional to each reading",
                "% of the force",
                Axis::FromZero,
            )
        }
    }

    fn pair_chart(&self) -> Chart {
        let Discrimination {
            pairs,
            snr_db,
            radius_mm,
            ..
        } = &self.discrimination;
        let line = |name: &str, dashed, colour, point: fn(&PairFindings) -> [f64; 3]| Series {
            name: name.to_owned(),
            points: pairs.iter().map(point).collect(),
            look: Look {
                colour: Some(FIRST_COLOUR + colour),
                dashed,
            },
        };
        Chart {
            title: format!(
                "Two touches told apart, {snr_db} dB, radius {} mm",
                short(*radius_mm)
            ),
            x_label: "distance between the centres, mm".to_owned(),
            y_label: "share of the draws".to_owned(),
            places: pairs.iter().map(|pair| short(pair.distance_mm)).collect(),
            positions: pairs.iter().map(|pair| pair.distance_mm).collect(),
            series: vec![
                line("told apart", false, 0, |pair| interval(&pair.told_apart)),
                line("detected as two", true, 2, |pair| {
                    [pair.counted_two.share; 3]
                }),
                line("detected as one", true, 1, |pair| {
                    [pair.counted_one.share; 3]
                }),
            ],
            axis: Axis::Percent,
            notes: self.pair_notes(),
            ..Chart::default()
        }
    }

    fn pair_notes(&self) -> Vec<String> {
        let found = &self.discrimination;
        let mut notes = vec![
            match found.reliable_from_mm {
                Some(distance) => format!("95 % from {} mm on", short(distance)),
                None => "95 % at no distance".to_owned(),
            },
            format!("both within {} mm", short(found.within_mm)),
            "bars: 95 % interval".to_owned(),
            " ".to_owned(),
            "one touch detected as more:".to_owned(),
        ];
        notes.extend(found.single_shapes.iter().map(|single| {
            let percent = short(100.0 * single.split.share);
            format!("{} {percent} %", single.shape.name())
        }));
        notes
    }
}

impl TouchFindings {
    /// An error as a point: mean, with the range from the median to the 95th percentile.
    fn shown(&self, error: &Spread) -> [f64; 3] {
        if (error.n as f64) < FOUND_SHARE * self.drawn as f64 {
            return [f64::NAN; 3];
        }
        [error.mean, error.median.min(error.mean), error.p95]
    }
}

/// A share as a point with its interval.
fn interval(share: &Share) -> [f64; 3] {
    [share.share, share.low, share.high]
}
