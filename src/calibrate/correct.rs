//! The correction of a pad's contacts, learned from presses that its model has seen.
//!
//! What is learned is the displacement from the model's place to the true one: a Gaussian process with a part over the
//! place and a part over the voltages (see [`crate::touch::correction`]). Its four numbers are those with the least error when each
//! press is left out.

use faer::linalg::solvers::{DenseSolveCore, Llt};
use faer::{Mat, Side};

use super::features::{channel_weights, spread};
use super::maps::subset;
use super::presses::{Modelled, Presses};
use super::{CalibrateError, Errors};
use crate::touch::correction::{
    Component, Correction, CorrectionData, MOST_CORRECTION_PRESSES, place_kernel, signature,
    signature_kernel,
};
use crate::types::PointMm;

/// Tried lengths over the pad, in deviations of the places.
const PLACE_LENGTHS: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
/// Tried lengths over signatures, in their mean distance.
const SIGNATURE_LENGTHS: [f64; 4] = [0.7, 1.5, 3.0, 6.0];
/// Tried shares of the place's part in the prior variance.
const PLACE_SHARES: [f64; 5] = [0.0, 0.2, 0.5, 0.8, 1.0];
/// Tried variances of the noise, of the prior's.
const NOISES: [f64; 6] = [1e-3, 1e-2, 0.05, 0.2, 1.0, 5.0];
/// Presses at most for the choice.
const MOST_FOR_CHOICE: usize = 120;
/// The power of the force stays within this factor: a user who only ever tapped must not lose the rest of the range.
const MOST_FORCE_BEND: f64 = 4.0;

/// A correction with what it is worth.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// What is applied.
    pub correction: Correction,
    /// What the model alone is off by.
    pub model: Errors,
    /// What a lone contact is off by, each press left out in turn.
    pub lone: Errors,
    /// What a contact among several is off by, each press left out in turn.
    pub several: Errors,
}

/// The four numbers of the process.
#[derive(Clone, Copy, Debug)]
struct Settings {
    place: Component,
    voltages: Component,
    noise: f64,
}

/// Presses as the process sees them.
struct Seen {
    true_mm: Vec<PointMm>,
    model_mm: Vec<PointMm>,
    signatures: Vec<Vec<f32>>,
}

/// Learns a correction from presses of a pad of a size, mm.
///
/// # Errors
/// Presses without the model's places; presses too much alike.
pub fn correction(presses: &Presses, size_mm: [f64; 2]) -> Result<Fitted, CalibrateError> {
    let which = subset(presses.len(), MOST_CORRECTION_PRESSES);
    let places = presses.places(&which);
    let gains: Vec<f32> = channel_weights(&presses.changes(&which), &places)?
        .into_iter()
        .map(|weight| weight as f32)
        .collect();
    let mut seen = Seen {
        true_mm: Vec::new(),
        model_mm: Vec::new(),
        signatures: Vec::new(),
    };
    let mut forces = Vec::new();
    for press in which.iter().map(|index| &presses.list()[*index]) {
        let Modelled { force, place_mm } = press.modelled.ok_or(CalibrateError::NotModelled)?;
        seen.true_mm.push(press.place_mm);
        seen.model_mm.push(place_mm);
        forces.push(force);
        let changes: Vec<f32> = press.changes.iter().map(|change| *change as f32).collect();
        let mut shown = vec![0.0; gains.len()];
        signature(&changes, &gains, &mut shown);
        seen.signatures.push(shown);
    }
    let settings = choose(&seen.first(MOST_FOR_CHOICE), spread(&places))?;
    let solved = solve(&seen, settings)?;
    let data = CorrectionData {
        size_mm,
        gains,
        places_mm: seen.model_mm.clone(),
        signatures: seen.signatures.concat(),
        weights_mm: solved.weights,
        place: settings.place,
        voltages: settings.voltages,
        force_power: force_power(&mut forces),
    };
    Ok(Fitted {
        correction: Correction::new(data).map_err(|_| CalibrateError::Alike)?,
        model: Errors::of(&seen.model_mm, &seen.true_mm),
        lone: Errors::of(&solved.lone, &seen.true_mm),
        several: Errors::of(&solved.several, &seen.true_mm),
    })
}

impl Seen {
    fn first(&self, most: usize) -> Self {
        let count = most.min(self.true_mm.len());
        Self {
            true_mm: self.true_mm[..count].to_vec(),
            model_mm: self.model_mm[..count].to_vec(),
            signatures: self.signatures[..count].to_vec(),
        }
    }

    fn kernel(&self, of: impl Fn(usize, usize) -> f64) -> Mat<f64> {
        let count = self.true_mm.len();
        Mat::from_fn(count, count, of)
    }
}

