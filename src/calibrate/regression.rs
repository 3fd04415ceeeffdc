//! Voltages to places: several regressions, blended by how well they place presses that they have not seen.
//!
//! Each member sees the changes in another way (root or logarithm, unit norm or not, a learned metric, maps read
//! backwards). Members' lengths and noises are chosen by leave-one-out, their shares of the blend by cross-validation in which
//! everything that looks at places, learned metrics too, is learned anew without the presses left out. Nothing is
//! random: the same presses give the same regression.

use faer::Mat;

use super::features::{Features, Recipe, Shape, channel_weights, stretch};
use super::maps::{Maps, rows, subset};
use super::presses::{Presses, mixed};
use super::process::{self, Hyper, Process};
use super::{CalibrateError, Errors, blend};

/// Presses at most for the choice of lengths and noises, and of the channels' weights.
const MOST_FOR_CHOICE: usize = 400;
/// Parts of the cross-validation; of many presses only the first parts are left out in turn.
const FOLDS: usize = 5;
const FOLDS_OF_MANY: usize = 2;
/// So many presses are many.
const MANY: usize = 1000;

/// Factors on length and noise that are tried where these were chosen on a part of the presses.
const REFINEMENTS: [(f64, f64); 4] = [(1.0, 1.0), (0.7, 1.0), (1.0, 0.3), (0.7, 0.3)];

/// A way to see presses.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// A Gaussian process on features; `learned` with a metric from its own gradients.
    Process { recipe: Recipe, learned: bool },
    /// Maps of the changes' signed roots, read backwards.
    Maps { power: f64 },
}

const fn seen(shape: Shape, unit: bool, weighted: bool, learned: bool) -> Kind {
    Kind::Process {
        recipe: Recipe {
            shape,
            unit,
            weighted,
        },
        learned,
    }
}

/// The members that are fitted; the blend decides what each is worth on a pad.
const KINDS: [Kind; 8] = [
    seen(Shape::Root(0.7), false, false, false),
    seen(Shape::Log, false, false, false),
    seen(Shape::Log, false, true, false),
    seen(Shape::Log, false, false, true),
    seen(Shape::Root(0.7), false, false, true),
    seen(Shape::Root(0.7), true, false, true),
    Kind::Maps { power: 0.5 },
    Kind::Maps { power: 0.75 },
];

/// Lengths and noises of a member: of its process, and of the one in the learned metric.
#[derive(Clone, Copy, Debug)]
struct Chosen {
    plain: Hyper,
    learned: Option<Hyper>,
}

/// A fitted member.
#[derive(Clone, Debug)]
enum Member {
    Process {
        features: Features,
        stretch: Option<Mat<f64>>,
        process: Process,
    },
    Maps(Maps),
}

/// A fitted regression.
#[derive(Clone, Debug)]
pub struct Regression {
    /// Members with their shares.
    members: Vec<(f64, Member)>,
    expected: Errors,
}

impl Regression {
    /// Learns from presses; `told` hears what is being done.
    ///
    /// # Errors
    /// See [`CalibrateError`].
    pub fn fit(presses: &Presses, told: &mut dyn FnMut(&str)) -> Result<Self, CalibrateError> {
        let order = mixed(presses.len());
        let (changes, places) = (presses.changes(&order), presses.places(&order));
        let data = Data { changes, places };
        let few = data.some(&subset(order.len(), MOST_FOR_CHOICE));
        let weights = channel_weights(&few.changes, &few.places)?;
        let mut chosen = Vec::new();
        for (index, kind) in KINDS.iter().enumerate() {
            told(&format!(
                "settings of member {} of {}",
                index + 1,
                KINDS.len()
            ));
            chosen.push(choose(*kind, &few, &weights)?);
        }
        let folds = if order.len() > MANY {
            FOLDS_OF_MANY
        } else {
            FOLDS
        };
        let mut left_out: Vec<usize> = Vec::new();
        let mut guesses: Vec<Vec<[f64; 2]>> = vec![Vec::new(); KINDS.len()];
        for fold in 0..folds {
            told(&format!("cross-validation {} of {folds}", fold + 1));
            let (out, rest): (Vec<usize>, Vec<usize>) =
                (0..order.len()).partition(|press| press % FOLDS == fold);
            let seen = data.some(&rest);
            let unseen = rows(&data.changes, &out);
            // The weights see places too.
            let few = seen.some(&subset(rest.len(), MOST_FOR_CHOICE));
            let weights = channel_weights(&few.changes, &few.places)?;
            for ((kind, chosen), guesses) in KINDS.iter().zip(&mut chosen).zip(&mut guesses) {
                if fold == 0 && order.len() > MOST_FOR_CHOICE {
                    refine(*kind, chosen, [&seen, &data.some(&out)], &weights)?;
                }
                let member = Member::fit(*kind, *chosen, &seen, &weights)?;
                let found = member.predict(&unseen);
                guesses.extend((0..out.len()).map(|press| [found[(press, 0)], found[(press, 1)]]));
            }
            left_out.extend(out);
        }
        let truth: Vec<[f64; 2]> = left_out
            .iter()
            .map(|press| [data.places[(*press, 0)], data.places[(*press, 1)]])
            .collect();
        let shares = blend::shares(&guesses, &truth);
        let expected = Errors::of(&blend::blended(&guesses, &shares), &truth);
        let mut members = Vec::new();
        for ((kind, chosen), share) in KINDS.iter().zip(&chosen).zip(shares) {
            if share > 0.0 {
                told("the whole set");
                members.push((share, Member::fit(*kind, *chosen, &data, &weights)?));
            }
        }
        Ok(Self { members, expected })
    }

