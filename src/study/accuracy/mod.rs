//! `gelpad accuracy`: what a pad's sensing can do, by Monte Carlo, with the bound of what any method could do beside it.
//!
//! Voltages come from specimens that the model does not know: another mesh, unequal contacts, an uneven background (see
//! `specimen`). The sensing is the one that plays, frames in and touches out (`sensing`). Every case has random numbers of
//! its own, from the seed and its place in the list: the same seed gives the same files on any number of threads.

mod csv;
mod discrimination;
mod draws;
mod efficiency;
mod figure;
mod findings;
mod noise;
mod report;
mod score;
mod sensing;
mod specimen;
mod stats;
mod touches;

pub use discrimination::{LoneFindings, PairFindings};
pub use draws::Lone;
pub use efficiency::PlaceFindings;
pub use findings::{Discrimination, Efficiency, Findings};
pub use noise::NoiseKind;
pub use stats::{Share, Spread};
pub use touches::{ForceScale, ImageFindings, TouchFindings};

use sensing::Sensing;
use specimen::Specimen;

use super::StudyError;
use crate::pad::Pad;
use crate::touch::SensingBuilder;
use crate::types::{Method, PointMm};

/// Draws on one specimen: enough to be worth its solving, few enough that figures see many specimens.
const DRAWS_A_SPECIMEN: usize = 25;

/// How much is drawn.
struct Plan {
    /// Draws of each number of touches.
    touches: usize,
    /// From middle to middle, mm: least, greatest, step.
    distances_mm: [usize; 3],
    /// Pairs at each distance.
    pairs: usize,
    /// Lone shapes of each kind.
    lone: usize,
    /// Places along each side, and draws at each, for the comparison with the bound.
    places: (usize, usize),
}

/// About a minute on two cores.
const FULL: Plan = Plan {
    touches: 200,
    distances_mm: [8, 40, 2],
    pairs: 100,
    lone: 200,
    places: (7, 100),
};
/// A few seconds: whether all works, not how well.
const QUICK: Plan = Plan {
    touches: 20,
    distances_mm: [8, 40, 16],
    pairs: 10,
    lone: 10,
    places: (3, 15),
};

/// What is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Version of gelpad.
    pub version: String,
    /// The pad.
    pub pad: Pad,
    /// As it was named on the command line.
    pub pad_argument: String,
    /// How images are made.
    pub method: Method,
    /// SNRs, dB; at least one.
    pub snr_db: Vec<f64>,
    /// Seed of everything random.
    pub seed: u64,
    /// Few draws.
    pub quick: bool,
}

/// What every case needs.
#[derive(Clone, Debug)]
struct Bench {
    pad: Pad,
    sensing: Sensing,
    /// The pad as the model takes it.
    ideal: Specimen,
    seed: u64,
    /// Best first, each once.
    snr_db: Vec<f64>,
    /// Length of a millimetre of the settings on this pad.
    scale: f64,
}

impl Bench {
    /// Every noise with which a state is read: the proportional ones first, the best first.
    fn noises(&self) -> impl Iterator<Item = (NoiseKind, f64)> {
        NoiseKind::ALL
            .into_iter()
            .flat_map(|kind| self.snr_db.iter().map(move |snr_db| (kind, *snr_db)))
    }
}

/// One case: draws on one specimen.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its random numbers: its place in the list.
    stream: u64,
    draws: usize,
    task: Task,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Task {
    Touches(usize),
    Pairs { distance_mm: usize },
    Lone(Lone),
    Place(PointMm),
}

/// What a case gave.
#[derive(Clone, Debug)]
pub struct Outcome(Solved);

#[derive(Clone, Debug)]
enum Solved {
    Touches(Vec<touches::Drawn>),
    Pairs(Vec<discrimination::PairDrawn>),
    Lone(Vec<usize>),
    Place(PlaceFindings),
}

/// The study, checked and ready to be solved case by case.
#[derive(Clone, Debug)]
pub struct Accuracy {
    settings: Settings,
    bench: Bench,
    cases: Vec<Case>,
}

impl Accuracy {
    /// Checks settings before anything random is drawn. `sensing` is what plays on the pad with the settings' method.
    ///
    /// # Errors
    /// No SNR, or one that is no number; a pad that gives no image.
    pub fn new(settings: Settings, sensing: SensingBuilder) -> Result<Self, StudyError> {
        let mut snr_db = settings.snr_db.clone();
        if snr_db.is_empty() || snr_db.iter().any(|db| !db.is_finite()) {
            return Err(StudyError::Refused {
                reason: "name at least one SNR in dB, as in 60,40".to_owned(),
            });
        }
        snr_db.sort_by(|a, b| b.total_cmp(a));
        snr_db.dedup();
        let pad = settings.pad.clone();
        let plan = if settings.quick { &QUICK } else { &FULL };
        Ok(Self {
            bench: Bench {
                sensing: Sensing::of_pad(&pad, sensing)?,
                ideal: Specimen::ideal(&pad)?,
                seed: settings.seed,
                scale: draws::scale(&pad),
                snr_db,
                pad,
            },
            cases: cases(plan, &settings.pad),
            settings,
        })
    }

    /// What is asked for.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The cases, each to be solved on its own.
    #[must_use]
    pub fn cases(&self) -> &[Case] {
        &self.cases
    }

    /// Solves a case.
    ///
    /// # Errors
    /// A pad that cannot be solved.
    pub fn solve(&self, case: &Case) -> Result<Outcome, StudyError> {
        let (bench, draws, stream) = (&self.bench, case.draws, case.stream);
        Ok(Outcome(match case.task {
            Task::Touches(count) => Solved::Touches(touches::solve(bench, count, draws, stream)?),
            Task::Pairs { distance_mm } => {
                let distance_mm = distance_mm as f64;
                Solved::Pairs(discrimination::solve_pairs(
                    bench,
                    distance_mm,
                    draws,
                    stream,
                )?)
            }
            Task::Lone(shape) => {
                Solved::Lone(discrimination::solve_lone(bench, shape, draws, stream)?)
            }
            Task::Place(place_mm) => {
                Solved::Place(efficiency::solve(bench, place_mm, draws, stream)?)
            }
        }))
    }
}

fn cases(plan: &Plan, pad: &Pad) -> Vec<Case> {
    let [least, most, step] = plan.distances_mm;
    let touches = (0..=3).map(|count| (Task::Touches(count), plan.touches));
    let pairs = (least..=most)
        .step_by(step)
        .map(|distance_mm| (Task::Pairs { distance_mm }, plan.pairs));
    let lone = Lone::ALL
        .into_iter()
        .map(|shape| (Task::Lone(shape), plan.lone));
    let on_specimens = touches.chain(pairs).chain(lone).flat_map(|(task, draws)| {
        (0..draws)
            .step_by(DRAWS_A_SPECIMEN)
            .map(move |done| (task, DRAWS_A_SPECIMEN.min(draws - done)))
    });
    let (side, draws) = plan.places;
    let at_places = draws::grid(pad, side)
        .into_iter()
        .map(|place| (Task::Place(place), draws));
    on_specimens
        .chain(at_places)
        .enumerate()
        .map(|(index, (task, draws))| Case {
            stream: index as u64,
            draws,
            task,
        })
        .collect()
}
