//! The picture: error of place and count by noise, two-point discrimination, and the pad from above.

use super::{Accuracy, Findings, NoiseKind, Share, Spread, TouchFindings};
use crate::study::figure::{Axis, Chart, Look, PadMap, Panel, Panels, Ring, Series, short};

/// Names of the lines.
const TOUCHES: [&str; 3] = ["one touch", "two touches", "three touches"];
/// Errors are shown where at least this share of the touches was found: of few, chance and the easy ones speak.
const FOUND_SHARE: f64 = 0.5;
/// One colour a number of touches, after black.
const FIRST_COLOUR: usize = 1;

impl Accuracy {
    pub(super) fn picture(&self, findings: &Findings) -> Panels {
        let panels = vec![
            Panel::Chart(findings.place_chart(NoiseKind::Proportional)),
            Panel::Chart(findings.place_chart(NoiseKind::FullScale)),
            Panel::Chart(findings.count_chart()),
            Panel::Chart(findings.force_chart()),
            Panel::Chart(findings.pair_chart()),
            Panel::Map(self.map(findings)),
        ];
        let draws = findings
            .touches
            .first()
            .map_or(0, |found| found.counted_right.n);
        Panels {
            name: "accuracy".to_owned(),
            title: format!(
                "Accuracy of {} ({}): {draws} draws a point, on pads that the model does not know",
                findings.pad, findings.method
            ),
            panels,
        }
    }

    fn map(&self, findings: &Findings) -> PadMap {
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
        // Neighbours lie along x first; a single place has room for itself.
        let pitch_mm = rings
            .windows(2)
            .map(|pair| (pair[1].place_mm[0] - pair[0].place_mm[0]).abs())
            .filter(|step| *step > 1e-6)
            .fold(self.bench.pad.outline.size_mm()[0] / 4.0, f64::min);
        let draws = bound.places.first().map_or(0, |place| place.draws);
        PadMap {
            title: format!("Against the bound, place by place, {} dB", bound.snr_db),
            pad: self.bench.pad.clone(),
            rings,
            pitch_mm,
            names: ["error (RMSE)".to_owned(), "Cramer-Rao bound".to_owned()],
            notes: vec![
                "median of RMSE / bound:".to_owned(),
                format!(
                    "{}, p95 {}",
                    short(bound.ratio.median),
                    short(bound.ratio.p95)
                ),
                format!("{draws} draws a place, on the pad"),
                "as the model takes it".to_owned(),
            ],
        }
    }
}

impl Findings {
    /// What draws of a number of touches gave with one kind of noise, worst SNR first.
    fn with(&self, touches: usize, noise: NoiseKind) -> Vec<&TouchFindings> {
        let mut found: Vec<&TouchFindings> = self
            .touches
            .iter()
            .filter(|found| found.touches == touches && found.noise == noise)
            .collect();
        found.sort_by(|a, b| a.snr_db.total_cmp(&b.snr_db));
        found
    }

    /// A chart over the SNRs, without lines.
    fn over_snr(&self, title: &str, y_label: &str, axis: Axis) -> Chart {
        let snr_db: Vec<f64> = self
            .with(1, NoiseKind::Proportional)
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

    /// A line a number of touches.
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
                    .with(index + 1, noise)
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
            NoiseKind::Proportional => "in proportion to each reading",
            NoiseKind::FullScale => "the same on all channels (of full scale)",
        };
        let mut series = self.lines(noise, "", false, |found| found.shown(&found.place_error_mm));
        series.extend(self.lines(noise, ", bound", true, |found| {
            [found.place_bound_mm.mean; 3]
        }));
        Chart {
            series,
            notes: ["dots: mean", "bars: median to p95", "where half are found"]
                .map(str::to_owned)
                .to_vec(),
            ..self.over_snr(&format!("Error of place, noise {what}"), "mm", Axis::Log)
        }
    }

    fn count_chart(&self) -> Chart {
        let point = |found: &TouchFindings| interval(&found.counted_right);
        let mut series = self.lines(NoiseKind::Proportional, "", false, point);
        series.extend(self.lines(NoiseKind::FullScale, ", full", true, point));
        Chart {
            series,
            notes: ["full: noise of full scale", "bars: 95 % interval"]
                .map(str::to_owned)
                .to_vec(),
            ..self.over_snr(
                "As many seen as there are",
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
            notes: ["dots: mean", "bars: median to p95", "where half are found"]
                .map(str::to_owned)
                .to_vec(),
            ..self.over_snr(
                "Error of force, noise in proportion to each reading",
                "% of the force",
                Axis::FromZero,
            )
        }
    }

    fn pair_chart(&self) -> Chart {
        let pairs = &self.discrimination.pairs;
        let line = |name: &str, dashed: bool, colour: usize, points: Vec<[f64; 3]>| Series {
            name: name.to_owned(),
            points,
            look: Look {
                colour: Some(colour),
                dashed,
            },
        };
        let mut notes = vec![
            match self.discrimination.sure_from_mm {
                Some(distance) => format!("95 % from {} mm on", short(distance)),
                None => "95 % at no distance".to_owned(),
            },
            format!("both within {} mm", short(self.discrimination.within_mm)),
            "bars: 95 % interval".to_owned(),
            String::new(),
            "one touch seen as more:".to_owned(),
        ];
        notes.extend(self.discrimination.lone.iter().map(|lone| {
            format!(
                "{} {} %",
                lone.shape.name(),
                short(100.0 * lone.split.share)
            )
        }));
        Chart {
            title: format!(
                "Two touches told apart, {} dB, radius {} mm",
                self.discrimination.snr_db,
                short(self.discrimination.radius_mm)
            ),
            x_label: "from middle to middle, mm".to_owned(),
            y_label: "share of the draws".to_owned(),
            places: pairs.iter().map(|pair| short(pair.distance_mm)).collect(),
            positions: pairs.iter().map(|pair| pair.distance_mm).collect(),
            series: vec![
                line(
                    "told apart",
                    false,
                    FIRST_COLOUR,
                    pairs
                        .iter()
                        .map(|pair| interval(&pair.told_apart))
                        .collect(),
                ),
                line(
                    "seen as two",
                    true,
                    FIRST_COLOUR + 2,
                    pairs
                        .iter()
                        .map(|pair| [pair.counted_two.share; 3])
                        .collect(),
                ),
                line(
                    "seen as one",
                    true,
                    FIRST_COLOUR + 1,
                    pairs
                        .iter()
                        .map(|pair| [pair.counted_one.share; 3])
                        .collect(),
                ),
            ],
            axis: Axis::Percent,
            notes,
            ..Chart::default()
        }
    }
}

impl TouchFindings {
    /// An error of the touches found as a point: mean, and from the median to p95.
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
