//! Regression from voltages to places: several members, blended by their cross-validated errors.
//!
//! Each member sees the changes in another way (root or logarithm, unit norm or not, a learned metric, maps of the channels).
//! Lengths and noises of the members are chosen by leave-one-out, the shares by cross-validation in which everything that
//! depends on places, including learned metrics, is fitted without the presses left out. Nothing is random: the same presses
//! give the same regression.

use faer::Mat;

use super::blend;
use super::component_maps::{ComponentMaps, ComponentSpec};
use super::error::{CalibrateError, PlaceErrors};
use super::features::{Compression, FeatureSpec, Features, channel_weights, stretch};
use super::maps::{Maps, rows, subset};
use super::presses::{Presses, shuffled};
use super::process::{self, Hyperparameters, Process};
use super::region::Region;
use crate::types::PointMm;

/// Most presses for the choice of lengths, noises and channel weights.
const MOST_FOR_CHOICE: usize = 400;
/// Parts of the cross-validation.
const FOLDS: usize = 5;
/// With more presses than [`MANY`], only this many parts are left out in turn.
const FOLDS_OF_MANY: usize = 2;
const MANY: usize = 1000;

/// Candidate factors on length and noise, where these were chosen from a part of the presses.
const REFINEMENTS: [(f64, f64); 4] = [(1.0, 1.0), (0.7, 1.0), (1.0, 0.3), (0.7, 0.3)];

/// Presses are refused if their expected error is more than this share of that of guessing the middle every time.
const MOST_OF_GUESSING: f64 = 0.8;
/// Fewer presses are not judged: their expected error is too uncertain.
const ENOUGH_TO_JUDGE: usize = 20;

/// How a member is made.
#[derive(Clone, Copy, Debug)]
enum MemberSpec {
    /// A Gaussian process on features; if `learned`, in a metric from its own gradients.
    Process {
        features: FeatureSpec,
        learned: bool,
    },
    /// Maps of the changes' signed roots.
    Maps { power: f64 },
    /// Maps of the changes' principal components.
    Components(ComponentSpec),
}

const fn process(
    compression: Compression,
    unit: bool,
    weighted: bool,
    learned: bool,
) -> MemberSpec {
    MemberSpec::Process {
        features: FeatureSpec {
            compression,
            unit,
            weighted,
        },
        learned,
    }
}

const fn components(power: f64, unit: bool, components: usize, limit: Option<f64>) -> MemberSpec {
    MemberSpec::Components(ComponentSpec {
        power,
        unit,
        components,
        limit,
    })
}

/// With more presses than this, the last [`FOR_FEW`] members are left out: they take long and have no share.
const FEW_PRESSES: usize = 200;
const FOR_FEW: usize = 5;

/// The members; the blend decides their shares on a pad.
const MEMBERS: [MemberSpec; 13] = [
    process(Compression::Root(0.7), false, false, false),
    process(Compression::Log, false, false, false),
    process(Compression::Log, false, true, false),
    process(Compression::Log, false, false, true),
    process(Compression::Root(0.7), false, false, true),
    process(Compression::Root(0.7), true, false, true),
    MemberSpec::Maps { power: 0.5 },
    MemberSpec::Maps { power: 0.75 },
    components(0.6, false, 15, None),
    components(0.6, true, 15, None),
    components(0.6, false, 25, Some(3.0)),
    components(0.7, true, 25, Some(2.0)),
    components(0.6, false, 60, Some(3.0)),
];

/// Hyperparameters of a member: of its process, and of the process in the learned metric.
#[derive(Clone, Copy, Debug)]
struct MemberHyperparameters {
    plain: Hyperparameters,
    learned: Option<Hyperparameters>,
}

/// A fitted member of the blend.
#[derive(Clone, Debug)]
enum FittedMember {
    Process {
        features: Features,
        stretch: Option<Mat<f64>>,
        process: Process,
    },
    Maps(Maps),
    Components(ComponentMaps),
}

/// A fitted regression.
#[derive(Clone, Debug)]
pub struct Regression {
    /// Members with their shares.
    members: Vec<(f64, FittedMember)>,
    expected: PlaceErrors,
    region: Region,
}