/// The settings with the least mean error of a lone press left out.
fn choose(seen: &Seen, spread_mm: f64) -> Result<Settings, CalibrateError> {
    let unit = mean_distance(&seen.signatures);
    let mut best: Option<(f64, Settings)> = None;
    for place_length in PLACE_LENGTHS.map(|length| length * spread_mm) {
        for voltage_length in SIGNATURE_LENGTHS.map(|length| length * unit) {
            for share in PLACE_SHARES {
                for noise in NOISES {
                    let settings = Settings {
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
                    let error = Errors::of(&solve(seen, settings)?.lone, &seen.true_mm).mean_mm;
                    if best.as_ref().is_none_or(|(least, _)| error < *least) {
                        best = Some((error, settings));
                    }
                }
            }
        }
    }
    best.map(|(_, settings)| settings)
        .ok_or(CalibrateError::Alike)
}

/// The presses' weights, and where each is put without itself.
struct Solved {
    weights: Vec<[f64; 2]>,
    lone: Vec<PointMm>,
    several: Vec<PointMm>,
}

fn solve(seen: &Seen, settings: Settings) -> Result<Solved, CalibrateError> {
    let count = seen.true_mm.len();
    let by_place = seen.kernel(|i, j| {
        settings.place.variance
            * place_kernel(seen.model_mm[i], seen.model_mm[j], settings.place.length)
    });
    let whole = seen.kernel(|i, j| {
        let by_voltages = if settings.voltages.variance > 0.0 {
            settings.voltages.variance
                * signature_kernel(
                    &seen.signatures[i],
                    &seen.signatures[j],
                    settings.voltages.length,
                )
        } else {
            0.0
        };
        by_place[(i, j)] + by_voltages + if i == j { settings.noise } else { 0.0 }
    });
    let inverse = Llt::new(whole.as_ref(), Side::Lower)
        .map_err(|_| CalibrateError::Alike)?
        .inverse();
    let displacement = Mat::from_fn(count, 2, |i, axis| {
        seen.true_mm[i][axis] - seen.model_mm[i][axis]
    });
    let weights = &inverse * &displacement;
    // Without press i the weights are w - K^-1 e_i w_i / (K^-1)_ii.
    let shown = &by_place * &weights;
    let mixed = &by_place * &inverse;
    let pair = |f: &dyn Fn(usize) -> f64| [f(0), f(1)];
    Ok(Solved {
        lone: (0..count)
            .map(|i| pair(&|axis| seen.true_mm[i][axis] - weights[(i, axis)] / inverse[(i, i)]))
            .collect(),
        several: (0..count)
            .map(|i| {
                pair(&|axis| {
                    let own = mixed[(i, i)] * weights[(i, axis)] / inverse[(i, i)];
                    seen.model_mm[i][axis] + shown[(i, axis)] - own
                })
            })
            .collect(),
        weights: (0..count)
            .map(|i| pair(&|axis| weights[(i, axis)]))
            .collect(),
    })
}

fn mean_distance(signatures: &[Vec<f32>]) -> f64 {
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

/// The power that takes the user's median force to the middle.
fn force_power(forces: &mut [f64]) -> f64 {
    forces.sort_by(f64::total_cmp);
    let median = forces[forces.len() / 2].clamp(1e-6, 1.0 - 1e-6);
    (libm::log(0.5) / libm::log(median)).clamp(1.0 / MOST_FORCE_BEND, MOST_FORCE_BEND)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::Press;
    use crate::types::Contact;

    const SIZE_MM: [f64; 2] = [100.0, 100.0];

    /// Bumps seen by twelve channels; the model sees places turned and stretched.
    fn press(x: f64, y: f64) -> Press {
        let changes = (0..12)
            .map(|c| {
                let (cx, cy) = ((c % 4) as f64 * 33.0, (c / 4) as f64 * 50.0);
                -0.1 * libm::exp(-((x - cx) * (x - cx) + (y - cy) * (y - cy)) / 1500.0)
            })
            .collect();
        Press {
            place_mm: [x, y],
            modelled: Some(Modelled {
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
    fn a_bent_model_is_set_right_at_places_never_pressed() {
        let fitted = correction(&presses(40), SIZE_MM).expect("sound");
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
                "({x}, {y}) went to ({fx}, {fy})"
            );
            assert!(
                (lone[0].force - 0.5).abs() < 1e-9,
                "the usual press is the middle"
            );
        }
    }

    #[test]
    fn what_is_expected_is_what_leaving_out_and_applying_gives() {
        let all = presses(12);
        let fitted = correction(&all, SIZE_MM).expect("sound");
        let seen_settings = fitted.correction.data().clone();
        // Left out by hand with the same settings: the process without that press, applied to it.
        let which = subset(12, MOST_CORRECTION_PRESSES);
        let settings = Settings {
            place: seen_settings.place,
            voltages: seen_settings.voltages,
            noise: 0.05,
        };
        let seen = Seen {
            true_mm: which.iter().map(|i| all.list()[*i].place_mm).collect(),
            model_mm: seen_settings.places_mm.clone(),
            signatures: seen_settings
                .signatures
                .chunks(12)
                .map(<[f32]>::to_vec)
                .collect(),
        };
        let solved = solve(&seen, settings).expect("sound");
        let rest = |list: &[PointMm]| list[1..].to_vec();
        let without = Seen {
            true_mm: rest(&seen.true_mm),
            model_mm: rest(&seen.model_mm),
            signatures: seen.signatures[1..].to_vec(),
        };
        let weights = solve(&without, settings).expect("sound").weights;
        let mut by_place = seen.model_mm[0];
        for (place, weight) in without.model_mm.iter().zip(&weights) {
            let likeness = settings.place.variance
                * place_kernel(seen.model_mm[0], *place, settings.place.length);
            by_place[0] += likeness * weight[0];
            by_place[1] += likeness * weight[1];
        }
        for (found, expected) in by_place.iter().zip(&solved.several[0]) {
            assert!((found - expected).abs() < 1e-9);
        }
    }
}
