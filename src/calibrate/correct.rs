//! Learns the correction of a pad's contacts from presses that its model has located.
//!
//! The learned quantity is the displacement from the model's place to the true one: a Gaussian process with a part over the
//! place and a part over the voltages (see [`crate::touch::correction`]). Its parameters are those with the least
//! leave-one-out error.

use faer::linalg::solvers::{DenseSolveCore, Llt};
use faer::{Mat, Side};

use super::error::{CalibrateError, PlaceErrors};
use super::features::{channel_weights, spread};
use super::maps::subset;
use super::presses::{ModelPrediction, Presses};
use crate::stats::quantile;
use crate::touch::correction::{
    Component, Correction, CorrectionData, MOST_CORRECTION_PRESSES, place_kernel, signature,
    signature_kernel,
};
use crate::types::PointMm;

/// Candidate lengths over the pad, in deviations of the places.
const PLACE_LENGTHS: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
/// Candidate lengths over signatures, in their mean distance.
const SIGNATURE_LENGTHS: [f64; 4] = [0.7, 1.5, 3.0, 6.0];
/// Candidate shares of the place part in the prior variance.
const PLACE_SHARES: [f64; 5] = [0.0, 0.2, 0.5, 0.8, 1.0];
/// Candidate variances of the noise, relative to the prior's.
const NOISES: [f64; 6] = [1e-3, 1e-2, 0.05, 0.2, 1.0, 5.0];
/// Most presses for the choice of parameters.
const MOST_FOR_CHOICE: usize = 120;
/// Largest power of the force, and one over the least: a user who only tapped must not lose the rest of the range.
const MOST_FORCE_BEND: f64 = 4.0;

/// A correction with its expected errors.
#[derive(Clone, Debug)]
pub struct FittedCorrection {
    /// The correction.
    pub correction: Correction,
    /// Errors of the model alone.
    pub model: PlaceErrors,
    /// Errors of a lone contact, leave-one-out.
    pub lone: PlaceErrors,
    /// Errors of one contact of several, leave-one-out.
    pub several: PlaceErrors,
    /// Errors of always guessing the middle of the presses.
    pub guessed: PlaceErrors,
}

/// Parameters of the process.
#[derive(Clone, Copy, Debug)]
struct Parameters {
    place: Component,
    voltages: Component,
    noise: f64,
}

/// A correction that leaves more than this share of the error of always guessing the middle is refused: the presses do not belong
/// to their places.
const MOST_OF_GUESSING: f64 = 0.75;
/// A correction that makes the mean error larger by more than this, mm, is refused. On a pad that equals its model a few presses
/// may cost some tenths.
const MOST_WORSE_MM: f64 = 1.0;

/// Presses with their model places and signatures, all lists of the same length.
struct ModelledPresses {
    true_mm: Vec<PointMm>,
    model_mm: Vec<PointMm>,
    signatures: Vec<Vec<f32>>,
}

