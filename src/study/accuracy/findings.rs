//! All results, as written to `accuracy.json`.

use serde::Serialize;

use super::discrimination::{self, PairDrawn};
use super::draws::{self, SingleShape};
use super::efficiency::{self, PlaceFindings};
use super::touches::{self, Drawn, ForceScale};
use super::{
    Accuracy, AccuracyOutcome, ImageFindings, MOST_TOUCHES, PairFindings, SingleShapeFindings,
    Solved, Spread, Task, TouchFindings,
};
use crate::study::CommandLine;

/// All results.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Findings {
    /// Version of gelpad.
    pub version: String,
    /// The shell command that repeats the study.
    pub command: String,
    /// The pad's name.
    pub pad: String,
    /// Reconstruction method.
    pub method: String,
    /// Seed.
    pub seed: u64,
    /// Few draws only: a test that everything works.
    pub quick: bool,
    /// Whether touches are located with the drawing, not with the pad as identified from its readings at rest.
    pub as_drawn: bool,
    /// Factor of the lengths of touches and distances; below 1 on a pad below 100 mm.
    pub length_scale: f64,
    /// Touches, by number and noise.
    pub touches: Vec<TouchFindings>,
    /// Meaning of a force of 1.
    pub force: ForceScale,
    /// GREIT's figures of single touches, by noise.
    pub images: Vec<ImageFindings>,
    /// Two-point discrimination.
    pub discrimination: Discrimination,
    /// The sensing against the bound.
    pub bound: Efficiency,
}

/// Two-point discrimination.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Discrimination {
    /// SNR with noise proportional to each reading, dB.
    pub snr_db: f64,
    /// Radius of the presses, mm (scaled).
    pub radius_mm: f64,
    /// Rise of the presses.
    pub rise: f64,
    /// Both must be detected within this distance of the truth, mm (scaled).
    pub within_mm: f64,
    /// The least distance from which 95 % of the pairs are resolved, mm; `null` if there is none.
    #[serde(rename = "sure_from_mm")]
    pub reliable_from_mm: Option<f64>,
    /// Results by distance.
    pub pairs: Vec<PairFindings>,
    /// Single touches of other shapes.
    #[serde(rename = "lone")]
    pub single_shapes: Vec<SingleShapeFindings>,
}

/// Error of place against its Cramer-Rao bound, on the pad as the model assumes it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Efficiency {
    /// SNR with noise proportional to each reading, dB.
    pub snr_db: f64,
    /// Radius of the press, mm (scaled).
    pub radius_mm: f64,
    /// Rise of the press.
    pub rise: f64,
    /// Root mean square error over bound, spread over the places.
    pub ratio: Spread,
    /// Place by place.
    pub places: Vec<PlaceFindings>,
}

impl Accuracy {
    /// Summarises the results of all cases, which are in the order of the cases.
    #[must_use]
    pub fn findings(&self, outcomes: &[AccuracyOutcome]) -> Findings {
        let bench = &self.bench;
        let drawn: Vec<&Drawn> = self
            .of_task(outcomes, Task::Touches)
            .flat_map(|solved| match solved {
                Solved::Touches(drawn) => drawn.as_slice(),
                _ => &[],
            })
            .collect();
        let of_count = |count| {
            drawn
                .iter()
                .copied()
                .filter(move |one| one.presses.len() == count)
        };
        let of_touches: Vec<Vec<&Drawn>> = (0..=MOST_TOUCHES)
            .map(|count| of_count(count).collect())
            .collect();
        let force = ForceScale::from_draws(&of_touches[1]);
        let touches = of_touches
            .iter()
            .enumerate()
            .flat_map(|(count, drawn)| touches::findings(bench, count, drawn, force))
            .collect();
        let places: Vec<PlaceFindings> = outcomes
            .iter()
            .filter_map(|outcome| match &outcome.0 {
                Solved::Place(place) => Some(place.clone()),
                _ => None,
            })
            .collect();
        let pairs = self.pairs(outcomes);
        Findings {
            version: self.settings.version.clone(),
            command: self.command(),
            pad: self.settings.pad.name.clone(),
            method: self.settings.method.name().to_owned(),
            seed: self.settings.seed,
            quick: self.settings.quick,
            as_drawn: self.settings.as_drawn,
            length_scale: bench.scale,
            touches,
            force,
            images: touches::images(bench, &of_touches[1]),
            discrimination: Discrimination {
                snr_db: discrimination::SNR_DB,
                radius_mm: draws::PAIR.0 * bench.scale,
                rise: draws::PAIR.1,
                within_mm: discrimination::WITHIN_MM * bench.scale,
                reliable_from_mm: discrimination::reliable_from_mm(&pairs),
                pairs,
                single_shapes: SingleShape::ALL
                    .map(|shape| self.single_shapes(outcomes, shape))
                    .to_vec(),
            },
            bound: Efficiency {
                snr_db: efficiency::SNR_DB,
                radius_mm: efficiency::PRESS.0 * bench.scale,
                rise: efficiency::PRESS.1,
                ratio: efficiency::ratios(&places),
                places,
            },
        }
    }

    /// The shell command that repeats the study.
    #[must_use]
    pub fn command(&self) -> String {
        let settings = &self.settings;
        let snr_db: Vec<String> = self.bench.snr_db.iter().map(f64::to_string).collect();
        CommandLine::new("accuracy", &settings.pad_argument)
            .option("method", settings.method)
            .option("snr", snr_db.join(","))
            .option("seed", settings.seed)
            .flag("quick", settings.quick)
            .flag("as-drawn", settings.as_drawn)
            .finish()
    }

    /// Results of the cases of a task.
    fn of_task<'a>(
        &'a self,
        outcomes: &'a [AccuracyOutcome],
        task: Task,
    ) -> impl Iterator<Item = &'a Solved> {
        self.cases
            .iter()
            .zip(outcomes)
            .filter(move |(case, _)| case.task == task)
            .map(|(_, outcome)| &outcome.0)
    }

    fn pairs(&self, outcomes: &[AccuracyOutcome]) -> Vec<PairFindings> {
        let mut distances: Vec<usize> = self
            .cases
            .iter()
            .filter_map(|case| match case.task {
                Task::Pairs { distance_mm } => Some(distance_mm),
                _ => None,
            })
            .collect();
        distances.dedup();
        distances
            .into_iter()
            .map(|distance_mm| {
                let drawn: Vec<&PairDrawn> = self
                    .of_task(outcomes, Task::Pairs { distance_mm })
                    .flat_map(|solved| match solved {
                        Solved::Pairs(drawn) => drawn.as_slice(),
                        _ => &[],
                    })
                    .collect();
                PairFindings::from_draws(distance_mm as f64 * self.bench.scale, &drawn)
            })
            .collect()
    }

    fn single_shapes(
        &self,
        outcomes: &[AccuracyOutcome],
        shape: SingleShape,
    ) -> SingleShapeFindings {
        let seen: Vec<usize> = self
            .of_task(outcomes, Task::SingleShape(shape))
            .flat_map(|solved| match solved {
                Solved::SingleShape(seen) => seen.clone(),
                _ => Vec::new(),
            })
            .collect();
        SingleShapeFindings::from_counts(shape, &seen)
    }
}
