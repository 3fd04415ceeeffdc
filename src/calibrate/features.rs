//! What a regression is shown of a press: its changes, compressed, scaled, and stretched along the directions that matter.
//!
//! Changes of a press span orders of magnitude between channels near it and far off. A signed root or logarithm lets the
//! far ones speak, and unit norm takes off how hard was pressed; which of them serves a pad best is not known beforehand,
//! so several are fitted and blended.

use faer::{Mat, Side};

use super::CalibrateError;
use super::process::{self, Hyper};

/// The logarithm turns linear below this share of the median change.
const LINEAR_BELOW: f64 = 0.7;
/// A channel is left out of weighted features if the place explains less than this share of its variance.
const LEAST_EXPLAINED: f64 = 0.15;
/// Lengths (in deviations of the places) and noises tried for a channel's map over the pad.
const MAP_LENGTHS: [f64; 4] = [0.35, 0.7, 1.1, 1.6];
const MAP_NOISES: [f64; 3] = [0.01, 0.1, 0.5];
/// Share of the mean eigenvalue that a learned metric leaves to every direction.
const METRIC_FLOOR: f64 = 1e-6;
/// Eigenvalues of the gradients' outer product enter the map to this power: half a step of the metric that they give,
/// since whole steps overfit small sets.
const METRIC_POWER: f64 = 0.25;

/// How changes are compressed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    /// sign(d) |d|^p.
    Root(f64),
    /// asinh(d / scale).
    Log,
}

/// What is done to changes before a regression sees them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Recipe {
    pub shape: Shape,
    /// Each press to unit norm first.
    pub unit: bool,
    /// Each channel by how well the place explains it.
    pub weighted: bool,
}

/// A recipe with what it learned from presses.
#[derive(Clone, Debug)]
pub(super) struct Features {
    recipe: Recipe,
    scale: f64,
    weights: Vec<f64>,
    mean: Vec<f64>,
    size: f64,
}

impl Features {
    /// Learns from presses: `changes` presses by channels, `weights` one a channel.
    pub(super) fn fit(recipe: Recipe, changes: &Mat<f64>, weights: &[f64]) -> Self {
        let mut features = Self {
            recipe,
            scale: LINEAR_BELOW * median_magnitude(changes),
            weights: if recipe.weighted {
                weights.to_vec()
            } else {
                vec![1.0; changes.ncols()]
            },
            mean: vec![0.0; changes.ncols()],
            size: 1.0,
        };
        let shaped = features.of(changes);
        let count = shaped.nrows() as f64;
        features.mean = (0..shaped.ncols())
            .map(|c| shaped.col(c).iter().sum::<f64>() / count)
            .collect();
        let squares: f64 = (0..shaped.ncols())
            .map(|c| {
                let mean = features.mean[c];
                shaped
                    .col(c)
                    .iter()
                    .map(|v| (v - mean) * (v - mean))
                    .sum::<f64>()
            })
            .sum();
        features.size =
            libm::sqrt(squares / (count * shaped.ncols() as f64)).max(f64::MIN_POSITIVE);
        features
    }

    /// The features of presses.
    pub(super) fn of(&self, changes: &Mat<f64>) -> Mat<f64> {
        let norms: Vec<f64> = (0..changes.nrows())
            .map(|row| {
                if self.recipe.unit {
                    process::norm(changes, row).max(f64::MIN_POSITIVE)
                } else {
                    1.0
                }
            })
            .collect();
        Mat::from_fn(changes.nrows(), changes.ncols(), |row, channel| {
            let change = changes[(row, channel)] / norms[row];
            let shaped = match self.recipe.shape {
                Shape::Root(power) => root(change, power),
                Shape::Log => libm::asinh(change / self.scale),
            };
            (self.weights[channel] * shaped - self.mean[channel]) / self.size
        })
    }
}

/// sign(d) |d|^p.
pub(super) fn root(change: f64, power: f64) -> f64 {
    libm::copysign(libm::pow(change.abs(), power), change)
}