/// Learns a correction from presses on a pad of the given size.
///
/// # Errors
/// Presses without the model's places; presses that are too similar.
pub fn fit_correction(
    presses: &Presses,
    size_mm: [f64; 2],
) -> Result<FittedCorrection, CalibrateError> {
    let which = subset(presses.len(), MOST_CORRECTION_PRESSES);
    let places = presses.places(&which);
    let gains: Vec<f32> = channel_weights(&presses.changes(&which), &places)?
        .into_iter()
        .map(|weight| weight as f32)
        .collect();
    let mut modelled = ModelledPresses {
        true_mm: Vec::new(),
        model_mm: Vec::new(),
        signatures: Vec::new(),
    };
    let mut forces = Vec::new();
    for press in which.iter().map(|index| &presses.list()[*index]) {
        let ModelPrediction { force, place_mm } =
            press.modelled.ok_or(CalibrateError::NotModelled)?;
        modelled.true_mm.push(press.place_mm);
        modelled.model_mm.push(place_mm);
        forces.push(force);
        let changes: Vec<f32> = press.changes.iter().map(|change| *change as f32).collect();
        let mut shown = vec![0.0; gains.len()];
        signature(&changes, &gains, &mut shown);
        modelled.signatures.push(shown);
    }
    let parameters = choose(&modelled.truncated(MOST_FOR_CHOICE), spread(&places))?;
    let solution = solve(&modelled, parameters)?;
    let data = CorrectionData {
        size_mm,
        gains,
        places_mm: modelled.model_mm.clone(),
        signatures: modelled.signatures.concat(),
        weights_mm: solution.weights,
        place: parameters.place,
        voltages: parameters.voltages,
        force_power: force_power(&forces),
    };
    let count = modelled.true_mm.len();
    let mean = |axis: usize| {
        let sum: f64 = modelled.true_mm.iter().map(|place| place[axis]).sum();
        sum / count as f64
    };
    let guesses = vec![[mean(0), mean(1)]; count];
    Ok(FittedCorrection {
        correction: Correction::new(data).map_err(|_| CalibrateError::Alike)?,
        model: PlaceErrors::between(&modelled.model_mm, &modelled.true_mm),
        lone: PlaceErrors::between(&solution.lone, &modelled.true_mm),
        several: PlaceErrors::between(&solution.several, &modelled.true_mm),
        guessed: PlaceErrors::between(&guesses, &modelled.true_mm),
    })
}

impl FittedCorrection {
    /// Refuses a correction that makes nothing better.
    ///
    /// # Errors
    /// Presses that are located no better than by guessing, or worse than by the model.
    pub fn checked(self) -> Result<Self, CalibrateError> {
        let (with_mm, without_mm) = (self.lone.mean_mm, self.model.mean_mm);
        if with_mm > MOST_OF_GUESSING * self.guessed.mean_mm {
            return Err(CalibrateError::Disagree);
        }
        if with_mm > without_mm + MOST_WORSE_MM {
            return Err(CalibrateError::Worse {
                with_mm,
                without_mm,
            });
        }
        Ok(self)
    }
}

impl ModelledPresses {
    fn truncated(&self, most: usize) -> Self {
        let count = most.min(self.true_mm.len());
        Self {
            true_mm: self.true_mm[..count].to_vec(),
            model_mm: self.model_mm[..count].to_vec(),
            signatures: self.signatures[..count].to_vec(),
        }
    }

    fn kernel(&self, entry: impl Fn(usize, usize) -> f64) -> Mat<f64> {
        let count = self.true_mm.len();
        Mat::from_fn(count, count, entry)
    }
}

/// The parameters with the least mean leave-one-out error of a lone contact.
fn choose(modelled: &ModelledPresses, spread_mm: f64) -> Result<Parameters, CalibrateError> {
    let unit = mean_signature_distance(&modelled.signatures);
    let mut best: Option<(f64, Parameters)> = None;
    for place_length in PLACE_LENGTHS.map(|length| length * spread_mm) {
        for voltage_length in SIGNATURE_LENGTHS.map(|length| length * unit) {
            for share in PLACE_SHARES {
                for noise in NOISES {
                    let parameters = Parameters {
                        place: Component {
                            length: place_length,
                            variance: share,
                        },
                        voltages: Component {
                            length: voltage_length,
                            variance: 1.0 - share,
                        },
                        noise,
                    };
                    let error =
                        PlaceErrors::between(&solve(modelled, parameters)?.lone, &modelled.true_mm)
                            .mean_mm;
                    if best.as_ref().is_none_or(|(least, _)| error < *least) {
                        best = Some((error, parameters));
                    }
                }
            }
        }
    }
    best.map(|(_, parameters)| parameters)
        .ok_or(CalibrateError::Alike)
}

/// Weights of the presses, and the leave-one-out place of each: as a lone contact and as one of several.
struct Solution {
    weights: Vec<[f64; 2]>,
    lone: Vec<PointMm>,
    several: Vec<PointMm>,
}

