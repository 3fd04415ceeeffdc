//! All that the study found, as it stands in `accuracy.json`.

use serde::Serialize;

use super::discrimination::{self, PairDrawn};
use super::draws::{self, Lone};
use super::efficiency::{self, PlaceFindings};
use super::touches::{self, Drawn, ForceScale};
use super::{
    Accuracy, ImageFindings, LoneFindings, Outcome, PairFindings, Solved, Spread, Task,
    TouchFindings,
};

/// What the study found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Findings {
    /// Version of gelpad.
    pub version: String,
    /// The command that makes it again.
    pub command: String,
    /// The pad's name.
    pub pad: String,
    /// How images were made.
    pub method: String,
    /// Seed.
    pub seed: u64,
    /// Few draws only: whether all works, not how well.
    pub quick: bool,
    /// Lengths of touches and distances are multiplied by this on a pad below 100 mm.
    pub length_scale: f64,
    /// By number of touches and noise.
    pub touches: Vec<TouchFindings>,
    /// What a force of 1 stands for.
    pub force: ForceScale,
    /// GREIT's figures of single touches, by noise.
    pub images: Vec<ImageFindings>,
    /// How near two touches may be.
    pub discrimination: Discrimination,
    /// How near the sensing comes to the bound.
    pub bound: Efficiency,
}

/// Two-point discrimination.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Discrimination {
    /// Noise in proportion to each reading, dB.
    pub snr_db: f64,
    /// Radius of the presses, mm (scaled).
    pub radius_mm: f64,
    /// Their rise.
    pub rise: f64,
    /// Both must be seen within this distance of the truth, mm (scaled).
    pub within_mm: f64,
    /// The least distance from which on 95 % are told apart, mm; `null` if there is none.
    pub sure_from_mm: Option<f64>,
    /// By distance.
    pub pairs: Vec<PairFindings>,
    /// Single touches of other shapes.
    pub lone: Vec<LoneFindings>,
}

/// Error of place against its Cramer-Rao bound, on the pad as the model takes it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Efficiency {
    /// Noise in proportion to each reading, dB.
    pub snr_db: f64,
    /// Radius of the press, mm (scaled).
    pub radius_mm: f64,
    /// Its rise.
    pub rise: f64,
    /// Root mean square error over the bound, spread over the places.
    pub ratio: Spread,
    /// Place by place.
    pub places: Vec<PlaceFindings>,
}

impl Accuracy {
    /// What the outcomes of all cases, in their order, tell.
    #[must_use]
    pub fn findings(&self, outcomes: &[Outcome]) -> Findings {
        let bench = &self.bench;
        let of_touches: Vec<Vec<&Drawn>> = (0..=3)
            .map(|count| {
                self.of_task(outcomes, Task::Touches(count))
                    .flat_map(|solved| match solved {
                        Solved::Touches(drawn) => drawn.as_slice(),
                        _ => &[],
                    })
                    .collect()
            })
            .collect();
        let force = ForceScale::of(&of_touches[1]);
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
            length_scale: bench.scale,
            touches,
            force,
            images: touches::images(bench, &of_touches[1]),
            discrimination: Discrimination {
                snr_db: discrimination::SNR_DB,
                radius_mm: draws::PAIR.0 * bench.scale,
                rise: draws::PAIR.1,
                within_mm: discrimination::WITHIN_MM * bench.scale,
                sure_from_mm: discrimination::sure_from_mm(&pairs),
                pairs,
                lone: Lone::ALL.map(|shape| self.lone(outcomes, shape)).to_vec(),
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

    /// The command that makes it again.
    fn command(&self) -> String {
        let settings = &self.settings;
        let snr_db: Vec<String> = self.bench.snr_db.iter().map(f64::to_string).collect();
        format!(
            "gelpad accuracy --pad {} --method {} --snr {} --seed {}{} --out DIR",
            settings.pad_argument,
            settings.method,
            snr_db.join(","),
            settings.seed,
            if settings.quick { " --quick" } else { "" }
        )
    }

    fn of_task<'a>(
        &'a self,
        outcomes: &'a [Outcome],
        task: Task,
    ) -> impl Iterator<Item = &'a Solved> {
        self.cases
            .iter()
            .zip(outcomes)
            .filter(move |(case, _)| case.task == task)
            .map(|(_, outcome)| &outcome.0)
    }

    fn pairs(&self, outcomes: &[Outcome]) -> Vec<PairFindings> {
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
                PairFindings::of(distance_mm as f64 * self.bench.scale, &drawn)
            })
            .collect()
    }

    fn lone(&self, outcomes: &[Outcome], shape: Lone) -> LoneFindings {
        let seen: Vec<usize> = self
            .of_task(outcomes, Task::Lone(shape))
            .flat_map(|solved| match solved {
                Solved::Lone(seen) => seen.clone(),
                _ => Vec::new(),
            })
            .collect();
        LoneFindings::of(shape, &seen)
    }
}
