//! `gelpad accuracy`: the accuracy of a pad's sensing by Monte Carlo simulation, next to the Cramer-Rao bound.
//!
//! Voltages come from specimens that differ from the model: another mesh, unequal contacts, an uneven background (`specimen`).
//! The sensing is that of play: frames in, touches out (`sensing`). Every case has its own random numbers, from the seed and
//! its index: the same seed gives the same files with any number of threads.

mod csv;
mod discrimination;
pub(super) mod draws;
mod efficiency;
mod figure;
mod findings;
mod found;
pub mod identified;
mod noise;
pub mod real;
mod report;
pub mod scan;
mod score;
mod sensed;
mod sensing;
mod solved;
pub(super) mod specimen;
mod spread;
mod touches;

pub use discrimination::{PairFindings, SingleShapeFindings};
pub use draws::SingleShape;
pub use efficiency::PlaceFindings;
pub use findings::{Discrimination, Efficiency, Findings};
pub use noise::NoiseKind;
pub use spread::{Share, Spread};
pub use touches::{ForceScale, ImageFindings, TouchFindings};

use noise::Instrument;
use sensing::{RestedDetector, Sensing};
use specimen::Specimen;

use super::StudyError;
use crate::pad::Pad;
use crate::touch::SensingBuilder;
use crate::types::{Method, PointMm};

/// Most touches of a draw.
const MOST_TOUCHES: usize = 3;
/// Draws of a kind on one specimen: many enough to be worth identifying it, few enough for many specimens.
const DRAWS_A_SPECIMEN: usize = 25;

/// Numbers of draws.
struct Plan {
    /// Draws for each number of touches.
    touches: usize,
    /// Distances between centres, mm: least, greatest, step.
    distances_mm: [usize; 3],
    /// Pairs at each distance.
    pairs: usize,
    /// Single shapes of each kind.
    single_shapes: usize,
    /// Places along each side, and draws at each, for the comparison with the bound.
    places: (usize, usize),
}

/// Some minutes on two cores.
const FULL: Plan = Plan {
    touches: 200,
    distances_mm: [8, 40, 2],
    pairs: 100,
    single_shapes: 200,
    places: (7, 100),
};
/// A few seconds: a test that everything works.
const QUICK: Plan = Plan {
    touches: 20,
    distances_mm: [8, 40, 16],
    pairs: 10,
    single_shapes: 10,
    places: (3, 15),
};

/// Settings of the study.
#[derive(Clone, Debug, PartialEq)]
pub struct AccuracySettings {
    /// Version of gelpad.
    pub version: String,
    /// The pad.
    pub pad: Pad,
    /// The pad as named on the command line.
    pub pad_argument: String,
    /// Reconstruction method.
    pub method: Method,
    /// SNRs, dB; at least one.
    pub snr_db: Vec<f64>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Few draws only.
    pub quick: bool,
    /// Whether touches are located with the drawing, not with the pad as identified from its readings at rest.
    pub as_drawn: bool,
}

/// What all cases share.
#[derive(Clone, Debug)]
struct Bench {
    pad: Pad,
    sensing: Sensing,
    /// The pad as the model assumes it.
    ideal: Specimen,
    seed: u64,
    /// Descending, without duplicates.
    snr_db: Vec<f64>,
    /// Factor of all lengths on this pad.
    scale: f64,
    as_drawn: bool,
}

impl Bench {
    /// The sensing of play once it has read the untouched pad of a specimen.
    fn rested(&self, instrument: &Instrument, seed: u64) -> Result<RestedDetector, StudyError> {
        if self.as_drawn {
            return Ok(self.sensing.rested(instrument, seed));
        }
        self.sensing.rested_as_found(&self.pad, instrument, seed)
    }

    /// Every noise with which a state is read: proportional noise first, high SNR first.
    fn noises(&self) -> impl Iterator<Item = (NoiseKind, f64)> {
        NoiseKind::ALL
            .into_iter()
            .flat_map(|kind| self.snr_db.iter().map(move |snr_db| (kind, *snr_db)))
    }
}