fn solve(modelled: &ModelledPresses, parameters: Parameters) -> Result<Solution, CalibrateError> {
    let count = modelled.true_mm.len();
    let by_place = modelled.kernel(|i, j| {
        parameters.place.variance
            * place_kernel(
                modelled.model_mm[i],
                modelled.model_mm[j],
                parameters.place.length,
            )
    });
    let whole = modelled.kernel(|i, j| {
        let by_voltages = if parameters.voltages.variance > 0.0 {
            parameters.voltages.variance
                * signature_kernel(
                    &modelled.signatures[i],
                    &modelled.signatures[j],
                    parameters.voltages.length,
                )
        } else {
            0.0
        };
        by_place[(i, j)] + by_voltages + if i == j { parameters.noise } else { 0.0 }
    });
    let inverse = Llt::new(whole.as_ref(), Side::Lower)
        .map_err(|_| CalibrateError::Alike)?
        .inverse();
    let displacement = Mat::from_fn(count, 2, |i, axis| {
        modelled.true_mm[i][axis] - modelled.model_mm[i][axis]
    });
    let weights = &inverse * &displacement;
    // Without press i the weights are w - K^-1 e_i w_i / (K^-1)_ii.
    let shown = &by_place * &weights;
    let mixed = &by_place * &inverse;
    let pair = |f: &dyn Fn(usize) -> f64| [f(0), f(1)];
    Ok(Solution {
        lone: (0..count)
            .map(|i| pair(&|axis| modelled.true_mm[i][axis] - weights[(i, axis)] / inverse[(i, i)]))
            .collect(),
        several: (0..count)
            .map(|i| {
                pair(&|axis| {
                    let own = mixed[(i, i)] * weights[(i, axis)] / inverse[(i, i)];
                    modelled.model_mm[i][axis] + shown[(i, axis)] - own
                })
            })
            .collect(),
        weights: (0..count)
            .map(|i| pair(&|axis| weights[(i, axis)]))
            .collect(),
    })
}

fn mean_signature_distance(signatures: &[Vec<f32>]) -> f64 {
    let mut sum = 0.0;
    let mut pairs = 0.0;
    for (i, a) in signatures.iter().enumerate() {
        for b in &signatures[..i] {
            let distance2: f64 = a
                .iter()
                .zip(b)
                .map(|(a, b)| f64::from(a - b) * f64::from(a - b))
                .sum();
            sum += libm::sqrt(distance2);
            pairs += 1.0;
        }
    }
    (sum / f64::max(pairs, 1.0)).max(f64::MIN_POSITIVE)
}