    /// What presses that were left out were off by.
    #[must_use]
    pub fn expected(&self) -> Errors {
        self.expected
    }

    /// Places of presses, mm: presses by 2.
    ///
    /// # Panics
    /// If there are other channels than were learned from.
    #[must_use]
    pub fn predict(&self, changes: &Mat<f64>) -> Mat<f64> {
        let mut places = Mat::zeros(changes.nrows(), 2);
        for (share, member) in &self.members {
            places += member.predict(changes) * faer::Scale(*share);
        }
        places
    }

    /// Places presses at known places and says what they are off by.
    ///
    /// # Panics
    /// If there are other channels than were learned from.
    #[must_use]
    pub fn evaluate(&self, presses: &Presses) -> Errors {
        let all: Vec<usize> = (0..presses.len()).collect();
        let found = self.predict(&presses.changes(&all));
        let guesses: Vec<[f64; 2]> = all
            .iter()
            .map(|p| [found[(*p, 0)], found[(*p, 1)]])
            .collect();
        let truth: Vec<[f64; 2]> = presses.list().iter().map(|press| press.place_mm).collect();
        Errors::of(&guesses, &truth)
    }
}

/// Changes and places of presses, a row a press.
struct Data {
    changes: Mat<f64>,
    places: Mat<f64>,
}

impl Data {
    fn some(&self, which: &[usize]) -> Self {
        Self {
            changes: rows(&self.changes, which),
            places: rows(&self.places, which),
        }
    }
}

fn choose(kind: Kind, data: &Data, weights: &[f64]) -> Result<Chosen, CalibrateError> {
    let Kind::Process { recipe, learned } = kind else {
        // Maps choose for themselves.
        let plain = Hyper {
            length: 1.0,
            noise: 1.0,
        };
        return Ok(Chosen {
            plain,
            learned: None,
        });
    };
    let points = Features::fit(recipe, &data.changes, weights).of(&data.changes);
    let plain = process::choose(&points, &data.places)?;
    let learned = if learned {
        let process = Process::fit(points.clone(), &data.places, plain)?;
        let stretched = points * stretch(&process.gradient_outer_product())?;
        Some(process::choose(&stretched, &data.places)?)
    } else {
        None
    };
    Ok(Chosen { plain, learned })
}

/// Settings chosen on a part of many presses come out too long and too noisy for all of them: tries shorter and less noisy
/// ones on presses left out.
fn refine(
    kind: Kind,
    chosen: &mut Chosen,
    [seen, unseen]: [&Data; 2],
    weights: &[f64],
) -> Result<(), CalibrateError> {
    let Kind::Process { recipe, .. } = kind else {
        return Ok(());
    };
    let features = Features::fit(recipe, &seen.changes, weights);
    let (mut points, mut new) = (features.of(&seen.changes), features.of(&unseen.changes));
    if chosen.learned.is_some() {
        let process = Process::fit(points.clone(), &seen.places, chosen.plain)?;
        let stretch = stretch(&process.gradient_outer_product())?;
        (points, new) = (points * &stretch, new * &stretch);
    }
    let start = chosen.learned.unwrap_or(chosen.plain);
    let mut best: Option<(f64, Hyper)> = None;
    for (by_length, by_noise) in REFINEMENTS {
        let hyper = Hyper {
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

impl Member {
    fn fit(
        kind: Kind,
        chosen: Chosen,
        data: &Data,
        weights: &[f64],
    ) -> Result<Self, CalibrateError> {
        let recipe = match kind {
            Kind::Maps { power } => {
                return Maps::fit(power, &data.changes, &data.places).map(Self::Maps);
            }
            Kind::Process { recipe, .. } => recipe,
        };
        let features = Features::fit(recipe, &data.changes, weights);
        let points = features.of(&data.changes);
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
            Self::Process {
                features,
                stretch,
                process,
            } => {
                let points = features.of(changes);
                match stretch {
                    Some(stretch) => process.predict(&(points * stretch)),
                    None => process.predict(&points),
                }
            }
        }
    }
}