impl Regression {
    /// Learns from presses; calls `report` at each stage.
    ///
    /// # Errors
    /// See [`CalibrateError`].
    pub fn fit(presses: &Presses, report: &mut dyn FnMut(&str)) -> Result<Self, CalibrateError> {
        let order = shuffled(presses.len());
        let (changes, places) = (presses.changes(&order), presses.places(&order));
        let data = Data { changes, places };
        let weights = data.channel_weights()?;
        let few = data.rows(&subset(order.len(), MOST_FOR_CHOICE));
        let members = members_for(order.len());
        let mut chosen = Vec::new();
        for (index, spec) in members.iter().enumerate() {
            report(&format!(
                "settings of member {} of {}",
                index + 1,
                members.len()
            ));
            chosen.push(choose(*spec, &few, &weights)?);
        }
        let CrossValidation {
            shares,
            expected,
            region,
        } = cross_validate(&data, &mut chosen, report)?;
        if order.len() >= ENOUGH_TO_JUDGE
            && expected.mean_mm > MOST_OF_GUESSING * guessing_mm(&data.places)
        {
            return Err(CalibrateError::Disagree);
        }
        let mut fitted = Vec::new();
        for ((spec, chosen), share) in members.iter().zip(&chosen).zip(shares) {
            if share > 0.0 {
                report("all presses");
                fitted.push((share, FittedMember::fit(*spec, *chosen, &data, &weights)?));
            }
        }
        Ok(Self {
            members: fitted,
            expected,
            region,
        })
    }

    /// Errors of the presses left out in the cross-validation.
    #[must_use]
    pub fn expected(&self) -> PlaceErrors {
        self.expected
    }

    /// Predicts the places of presses and the radii of the circles that hold each with a probability of 90 %, mm.
    ///
    /// # Panics
    /// If there are other channels than were learned from.
    #[must_use]
    pub fn predict_with_region(&self, changes: &Mat<f64>) -> (Vec<PointMm>, Vec<f64>) {
        let predicted: Vec<Vec<PointMm>> = self
            .members
            .iter()
            .map(|(_, member)| points(&member.predict(changes)))
            .collect();
        let shares: Vec<f64> = self.members.iter().map(|(share, _)| *share).collect();
        let places = blend::blended(&predicted, &shares);
        let radii_mm = self.region.radii_mm(&predicted, &shares, &places);
        (places, radii_mm)
    }

    /// Errors of the predicted places of presses.
    ///
    /// # Panics
    /// If there are other channels than were learned from.
    #[must_use]
    pub fn evaluate(&self, presses: &Presses) -> PlaceErrors {
        let all: Vec<usize> = (0..presses.len()).collect();
        let (predicted, _) = self.predict_with_region(&presses.changes(&all));
        let truth: Vec<[f64; 2]> = presses.list().iter().map(|press| press.place_mm).collect();
        PlaceErrors::between(&predicted, &truth)
    }
}

/// Changes and places of presses, one row for each press.
struct Data {
    changes: Mat<f64>,
    places: Mat<f64>,
}

impl Data {
    fn rows(&self, which: &[usize]) -> Self {
        Self {
            changes: rows(&self.changes, which),
            places: rows(&self.places, which),
        }
    }

    fn channel_weights(&self) -> Result<Vec<f64>, CalibrateError> {
        let few = self.rows(&subset(self.places.nrows(), MOST_FOR_CHOICE));
        channel_weights(&few.changes, &few.places)
    }
}

/// The rows of a matrix of places.
fn points(places: &Mat<f64>) -> Vec<PointMm> {
    (0..places.nrows())
        .map(|row| [places[(row, 0)], places[(row, 1)]])
        .collect()
}

/// The members for a number of presses.
fn members_for(presses: usize) -> &'static [MemberSpec] {
    let left_out = if presses > FEW_PRESSES { FOR_FEW } else { 0 };
    &MEMBERS[..MEMBERS.len() - left_out]
}

/// Mean distance of places from their middle, mm.
fn guessing_mm(places: &Mat<f64>) -> f64 {
    let count = places.nrows() as f64;
    let [x, y] = [0, 1].map(|axis| places.col(axis).iter().sum::<f64>() / count);
    let distance = |row| libm::hypot(places[(row, 0)] - x, places[(row, 1)] - y);
    (0..places.nrows()).map(distance).sum::<f64>() / count
}

/// What presses left out show.
struct CrossValidation {
    shares: Vec<f64>,
    expected: PlaceErrors,
    region: Region,
}

/// Shares of the members, and the errors of their blend on presses left out. With many presses, also refines `chosen`.
fn cross_validate(
    data: &Data,
    chosen: &mut [MemberHyperparameters],
    report: &mut dyn FnMut(&str),
) -> Result<CrossValidation, CalibrateError> {
    let count = data.places.nrows();
    let members = members_for(count);
    let folds = if count > MANY { FOLDS_OF_MANY } else { FOLDS };
    let mut truth: Vec<PointMm> = Vec::new();
    let mut predicted: Vec<Vec<PointMm>> = vec![Vec::new(); members.len()];
    for fold in 0..folds {
        report(&format!("cross-validation {} of {folds}", fold + 1));
        let (out, rest): (Vec<usize>, Vec<usize>) =
            (0..count).partition(|press| press % FOLDS == fold);
        let (seen, unseen) = (data.rows(&rest), data.rows(&out));
        // The weights depend on places, too.
        let weights = seen.channel_weights()?;
        for ((spec, chosen), predicted) in members.iter().zip(&mut *chosen).zip(&mut predicted) {
            if fold == 0 && count > MOST_FOR_CHOICE {
                refine(*spec, chosen, [&seen, &unseen], &weights)?;
            }
            let member = FittedMember::fit(*spec, *chosen, &seen, &weights)?;
            predicted.extend(points(&member.predict(&unseen.changes)));
        }
        truth.extend(points(&unseen.places));
    }
    let shares = blend::shares(&predicted, &truth);
    let places = blend::blended(&predicted, &shares);
    Ok(CrossValidation {
        expected: PlaceErrors::between(&places, &truth),
        region: Region::fit(&predicted, &shares, &places, &truth)?,
        shares,
    })
}