/// Square root of the share of each channel's variance that the place explains when each press is left out; zero below
/// [`LEAST_EXPLAINED`]: loose and noisy channels.
pub(super) fn channel_weights(
    changes: &Mat<f64>,
    places: &Mat<f64>,
) -> Result<Vec<f64>, CalibrateError> {
    let rooted = Mat::from_fn(changes.nrows(), changes.ncols(), |r, c| {
        root(changes[(r, c)], 0.5)
    });
    let distances2 = process::squared_distances(places, places);
    let spread = spread(places);
    let mut explained = vec![0.0_f64; changes.ncols()];
    for values in [changes, &rooted] {
        let total = variances(values);
        for length in MAP_LENGTHS {
            for noise in MAP_NOISES {
                let hyper = Hyper {
                    length: length * spread,
                    noise,
                };
                let left_out = process::leave_one_out(&distances2, values, hyper)?;
                for (channel, best) in explained.iter_mut().enumerate() {
                    let residual2 = left_out.residuals.col(channel).squared_norm_l2();
                    if total[channel] > 0.0 {
                        *best = best.max(1.0 - residual2 / total[channel]);
                    }
                }
            }
        }
    }
    Ok(explained
        .into_iter()
        .map(|share| {
            if share < LEAST_EXPLAINED {
                0.0
            } else {
                libm::sqrt(share)
            }
        })
        .collect())
}

/// The linear map that stretches features along the directions in which the outputs change, from the mean outer product
/// of their gradients.
pub(super) fn stretch(outer_product: &Mat<f64>) -> Result<Mat<f64>, CalibrateError> {
    let eigen = outer_product
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| CalibrateError::Alike)?;
    let (vectors, values) = (eigen.U(), eigen.S().column_vector());
    let dimensions = outer_product.nrows();
    let total: f64 = (0..dimensions).map(|d| values[d].max(0.0)).sum();
    let unit = (total / dimensions as f64).max(f64::MIN_POSITIVE);
    Ok(Mat::from_fn(dimensions, dimensions, |row, d| {
        let share = values[d].max(0.0) / unit;
        vectors[(row, d)] * libm::pow(share + METRIC_FLOOR, METRIC_POWER)
    }))
}

/// Root of the mean squared distance of places from their middle, over sqrt 2: a deviation along an axis.
pub(super) fn spread(places: &Mat<f64>) -> f64 {
    let squares: f64 = variances(places).iter().sum();
    libm::sqrt(squares / (2.0 * places.nrows() as f64)).max(f64::MIN_POSITIVE)
}

/// Sum of squared deviations of each column.
fn variances(values: &Mat<f64>) -> Vec<f64> {
    (0..values.ncols())
        .map(|c| {
            let mean = values.col(c).iter().sum::<f64>() / values.nrows() as f64;
            values.col(c).iter().map(|v| (v - mean) * (v - mean)).sum()
        })
        .collect()
}

fn median_magnitude(changes: &Mat<f64>) -> f64 {
    let mut values: Vec<f64> = (0..changes.ncols())
        .flat_map(|c| changes.col(c).iter().map(|v| v.abs()))
        .collect();
    values.sort_by(f64::total_cmp);
    // Where most channels are silent, the loudest tells the scale.
    let median = values[values.len() / 2];
    if median > 0.0 {
        median
    } else {
        values[values.len() - 1].max(f64::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const RECIPES: [Recipe; 3] = [
        Recipe {
            shape: Shape::Root(0.5),
            unit: true,
            weighted: false,
        },
        Recipe {
            shape: Shape::Root(0.7),
            unit: true,
            weighted: true,
        },
        Recipe {
            shape: Shape::Log,
            unit: false,
            weighted: false,
        },
    ];

    proptest! {
        #[test]
        fn the_unit_of_the_changes_does_not_matter(
            values in proptest::collection::vec(-100.0..100.0f64, 30),
            unit in 1e-3..1e3f64,
        ) {
            let changes = Mat::from_fn(6, 5, |r, c| values[5 * r + c]);
            let scaled = Mat::from_fn(6, 5, |r, c| unit * values[5 * r + c]);
            for recipe in RECIPES {
                let weights = [1.0; 5];
                let a = Features::fit(recipe, &changes, &weights).of(&changes);
                let b = Features::fit(recipe, &scaled, &weights).of(&scaled);
                for r in 0..6 {
                    for c in 0..5 {
                        prop_assert!((a[(r, c)] - b[(r, c)]).abs() < 1e-9);
                    }
                }
            }
        }
    }

    #[test]
    fn a_channel_of_noise_weighs_nothing() {
        let mut noise = 0.1_f64;
        let places = Mat::from_fn(60, 2, |i, axis| ((i * (axis * 5 + 3)) % 17) as f64);
        let changes = Mat::from_fn(60, 2, |i, channel| {
            noise = (noise * 997.0 + 0.123).fract();
            if channel == 0 {
                places[(i, 0)] + 0.5 * places[(i, 1)]
            } else {
                noise - 0.5
            }
        });
        let weights = channel_weights(&changes, &places).expect("sound");
        assert!(weights[0] > 0.9, "{weights:?}");
        assert_eq!(weights[1], 0.0, "{weights:?}");
    }
}