/// One case: draws on one specimen.
#[derive(Clone, Debug)]
pub struct Case {
    /// Stream of its random numbers: its index.
    stream: u64,
    draws: usize,
    task: Task,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Task {
    /// No touch to [`MOST_TOUCHES`], as many draws of each.
    Touches,
    Pairs {
        distance_mm: usize,
    },
    SingleShape(SingleShape),
    Place(PointMm),
}

/// Result of a case.
#[derive(Clone, Debug)]
pub struct AccuracyOutcome(Solved);

#[derive(Clone, Debug)]
enum Solved {
    Touches(Vec<touches::Drawn>),
    Pairs(Vec<discrimination::PairDrawn>),
    SingleShape(Vec<usize>),
    Place(PlaceFindings),
}

/// The study with valid settings.
#[derive(Clone, Debug)]
pub struct Accuracy {
    settings: AccuracySettings,
    bench: Bench,
    cases: Vec<Case>,
}

impl Accuracy {
    /// Validates the settings. `sensing` is the sensing of play on the pad, with the settings' method.
    ///
    /// # Errors
    /// No SNR, or one that is not finite; a pad without a reconstruction.
    pub fn new(settings: AccuracySettings, sensing: SensingBuilder) -> Result<Self, StudyError> {
        let mut snr_db = settings.snr_db.clone();
        if snr_db.is_empty() || snr_db.iter().any(|db| !db.is_finite()) {
            return Err(StudyError::refused(
                "give at least one SNR in dB, as in 60,40",
            ));
        }
        snr_db.sort_by(|a, b| b.total_cmp(a));
        snr_db.dedup();
        let pad = settings.pad.clone();
        let plan = if settings.quick { &QUICK } else { &FULL };
        Ok(Self {
            bench: Bench {
                sensing: Sensing::from_pad(&pad, sensing)?,
                ideal: Specimen::ideal(&pad)?,
                seed: settings.seed,
                scale: draws::scale(&pad),
                snr_db,
                as_drawn: settings.as_drawn,
                pad,
            },
            cases: cases(plan, &settings.pad),
            settings,
        })
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &AccuracySettings {
        &self.settings
    }

    /// The independent cases.
    #[must_use]
    pub fn cases(&self) -> &[Case] {
        &self.cases
    }

    /// Plays the conditions of `--real` in their order, and hands over the table so far after each.
    ///
    /// # Errors
    /// A pad that cannot be solved; what `on_condition` returns.
    pub fn play_conditions<E: From<StudyError>>(
        &self,
        conditions: &[real::Condition],
        extent: real::Extent,
        mut on_condition: impl FnMut(&real::RealFindings) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut findings = real::RealFindings {
            seed: self.settings.seed,
            conditions: Vec::new(),
        };
        real::play_all(&self.bench, conditions, extent, |condition| {
            findings.conditions.push(condition);
            on_condition(&findings)
        })
    }

    /// Locates touches on pads that differ from their drawing.
    ///
    /// # Errors
    /// A pad that cannot be solved.
    pub fn locate_on_built_pads(
        &self,
        extent: identified::IdentifyExtent,
        progress: impl Fn(usize, usize) + Sync,
    ) -> Result<identified::IdentifyFindings, StudyError> {
        identified::play_all(&self.bench, self.bench.sensing.builder(), extent, progress)
    }

    /// Plays presses on a pad whose drives are read in turn.
    ///
    /// # Errors
    /// A pad that cannot be solved.
    pub fn play_scans(
        &self,
        extent: scan::ScanExtent,
        progress: impl Fn(usize, usize) + Sync,
    ) -> Result<scan::ScanFindings, StudyError> {
        scan::play_all(&self.bench, extent, progress)
    }

    /// Solves a case.
    ///
    /// # Errors
    /// A pad that cannot be solved.
    pub fn solve(&self, case: &Case) -> Result<AccuracyOutcome, StudyError> {
        let (bench, draws, stream) = (&self.bench, case.draws, case.stream);
        Ok(AccuracyOutcome(match case.task {
            Task::Touches => Solved::Touches(touches::solve(bench, draws, stream)?),
            Task::Pairs { distance_mm } => {
                let distance_mm = distance_mm as f64;
                let pairs = discrimination::solve_pairs(bench, distance_mm, draws, stream)?;
                Solved::Pairs(pairs)
            }
            Task::SingleShape(shape) => {
                let counts = discrimination::solve_single_shapes(bench, shape, draws, stream)?;
                Solved::SingleShape(counts)
            }
            Task::Place(place_mm) => {
                Solved::Place(efficiency::solve(bench, place_mm, draws, stream)?)
            }
        }))
    }
}

fn cases(plan: &Plan, pad: &Pad) -> Vec<Case> {
    let [least, most, step] = plan.distances_mm;
    let touches = std::iter::once((Task::Touches, plan.touches));
    let pairs = (least..=most)
        .step_by(step)
        .map(|distance_mm| (Task::Pairs { distance_mm }, plan.pairs));
    let single_shapes = SingleShape::ALL
        .into_iter()
        .map(|shape| (Task::SingleShape(shape), plan.single_shapes));
    let on_specimens = touches
        .chain(pairs)
        .chain(single_shapes)
        .flat_map(|(task, draws)| {
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