fn choose(
    spec: MemberSpec,
    data: &Data,
    weights: &[f64],
) -> Result<MemberHyperparameters, CalibrateError> {
    let MemberSpec::Process { features, learned } = spec else {
        // Maps choose their own.
        let plain = Hyperparameters {
            length: 1.0,
            noise: 1.0,
        };
        return Ok(MemberHyperparameters {
            plain,
            learned: None,
        });
    };
    let points = Features::fit(features, &data.changes, weights).apply(&data.changes);
    let plain = process::choose(&points, &data.places)?;
    let learned = if learned {
        let process = Process::fit(points.clone(), &data.places, plain)?;
        let stretched = points * stretch(&process.gradient_outer_product())?;
        Some(process::choose(&stretched, &data.places)?)
    } else {
        None
    };
    Ok(MemberHyperparameters { plain, learned })
}

/// Lengths and noises chosen from a part of the presses are too large for all of them: tries smaller ones on presses left out.
fn refine(
    spec: MemberSpec,
    chosen: &mut MemberHyperparameters,
    [seen, unseen]: [&Data; 2],
    weights: &[f64],
) -> Result<(), CalibrateError> {
    let MemberSpec::Process { features, .. } = spec else {
        return Ok(());
    };
    let features = Features::fit(features, &seen.changes, weights);
    let (mut points, mut new) = (
        features.apply(&seen.changes),
        features.apply(&unseen.changes),
    );
    if chosen.learned.is_some() {
        let process = Process::fit(points.clone(), &seen.places, chosen.plain)?;
        let stretch = stretch(&process.gradient_outer_product())?;
        (points, new) = (points * &stretch, new * &stretch);
    }
    let start = chosen.learned.unwrap_or(chosen.plain);
    let mut best: Option<(f64, Hyperparameters)> = None;
    for (by_length, by_noise) in REFINEMENTS {
        let hyper = Hyperparameters {
            length: by_length * start.length,
            noise: by_noise * start.noise,
        };
        let found = Process::fit(points.clone(), &seen.places, hyper)?.predict(&new);
        let error = process::mean_norm(&(found - &unseen.places));
        if best.is_none_or(|(least, _)| error < least) {
            best = Some((error, hyper));
        }
    }
    if let Some((_, hyper)) = best {
        match &mut chosen.learned {
            Some(learned) => *learned = hyper,
            None => chosen.plain = hyper,
        }
    }
    Ok(())
}

impl FittedMember {
    fn fit(
        spec: MemberSpec,
        chosen: MemberHyperparameters,
        data: &Data,
        weights: &[f64],
    ) -> Result<Self, CalibrateError> {
        let features = match spec {
            MemberSpec::Maps { power } => {
                return Maps::fit(power, &data.changes, &data.places).map(Self::Maps);
            }
            MemberSpec::Components(spec) => {
                return ComponentMaps::fit(spec, &data.changes, &data.places).map(Self::Components);
            }
            MemberSpec::Process { features, .. } => features,
        };
        let features = Features::fit(features, &data.changes, weights);
        let points = features.apply(&data.changes);
        let process = Process::fit(points.clone(), &data.places, chosen.plain)?;
        Ok(match chosen.learned {
            None => Self::Process {
                features,
                stretch: None,
                process,
            },
            Some(hyper) => {
                let stretch = stretch(&process.gradient_outer_product())?;
                let process = Process::fit(points * &stretch, &data.places, hyper)?;
                Self::Process {
                    features,
                    stretch: Some(stretch),
                    process,
                }
            }
        })
    }

    fn predict(&self, changes: &Mat<f64>) -> Mat<f64> {
        match self {
            Self::Maps(maps) => maps.predict(changes),
            Self::Components(maps) => maps.predict(changes),
            Self::Process {
                features,
                stretch,
                process,
            } => {
                let points = features.apply(changes);
                match stretch {
                    Some(stretch) => process.predict(&(points * stretch)),
                    None => process.predict(&points),
                }
            }
        }
    }
}