/// The power that maps the median force to 0.5.
fn force_power(forces: &[f64]) -> f64 {
    let median = quantile(forces.iter().copied(), 0.5).unwrap_or(0.5);
    let median = median.clamp(1e-6, 1.0 - 1e-6);
    (libm::log(0.5) / libm::log(median)).clamp(1.0 / MOST_FORCE_BEND, MOST_FORCE_BEND)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::Press;
    use crate::types::Contact;

    const SIZE_MM: [f64; 2] = [100.0, 100.0];

    /// Twelve channels with a bump each; the model's places are sheared and stretched.
    fn press(x: f64, y: f64) -> Press {
        let changes = (0..12)
            .map(|c| {
                let (cx, cy) = ((c % 4) as f64 * 33.0, (c / 4) as f64 * 50.0);
                -0.1 * libm::exp(-((x - cx) * (x - cx) + (y - cy) * (y - cy)) / 1500.0)
            })
            .collect();
        Press {
            place_mm: [x, y],
            modelled: Some(ModelPrediction {
                force: 0.2,
                place_mm: [x + 4.0 + 0.05 * y, 0.93 * y + 3.0 * libm::sin(x / 25.0)],
            }),
            changes,
        }
    }

    fn presses(count: usize) -> Presses {
        let list = (0..count)
            .map(|i| {
                let share = |root: f64| (0.5 + i as f64 * root).fract();
                press(
                    5.0 + 90.0 * share(0.754_877_666),
                    5.0 + 90.0 * share(0.569_840_29),
                )
            })
            .collect();
        Presses::new("p", list).expect("spread")
    }

    #[test]
    fn a_distorted_model_is_corrected_at_places_never_pressed() {
        let fitted = fit_correction(&presses(40), SIZE_MM).expect("sound");
        assert!(fitted.model.mean_mm > 5.0);
        assert!(fitted.lone.mean_mm < 1.5, "{:?}", fitted.lone);
        assert!(fitted.several.mean_mm < 3.0, "{:?}", fitted.several);
        let mut correction = fitted.correction;
        for (x, y) in [(33.0, 44.0), (61.0, 70.0), (20.0, 81.0)] {
            let truth = press(x, y);
            let changes: Vec<f32> = truth.changes.iter().map(|c| *c as f32).collect();
            let mut lone = [Contact {
                centre_mm: truth.modelled.expect("modelled").place_mm,
                area_mm2: 100.0,
                force: 0.2,
                confidence: 1.0,
            }];
            correction.apply(&changes, &mut lone);
            let [fx, fy] = lone[0].centre_mm;
            assert!(
                libm::hypot(fx - x, fy - y) < 1.5,
                "({x}, {y}) moved to ({fx}, {fy})"
            );
            assert!(
                (lone[0].force - 0.5).abs() < 1e-9,
                "the median force maps to 0.5"
            );
        }
    }

    #[test]
    fn presses_that_do_not_belong_to_their_places_are_refused() {
        let good = presses(40);
        assert!(
            fit_correction(&good, SIZE_MM)
                .and_then(FittedCorrection::checked)
                .is_ok()
        );
        let mut list = good.list().to_vec();
        let places: Vec<PointMm> = list.iter().map(|press| press.place_mm).collect();
        for (index, press) in list.iter_mut().enumerate() {
            press.place_mm = places[(17 * index + 5) % places.len()];
        }
        let shuffled = Presses::new("p", list).expect("spread");
        let refused = fit_correction(&shuffled, SIZE_MM).and_then(FittedCorrection::checked);
        assert!(
            matches!(refused, Err(CalibrateError::Disagree)),
            "{refused:?}"
        );
    }

    #[test]
    fn expected_errors_equal_leaving_out_and_applying() {
        let all = presses(12);
        let fitted = fit_correction(&all, SIZE_MM).expect("sound");
        let seen_settings = fitted.correction.data().clone();
        // Leaves the first press out by hand, with the same parameters.
        let which = subset(12, MOST_CORRECTION_PRESSES);
        let parameters = Parameters {
            place: seen_settings.place,
            voltages: seen_settings.voltages,
            noise: 0.05,
        };
        let modelled = ModelledPresses {
            true_mm: which.iter().map(|i| all.list()[*i].place_mm).collect(),
            model_mm: seen_settings.places_mm.clone(),
            signatures: seen_settings
                .signatures
                .chunks(12)
                .map(<[f32]>::to_vec)
                .collect(),
        };
        let solution = solve(&modelled, parameters).expect("sound");
        let rest = |list: &[PointMm]| list[1..].to_vec();
        let without = ModelledPresses {
            true_mm: rest(&modelled.true_mm),
            model_mm: rest(&modelled.model_mm),
            signatures: modelled.signatures[1..].to_vec(),
        };
        let weights = solve(&without, parameters).expect("sound").weights;
        let mut by_place = modelled.model_mm[0];
        for (place, weight) in without.model_mm.iter().zip(&weights) {
            let likeness = parameters.place.variance
                * place_kernel(modelled.model_mm[0], *place, parameters.place.length);
            by_place[0] += likeness * weight[0];
            by_place[1] += likeness * weight[1];
        }
        for (found, expected) in by_place.iter().zip(&solution.several[0]) {
            assert!((found - expected).abs() < 1e-9);
        }
    }
}
